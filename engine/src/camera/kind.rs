//! The cameras that there are, by name.

use super::{Orthographic, Pinhole};
use crate::choice::choice;
use crate::stack::Camera;
use crate::view::View;

choice! {
    /// A kind of camera, for a point of view.
    "camera" CameraKind(view: View) -> Camera {
        /// All rays start at the eye.
        Pinhole = "pinhole" => Pinhole::new(view),
        /// All rays are parallel; what is at the point that is looked at is as large as a pinhole camera shows it.
        Orthographic = "orthographic" => Orthographic::new(view),
    }
}
