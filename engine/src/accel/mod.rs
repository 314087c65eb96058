//! Which acceleration structure finds the hits, chosen by name.

mod hierarchy;
mod threads;

use mobula_core::bvh::Quality;

use crate::choice::choice;
use crate::scene::Geometry;
use crate::stack::AccelerationStructure;

use hierarchy::Hierarchy;

choice! {
    /// An acceleration structure.
    "acceleration structure" AccelerationKind {
        /// Bounding volume hierarchy with eight children a node.
        Bvh = "bvh",
        /// The same, built in half the time or less and slower to trace: for scenes that are built anew each frame.
        Fast = "bvh-fast",
        /// None: every ray tries every primitive. The other structures must agree with it.
        Brute = "brute",
    }
}

impl AccelerationKind {
    /// Builds it over all primitives of `geometry` that were not left out. Shadow rays meet only those of materials that
    /// `casts_shadow`, which is asked with material indices as they are in the meshes.
    pub fn build<const N: usize>(
        self,
        geometry: &Geometry,
        casts_shadow: &(dyn Fn(u32) -> bool + Sync),
    ) -> Box<dyn AccelerationStructure<N>> {
        let quality = if self == Self::Bvh { Quality::Good } else { Quality::Fast };
        Box::new(Hierarchy::new(geometry, casts_shadow, quality, self == Self::Brute))
    }
}
