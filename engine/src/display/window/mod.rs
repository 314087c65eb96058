//! An interactive window: pictures arrive through a display of the pipeline, input leaves as transactions.
//!
//! Three threads matter: the window's (the process's first, as some systems demand), which never touches the state; the
//! pipeline's, which render; and whoever of those shows the picture, which copies it to where the window finds it.
//!
//! | file | what it holds |
//! |---|---|
//! | `screen` | the copy of the newest picture, and the display that makes it |
//! | `navigation` | mouse movements as movements of the view |
//! | `keys` | what each key does |
//! | `viewer` | the event loop's handler; in `viewer/keep`, what is shown as a picture, a scene file, and options |
//! | `open` | the window once it is open, and how pictures come into it |
//! | `volumes` | how what volumes are shown as is changed |
//! | `particles` | which particles are shown, and in which colours |
//! | `strips` | pictures that are too large for one request of X11 |
//! | `connection` | the window itself, from its opening to its end |
//! | `news` | what the window is told by others |

mod connection;
mod keys;
mod navigation;
mod news;
mod open;
mod particles;
mod screen;
mod strips;
mod viewer;
mod volumes;

pub use connection::{Connection, has_display};
pub use keys::HELP;
pub use news::{Titles, WindowError};
