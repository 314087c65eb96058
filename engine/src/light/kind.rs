//! The lights that there are, each with usual parameters.

use super::{Directional, Disk, Head, Point, Rectangle, Sphere, Spot, Sun};
use crate::choice::choice;
use crate::stack::Light;

choice! {
    /// A kind of light.
    "light" LightKind -> Light {
        /// From a point.
        Point = "point" => Point::default(),
        /// From a point into a cone.
        Spot = "spot" => Spot::default(),
        /// From infinitely far away, without extent.
        Directional = "directional" => Directional::default(),
        /// From a disk that is infinitely far away.
        Sun = "sun" => Sun::default(),
        /// From one side of a rectangle.
        Rectangle = "rectangle" => Rectangle::default(),
        /// From one side of a disk.
        Disk = "disk" => Disk::default(),
        /// From a sphere.
        Sphere = "sphere" => Sphere::default(),
        /// From the eye.
        Camera = "camera" => Head::default(),
    }
}
