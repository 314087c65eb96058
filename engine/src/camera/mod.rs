//! Cameras, and where they stand.

mod pinhole;
mod view;

pub use pinhole::Pinhole;
pub use view::{Up, View};
