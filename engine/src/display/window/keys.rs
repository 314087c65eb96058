//! What each key does: one table, from which keys are looked up, and which people are shown.

use std::sync::LazyLock;

use winit::keyboard::{Key, NamedKey};

use crate::camera::Side;

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
    /// Edges of triangles, or what was shown before.
    Wireframe,
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
    /// Back to the first view.
    Home,
    /// All of the scene, seen from there.
    Side(Side),
    /// All of the scene, seen as now.
    Fit,
    Turntable,
    Fly,
    /// What is under the mouse.
    Pick,
    FullScreen,
    Reload,
    /// A view that was kept.
    Recall(u8),
    Help,
    Status,
    Legend,
    Close,
}

/// A key as the system names it.
#[derive(Clone, Copy, Debug)]
enum Pressed {
    /// What it types; upper case is the same.
    Types(&'static str),
    Named(NamedKey),
}

use Pressed::{Named, Types};

/// A line of the help.
pub(super) struct Row {
    /// The keys, or what is done with the mouse.
    pub(super) keys: &'static str,
    pub(super) what: &'static str,
    actions: &'static [(Pressed, Action)],
}

const fn row(keys: &'static str, what: &'static str, actions: &'static [(Pressed, Action)]) -> Row {
    Row { keys, what, actions }
}

/// The rows, in groups with a heading each.
pub(super) const GROUPS: &[(&str, &[Row])] = &[
    (
        "Mouse",
        &[
            row("left drag", "orbit", &[]),
            row("right drag, shift+left", "pan", &[]),
            row("wheel", "towards what is there, away", &[]),
            row("click, x", "what is there", &[(Types("x"), Action::Pick)]),
            row("double click", "that into the middle", &[]),
            row("ctrl+left drag", "level and width; or iso values", &[]),
        ],
    ),
    (
        "View",
        &[
            row("f", "all of the scene", &[(Types("f"), Action::Fit)]),
            row(
                "1 2 3 4 5 6",
                "front, back, right, left, top, bottom",
                &[
                    (Types("1"), Action::Side(Side::Front)),
                    (Types("2"), Action::Side(Side::Back)),
                    (Types("3"), Action::Side(Side::Right)),
                    (Types("4"), Action::Side(Side::Left)),
                    (Types("5"), Action::Side(Side::Top)),
                    (Types("6"), Action::Side(Side::Bottom)),
                ],
            ),
            row(
                "7 8 9",
                "a view that was kept; with ctrl: keep it",
                &[(Types("7"), Action::Recall(0)), (Types("8"), Action::Recall(1)), (Types("9"), Action::Recall(2))],
            ),
            row(
                "0, Home",
                "back to the first view",
                &[(Types("0"), Action::Home), (Named(NamedKey::Home), Action::Home)],
            ),
            row("u", "turn slowly, stop", &[(Types("u"), Action::Turntable)]),
            row("g", "fly: w a s d, e up, q down; g, Esc: stop", &[(Types("g"), Action::Fly)]),
        ],
    ),
    (
        "Picture",
        &[
            row("r", "next renderer", &[(Types("r"), Action::Renderer)]),
            row("w", "edges of triangles on, off", &[(Types("w"), Action::Wireframe)]),
            row("s", "shadows on, off", &[(Types("s"), Action::Shadows)]),
            row("o", "ambient occlusion on, off", &[(Types("o"), Action::Occlusion)]),
            row("a", "antialiasing on, off", &[(Types("a"), Action::Antialiasing)]),
            row("e", "next tone curve", &[(Types("e"), Action::Tone)]),
            row(
                "; '",
                "darker, brighter",
                &[
                    (Types(";"), Action::Exposure(-1)),
                    (Types(":"), Action::Exposure(-1)),
                    (Types("'"), Action::Exposure(1)),
                    (Types("\""), Action::Exposure(1)),
                ],
            ),
            row(
                "+ -",
                "more, fewer threads",
                &[
                    (Types("+"), Action::MoreThreads),
                    (Types("="), Action::MoreThreads),
                    (Types("-"), Action::FewerThreads),
                    (Types("_"), Action::FewerThreads),
                ],
            ),
        ],
    ),
    (
        "Volumes and particles",
        &[
            row(
                ". ,",
                "iso-surfaces at greater, less values",
                &[
                    (Types("."), Action::Iso(1)),
                    (Types(">"), Action::Iso(1)),
                    (Types(","), Action::Iso(-1)),
                    (Types("<"), Action::Iso(-1)),
                ],
            ),
            row(
                "] [",
                "level: transfer function, particles",
                &[(Types("]"), Action::Level(1)), (Types("["), Action::Level(-1))],
            ),
            row("} {", "wider, narrower", &[(Types("}"), Action::Width(1)), (Types("{"), Action::Width(-1))]),
            row("c", "these for particles, not for media", &[(Types("c"), Action::InHand)]),
            row("t", "next transfer function", &[(Types("t"), Action::Transfer)]),
            row("b", "particles by the next attribute", &[(Types("b"), Action::ColorBy)]),
            row("m", "next colour map of particles", &[(Types("m"), Action::Map)]),
        ],
    ),
    (
        "Time",
        &[
            row("space", "time goes on, stops", &[(Types(" "), Action::Play), (Named(NamedKey::Space), Action::Play)]),
            row(
                "Right Left",
                "next step of time, the one before",
                &[(Named(NamedKey::ArrowRight), Action::Step(1)), (Named(NamedKey::ArrowLeft), Action::Step(-1))],
            ),
            row(
                "Up Down",
                "time goes faster, slower",
                &[(Named(NamedKey::ArrowUp), Action::Faster), (Named(NamedKey::ArrowDown), Action::Slower)],
            ),
        ],
    ),
    (
        "Window",
        &[
            row(
                "h",
                "this help: next page, hidden",
                &[(Types("h"), Action::Help), (Types("?"), Action::Help), (Named(NamedKey::F1), Action::Help)],
            ),
            row("i", "what is rendered and how fast", &[(Types("i"), Action::Status)]),
            row("l", "what colours mean", &[(Types("l"), Action::Legend)]),
            row("p", "screenshot: mobula-0001.png, ...", &[(Types("p"), Action::Screenshot)]),
            row("v", "scene file: mobula-0001.toml, ...", &[(Types("v"), Action::Save)]),
            row("F5", "load the files again", &[(Named(NamedKey::F5), Action::Reload)]),
            row("F11", "full screen", &[(Named(NamedKey::F11), Action::FullScreen)]),
            row(
                "q, Esc",
                "close; while loading: cancel",
                &[(Types("q"), Action::Close), (Named(NamedKey::Escape), Action::Close)],
            ),
        ],
    ),
];

/// The keys and the mouse, for people: a line each.
pub fn help() -> &'static str {
    static TEXT: LazyLock<String> = LazyLock::new(|| {
        let rows = GROUPS.iter().flat_map(|(_, rows)| rows.iter());
        let lines: Vec<String> = rows.map(|Row { keys, what, .. }| format!("  {keys:<24}{what}")).collect();
        lines.join("\n")
    });
    &TEXT
}

/// What a key asks for, if anything.
pub(super) fn action(key: &Key) -> Option<Action> {
    let is = |pressed: &Pressed| match (pressed, key) {
        (Types(text), Key::Character(typed)) => typed.eq_ignore_ascii_case(text),
        (Named(name), Key::Named(pressed)) => name == pressed,
        _ => false,
    };
    let mut all = GROUPS.iter().flat_map(|(_, rows)| rows.iter()).flat_map(|row| row.actions);
    all.find(|(pressed, _)| is(pressed)).map(|&(_, action)| action)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_key_does_one_thing() {
        let all: Vec<_> = GROUPS.iter().flat_map(|(_, rows)| rows.iter()).flat_map(|row| row.actions).collect();
        let name = |(pressed, _): &(Pressed, Action)| format!("{pressed:?}");
        for (i, one) in all.iter().enumerate() {
            assert!(all[..i].iter().all(|other| name(other) != name(one)), "{} is there twice", name(one));
        }
    }

    #[test]
    fn keys_are_found_whatever_their_case() {
        for typed in ["h", "H"] {
            assert_eq!(action(&Key::Character(typed.into())), Some(Action::Help));
        }
        assert_eq!(action(&Key::Named(NamedKey::Escape)), Some(Action::Close));
        assert_eq!(action(&Key::Character("\u{e4}".into())), None);
    }

    #[test]
    fn help_has_a_line_for_each_row() {
        assert_eq!(help().lines().count(), GROUPS.iter().map(|(_, rows)| rows.len()).sum::<usize>());
        assert!(help().lines().all(|line| line.len() < 80 && line.is_ascii()), "{}", help());
    }
}
