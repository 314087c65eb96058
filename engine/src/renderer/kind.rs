//! The renderers that there are, by name.

use super::{AmbientOcclusion, Inspect, Primary, Quantity, Raytracer};
use crate::choice::choice;
use crate::stack::Renderer;

choice! {
    /// A renderer.
    "renderer" RendererKind -> Renderer {
        /// Materials, lights, shadows, reflections.
        Raytracer = "raytracer" => Raytracer::default(),
        /// How open the sky is above each point, in white: ambient occlusion.
        AmbientOcclusion = "ao" => AmbientOcclusion,
        /// The base colour of each material: primary rays and nothing else.
        Primary = "primary" => Primary,
        /// The shading normal as a colour.
        Normal = "normal" => Inspect(Quantity::Normal),
        /// Brighter is nearer.
        Depth = "depth" => Inspect(Quantity::Depth),
        /// Texture coordinates as red and green.
        Uv = "uv" => Inspect(Quantity::TextureCoordinates),
        /// The colours of surfaces, unlit.
        Albedo = "albedo" => Inspect(Quantity::Albedo),
        /// The edges of triangles, over greys.
        Wireframe = "wireframe" => Inspect(Quantity::Edges),
        /// A colour for each primitive.
        Id = "id" => Inspect(Quantity::Primitive),
    }
}
