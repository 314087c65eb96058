//! The lights that there are, each with usual parameters.

use super::{Directional, Point};
use crate::choice::choice;
use crate::stack::Light;

choice! {
    /// A kind of light.
    "light" LightKind -> Light {
        /// From a point.
        Point = "point" => Point::default(),
        /// From infinitely far away: the sun.
        Directional = "directional" => Directional::default(),
    }
}
