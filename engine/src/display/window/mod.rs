//! An interactive window: pictures arrive through a display of the pipeline, input leaves as transactions.
//!
//! Three threads matter: the window's (the process's first, as some systems demand), which never touches the state; the
//! pipeline's, which render; and whoever of those shows the picture, which copies it to where the window finds it.
//!
//! | file | what it holds |
//! |---|---|
//! | `connection` | the window itself, from its opening to its end |
//! | `viewer` | the event loop's handler; in `viewer/mouse` and `viewer/moves`, how the view is moved; in `viewer/overlay`, what the window says; in `viewer/keep`, what is shown as a picture, a scene file, and options |
//! | `help` | the table of keys over the picture |
//! | `engine` | a scene that is shown, and what was asked of it |
//! | `loading` | scenes on their way, and files that change |
//! | `open` | the window once it is open, and how pictures come into it |
//! | `volumes` | how what volumes are shown as is changed |
//! | `particles` | which particles are shown, and in which colours |
//! | `screen` | the copy of the newest picture, and the display that makes it |
//! | `strips` | pictures that are too large for one request of X11 |
//! | `navigation` | mouse movements as movements of the view |
//! | `travel` | views that move by themselves |
//! | `keys` | what each key does |
//! | `news` | what the window is told by others |

mod connection;
mod engine;
mod help;
mod keys;
mod loading;
mod navigation;
mod news;
mod open;
mod particles;
mod screen;
mod strips;
mod travel;
mod viewer;
mod volumes;

pub use connection::{Connection, has_display};
pub use engine::SAMPLES;
pub use keys::help;
pub use loading::Loader;
pub use news::{Ready, Titles, WindowError};
