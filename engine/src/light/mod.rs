//! Lights: what reaches points, as if nothing were in the way.
//!
//! A new light is a file with the trait [`Light`], and a line in [`LightKind`].

mod area;
mod directional;
mod disk;
mod environment;
mod head;
mod hemisphere;
mod kind;
mod point;
mod rectangle;
mod sphere;
mod spot;
mod sun;
#[cfg(test)]
mod tests;

pub use directional::Directional;
pub use disk::Disk;
pub(crate) use environment::luminance;
pub use environment::{Environment, direction, place};
pub use head::Head;
pub use hemisphere::Hemisphere;
pub use kind::LightKind;
pub use point::Point;
pub use rectangle::Rectangle;
pub use sphere::Sphere;
pub use spot::Spot;
pub use sun::Sun;

pub use crate::stack::{AmbientLight, Light};
