//! What each key does.

use winit::keyboard::{Key, NamedKey};

/// The keys and the mouse, for people.
pub const HELP: &str = "  \
  left drag               orbit
  right drag, shift+left  pan
  wheel                   nearer, farther
  s                       shadows on, off
  o                       ambient occlusion on, off
  e                       next tone curve
  ; '                     darker, brighter
  a                       antialiasing on, off
  r                       next renderer
  + -                     more, fewer threads
  . ,                     iso-surfaces at greater, less values
  ] [                     level of the transfer function, or of particles shown
  } {                     wider, narrower
  ctrl+left drag          level and width; or iso values
  c                       these for particles, where there is a medium; and back
  b                       colours of particles by the next attribute
  m                       next colour map of particles
  t                       next transfer function
  space                   time goes on, stops
  Right Left              next step of time, the one before
  Up Down                 time goes faster, slower
  l                       what colours mean: shown, hidden
  p                       screenshot: mobula-0001.png, ...
  v                       the view as a scene file: mobula-0001.toml, ...
  0, Home                 back to the first view
  h                       this help
  q, Esc                  close";

/// What a key asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Action {
    Shadows,
    Occlusion,
    Tone,
    /// Exposure, by so many steps.
    Exposure(i8),
    Antialiasing,
    Renderer,
    MoreThreads,
    FewerThreads,
    /// Iso values, by so many steps.
    Iso(i8),
    /// Level and width of transfer functions.
    Level(i8),
    Width(i8),
    Transfer,
    /// Whether these move particles instead.
    InHand,
    ColorBy,
    Map,
    /// Another step of time.
    Step(i8),
    Play,
    Faster,
    Slower,
    Screenshot,
    Save,
    Reset,
    Help,
    Legend,
    Close,
}

/// What a key asks for, if anything.
pub(super) fn action(key: &Key) -> Option<Action> {
    Some(match key.as_ref() {
        Key::Character("s" | "S") => Action::Shadows,
        Key::Character("o" | "O") => Action::Occlusion,
        Key::Character("e" | "E") => Action::Tone,
        Key::Character("'" | "\"") => Action::Exposure(1),
        Key::Character(";" | ":") => Action::Exposure(-1),
        Key::Character("a" | "A") => Action::Antialiasing,
        Key::Character("r" | "R") => Action::Renderer,
        Key::Character("+" | "=") => Action::MoreThreads,
        Key::Character("-" | "_") => Action::FewerThreads,
        Key::Character("." | ">") => Action::Iso(1),
        Key::Character("," | "<") => Action::Iso(-1),
        Key::Character("]") => Action::Level(1),
        Key::Character("[") => Action::Level(-1),
        Key::Character("}") => Action::Width(1),
        Key::Character("{") => Action::Width(-1),
        Key::Character("t" | "T") => Action::Transfer,
        Key::Character("c" | "C") => Action::InHand,
        Key::Character("b" | "B") => Action::ColorBy,
        Key::Character("m" | "M") => Action::Map,
        Key::Character(" ") | Key::Named(NamedKey::Space) => Action::Play,
        Key::Named(NamedKey::ArrowRight) => Action::Step(1),
        Key::Named(NamedKey::ArrowLeft) => Action::Step(-1),
        Key::Named(NamedKey::ArrowUp) => Action::Faster,
        Key::Named(NamedKey::ArrowDown) => Action::Slower,
        Key::Character("p" | "P") => Action::Screenshot,
        Key::Character("v" | "V") => Action::Save,
        Key::Character("0") | Key::Named(NamedKey::Home) => Action::Reset,
        Key::Character("h" | "H" | "?") | Key::Named(NamedKey::F1) => Action::Help,
        Key::Character("l" | "L") => Action::Legend,
        Key::Character("q" | "Q") | Key::Named(NamedKey::Escape) => Action::Close,
        _ => return None,
    })
}
