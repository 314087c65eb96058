//! The acceleration structure: a bounding volume hierarchy with eight children a node.
//!
//! Wald, Benthin and Boulos, "Getting Rid of Packets", RT 2008 (wide nodes). How it is built:
//!
//! | file | what it does |
//! |---|---|
//! | `reference.rs` | bounds and number of a primitive in eight floats |
//! | `sah.rs` | good trees: ranges split by the surface area heuristic over bins |
//! | `morton.rs` | fast trees: ranges of the order along a curve |
//! | `frame.rs` | what the coordinates of boxes are relative to |
//! | `centroids.rs` | what both split: where the middles of primitives are |
//! | `wide.rs` | eight children a node, from ranges that know how to split |
//! | `refit.rs` | blocks, then bounds from the leaves up: the end of a build, and all of a refit |
//! | `tree.rs` | what walks need of it |
//! | `memory.rs` | memory in large pages |
//! | `join.rs` | threads that somebody else has; the tree is the same bytes without them |

mod build;
mod centroids;
mod frame;
mod join;
mod memory;
mod morton;
pub mod node;
mod reference;
mod refit;
mod sah;
mod tree;
mod wide;

use alloc::vec::Vec;

pub use build::Quality;
pub use join::{Join, Serial};
pub use node::{Child, Node};
pub use tree::Tree;
pub(crate) use wide::STACK;

use crate::kernel::margin::Frame;
use crate::leaf::{Block, Bounds};

/// Bounding volume hierarchy with eight children a node. What is in its leaves is for `L` to know: see
/// [`Leaf`](crate::leaf::Leaf).
///
/// Nodes lie depth first: behind a node come the subtrees of its children, one after the other by rising slots, and leaves
/// lie in the order in which nodes name them. So a subtree is a range of nodes and a range of what leaves are stored as.
#[derive(Clone, Debug)]
pub struct WideBvh<L> {
    pub(crate) nodes: Vec<Node>,
    pub(crate) leaves: L,
    /// How many entries the leaves have all together.
    pub(crate) leaf_count: usize,
    pub(crate) root: Child,
    pub(crate) bounds: Bounds,
    /// What the coordinates of boxes are relative to.
    pub(crate) frame: Frame,
    primitives: usize,
    /// Id of primitive 0.
    first_id: u32,
}

/// Hierarchy over primitives of one kind, stored as blocks of four.
pub type Bvh<B> = WideBvh<Vec<B>>;

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
        self.nodes.len() * size_of::<Node>() + self.leaves.len() * size_of::<B>()
    }

    /// The same tree with other blocks.
    pub(crate) fn with_blocks<C: Block>(self, of: impl Fn(&B) -> C) -> Bvh<C> {
        let Self { nodes, leaves, leaf_count, root, bounds, frame, primitives, first_id } = self;
        let leaves = memory::filled(leaves.len(), leaves.iter().map(of));
        Bvh { nodes, leaves, leaf_count, root, bounds, frame, primitives, first_id }
    }
}
