//! Which acceleration structure finds the hits, chosen by name.

mod brute;

use std::sync::Arc;

use crate::choice::choice;
use crate::scene::Geometry;
use crate::stack::AccelerationStructure;

use brute::Brute;

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
    pub fn build<const N: usize>(self, geometry: &Arc<Geometry>) -> Box<dyn AccelerationStructure<N>> {
        match self {
            Self::Bvh | Self::Brute => Box::new(Brute::new(geometry)),
        }
    }
}
