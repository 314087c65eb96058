//! Which acceleration structure finds the hits, chosen by name.

mod hierarchy;
mod threads;

use crate::choice::choice;
use crate::scene::Geometry;
use crate::stack::AccelerationStructure;

use hierarchy::Hierarchy;

choice! {
    /// An acceleration structure.
    "acceleration structure" AccelerationKind {
        /// Bounding volume hierarchy with eight children a node.
        Bvh = "bvh",
        /// None: every ray tries every primitive. The other structures must agree with it.
        Brute = "brute",
    }
}

impl AccelerationKind {
    /// Builds it over all primitives of `geometry` that were not left out.
    pub fn build<const N: usize>(self, geometry: &Geometry) -> Box<dyn AccelerationStructure<N>> {
        Box::new(Hierarchy::new(geometry, self == Self::Brute))
    }
}
