//! The scene: as loaders make it, and ready to be rendered.
//!
//! [`SceneDescription`] is what loaders and generators make; [`build`] makes a [`Scene`] of it, with structures that find hits.

mod build;
mod bulk;
mod description;

pub use build::{build, with_geometry};
pub use description::SceneDescription;

pub use crate::geometry::{Geometries, Geometry, Mesh, MeshGroup, NeedsRebuild, SceneError, Spheres};
pub use crate::stack::Scene;
