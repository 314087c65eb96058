//! Renderers: what is computed for a packet of rays.

mod inspect;
mod primary;
mod raytracer;
mod runs;

use std::sync::Arc;

pub use inspect::{Inspect, Quantity};
pub use primary::Primary;
pub use raytracer::Raytracer;

use crate::choice::choice;
use crate::stack::Renderer;

choice! {
    /// A renderer.
    "renderer" RendererKind {
        /// Materials, lights, shadows, reflections.
        Raytracer = "raytracer",
        /// The base colour of each material: primary rays and nothing else.
        Primary = "primary",
        /// The shading normal as a colour.
        Normal = "normal",
        /// Brighter is nearer.
        Depth = "depth",
        /// Texture coordinates as red and green.
        Uv = "uv",
        /// A colour for each primitive.
        Id = "id",
    }
}

impl RendererKind {
    /// Makes it.
    pub fn build<const N: usize>(self) -> Arc<dyn Renderer<N>> {
        match self {
            Self::Raytracer => Arc::new(Raytracer::default()),
            Self::Primary => Arc::new(Primary),
            Self::Normal => Arc::new(Inspect(Quantity::Normal)),
            Self::Depth => Arc::new(Inspect(Quantity::Depth)),
            Self::Uv => Arc::new(Inspect(Quantity::TextureCoordinates)),
            Self::Id => Arc::new(Inspect(Quantity::Primitive)),
        }
    }
}
