//! The kinds of geometry that there are, with an example of each.

use std::sync::Arc;

use super::{Geometry, Mesh, Spheres};

/// A kind of geometry.
#[derive(Clone, Copy, Debug)]
pub struct Kind {
    /// Its name.
    pub name: &'static str,
    /// A small example: something around the origin, within 1 of it, with the default material.
    pub example: fn() -> Arc<dyn Geometry>,
}

/// All kinds: a new one is a file and a line here.
pub const KINDS: &[Kind] = &[
    Kind { name: "mesh", example: || Arc::new(Mesh::example()) },
    Kind { name: "spheres", example: || Arc::new(Spheres::example()) },
];
