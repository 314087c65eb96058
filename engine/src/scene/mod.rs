//! The scene: as plain data, and compiled for one packet width.
//!
//! [`SceneDescription`] is what loaders make; [`Geometry`] gives its primitives ids and knows their surfaces;
//! [`Scene`] joins that with an acceleration structure, materials, lights and a background.

mod compiled;
mod description;
mod geometry;
mod mesh;
mod spheres;
mod surface;

pub use compiled::Scene;
pub use description::{
    AmbientDescription, BackgroundDescription, DEFAULT_MATERIAL, LightDescription, MaterialDescription, NamedMaterial,
    Object, PhongDescription, SceneDescription,
};
pub use geometry::{Geometry, GeometryReport, Part, SceneError, Shape};
pub use mesh::{Mesh, MeshGroup, NO_INDEX};
pub use spheres::Spheres;
