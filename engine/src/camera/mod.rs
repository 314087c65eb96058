//! Cameras: rays from image coordinates.
//!
//! A new camera is a file with the trait [`Camera`], and a line in [`CameraKind`].

mod environment;
mod fisheye;
mod kind;
mod orthographic;
mod pinhole;
mod thin_lens;

pub use environment::Environment;
pub use fisheye::Fisheye;
pub use kind::CameraKind;
pub use orthographic::Orthographic;
pub use pinhole::Pinhole;
pub use thin_lens::ThinLens;

pub use crate::stack::Camera;
pub use crate::view::{Lens, Side, Up, View};
