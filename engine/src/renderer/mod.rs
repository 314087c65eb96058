//! Renderers: what is computed for a packet of rays.
//!
//! A new renderer is a file with the trait [`Renderer`], and a line in [`RendererKind`].

mod inspect;
mod kind;
mod openness;
mod primary;
mod raytracer;
#[cfg(test)]
mod tests;

pub use inspect::{Inspect, Quantity};
pub use kind::RendererKind;
pub use openness::AmbientOcclusion;
pub use primary::Primary;
pub use raytracer::Raytracer;

pub use crate::stack::Renderer;
