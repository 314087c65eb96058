//! The acceleration structure: a bounding volume hierarchy with eight children a node.
//!
//! Wald, Benthin and Boulos, "Getting Rid of Packets", RT 2008 (wide nodes). How it is built:
//!
//! | file | what it does |
//! |---|---|
//! | `reference.rs` | bounds and number of a primitive in eight floats |
//! | `sah.rs` | good trees: ranges split by the surface area heuristic over bins |
//! | `morton.rs` | fast trees: ranges of the order along a curve |
//! | `wide.rs` | eight children a node, from ranges that know how to split |
//! | `refit.rs` | blocks, then bounds from the leaves up: the end of a build, and all of a refit |
//! | `join.rs` | threads that somebody else has; the tree is the same bytes without them |

pub mod block;
pub mod bounds;
mod build;
mod join;
mod morton;
pub mod node;
mod reference;
mod refit;
mod sah;
pub mod sphere_block;
pub mod triangle_block;
mod wide;

use alloc::vec::Vec;

pub use block::Block;
pub use bounds::Bounds;
pub use build::Quality;
pub use join::{Join, Serial};
pub use node::{Child, Node};
pub use sphere_block::SphereBlock;
pub use triangle_block::TriangleBlock;
pub(crate) use wide::STACK;

/// Eight-wide BVH over primitives of one kind, stored as blocks of four in leaves.
///
/// Nodes lie depth first: behind a node come the subtrees of its children, one after the other by rising slots, and the
/// blocks lie in the order in which nodes name them. So a subtree is a range of nodes and a range of blocks.
#[derive(Clone, Debug)]
pub struct Bvh<B> {
    pub(crate) nodes: Vec<Node>,
    pub(crate) blocks: Vec<B>,
    pub(crate) root: Child,
    pub(crate) bounds: Bounds,
    /// Greatest size of a coordinate: what the rounding of a test is measured by.
    pub(crate) scale: f32,
    primitives: usize,
    /// Id of primitive 0.
    first_id: u32,
}

impl<B: Block> Bvh<B> {
    /// Bounds of all primitives; [`Bounds::EMPTY`] if there are none.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// Number of primitives inside: what was given, less what is degenerate.
    pub fn primitives(&self) -> usize {
        self.primitives
    }

    /// Number of nodes.
    pub fn nodes(&self) -> usize {
        self.nodes.len()
    }

    /// Bytes that it occupies.
    pub fn bytes(&self) -> usize {
        self.nodes.len() * size_of::<Node>() + self.blocks.len() * size_of::<B>()
    }
}
