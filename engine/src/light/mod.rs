//! Lights, and what stands before them.

mod ambient;
mod directional;
mod point;
pub mod shadow;

use std::sync::Arc;

pub use ambient::Ambient;
pub use directional::Directional;
pub use point::Point;

use crate::scene::LightDescription;
use crate::stack::Light;

/// The light that a description describes.
pub fn build<const N: usize>(description: &LightDescription) -> Arc<dyn Light<N>> {
    match *description {
        LightDescription::Point { position, color, falloff } => Arc::new(Point { position, color, falloff }),
        LightDescription::Directional { direction, color } => Arc::new(Directional::new(direction, color)),
    }
}
