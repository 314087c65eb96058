//! Which acceleration structure finds the hits, chosen by name.

use crate::choice::choice;
use crate::progress::Progress;

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

/// How structures are built.
#[derive(Clone, Debug)]
pub struct Build {
    /// Which structure.
    pub kind: AccelerationKind,
    /// Where the primitives are counted that are done: each twice.
    pub progress: Progress,
}

impl From<AccelerationKind> for Build {
    fn from(kind: AccelerationKind) -> Self {
        Self { kind, progress: Progress::default() }
    }
}
