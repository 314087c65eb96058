//! Cameras, and where they stand.

mod view;

pub use view::{Up, View};
