//! The cameras that there are, by name.

use super::{Environment, Fisheye, Orthographic, Pinhole, ThinLens};
use crate::choice::choice;
use crate::stack::Camera;
use crate::view::{Lens, View};

choice! {
    /// A kind of camera, for a point of view; some have a lens.
    "camera" CameraKind(view: View, lens: Lens) -> Camera {
        /// All rays start at the eye.
        Pinhole = "pinhole" => Pinhole::new(view),
        /// All rays are parallel; what is at the point that is looked at is as large as a pinhole camera shows it.
        Orthographic = "orthographic" => Orthographic::new(view),
        /// Rays start on a lens: what is not at the distance of focus is blurred.
        ThinLens = "thin-lens" => ThinLens::new(view, lens),
        /// All around: 360 by 180 degrees.
        Environment = "environment" => Environment::new(view),
        /// A circle of up to 360 degrees.
        Fisheye = "fisheye" => Fisheye::new(view),
    }
}

impl CameraKind {
    /// The greatest vertical field of view, degrees.
    pub const fn widest(self) -> f32 {
        match self {
            Self::Fisheye => 360.0,
            _ => View::WIDEST,
        }
    }
}
