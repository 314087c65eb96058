//! The kinds of geometry that there are, with an example of each.

use std::sync::Arc;

use super::{Geometry, IsoSurfaces, Mesh, MeshSequence, Particles, Spheres};

/// A kind of geometry.
#[derive(Clone, Copy, Debug)]
pub struct Kind {
    /// Its name.
    pub name: &'static str,
    /// A small example: something around the origin, within 1 of it, with the material of an index.
    pub example: fn(material: u32) -> Arc<dyn Geometry>,
}

/// All kinds: a new one is a file and a line here.
pub const KINDS: &[Kind] = &[
    Kind { name: "mesh", example: |material| Arc::new(Mesh::example(material)) },
    Kind { name: "mesh over time", example: |material| Arc::new(MeshSequence::example(material)) },
    Kind { name: "spheres", example: |material| Arc::new(Spheres::example(material)) },
    Kind { name: "particles", example: |material| Arc::new(Particles::example(material)) },
    Kind { name: "iso-surfaces", example: |material| Arc::new(IsoSurfaces::example(material)) },
];
