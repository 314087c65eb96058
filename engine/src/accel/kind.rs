//! Which acceleration structure finds the hits, chosen by name.

use crate::choice::choice;

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
