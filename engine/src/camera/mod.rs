//! Cameras: rays from image coordinates.
//!
//! A new camera is a file with the trait [`Camera`], and a line in [`CameraKind`].

mod kind;
mod orthographic;
mod pinhole;

pub use kind::CameraKind;
pub use orthographic::Orthographic;
pub use pinhole::Pinhole;

pub use crate::stack::Camera;
pub use crate::view::{Side, Up, View};
