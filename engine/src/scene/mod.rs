//! The scene: as plain data, and compiled for one packet width.

mod description;
mod mesh;
mod spheres;

pub use description::{
    AmbientDescription, BackgroundDescription, DEFAULT_MATERIAL, LightDescription, MaterialDescription, NamedMaterial,
    Object, PhongDescription, SceneDescription,
};
pub use mesh::{Mesh, MeshGroup, NO_INDEX};
pub use spheres::Spheres;
