//! The backgrounds that there are, by name.

use glam::Vec3;

use super::{Constant, Gradient};
use crate::choice::choice;
use crate::stack::Background;

choice! {
    /// A background.
    "background" BackgroundKind -> Background {
        /// A pale sky over a warm floor.
        Sky = "sky" => Gradient::default(),
        /// Nothing.
        Black = "black" => Constant { color: Vec3::ZERO },
        /// Paper.
        White = "white" => Constant { color: Vec3::ONE },
    }
}
