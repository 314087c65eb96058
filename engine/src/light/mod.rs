//! Lights: what reaches points, as if nothing were in the way.
//!
//! A new light is a file with the trait [`Light`], and a line in [`LightKind`].

mod directional;
mod hemisphere;
mod kind;
mod point;

pub use directional::Directional;
pub use hemisphere::Hemisphere;
pub use kind::LightKind;
pub use point::Point;

pub use crate::stack::{AmbientLight, Light};
