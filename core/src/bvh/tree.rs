//! What a walk needs of a tree: nodes of eight children, whether they are stored or made when they are asked for.

use mobula_simd::prefetch;

use super::{Child, Node, WideBvh};
use crate::kernel::margin::Frame;
use crate::leaf::Leaf;

/// A tree of nodes with eight children, as the [walks](crate::traverse) see it.
pub trait Tree: Send + Sync {
    /// What is in its leaves.
    type Leaves: Leaf;

    /// The leaves.
    fn leaves(&self) -> &Self::Leaves;

    /// What the coordinates of boxes are relative to.
    fn frame(&self) -> &Frame;

    /// Where walks begin.
    fn root(&self) -> Child;

    /// The node with an index. One that is not stored is made in `room`.
    fn node<'a>(&'a self, index: usize, room: &'a mut Node) -> Option<&'a Node>;

    /// Asks for what a child holds before it is visited.
    fn prefetch(&self, child: Child);

    /// Leaf number `i`, for who tests all; `None` if there are not so many.
    fn leaf(&self, i: usize) -> Option<Child>;
}

impl<L: Leaf> Tree for WideBvh<L> {
    type Leaves = L;

    #[inline(always)]
    fn leaves(&self) -> &L {
        &self.leaves
    }

    #[inline(always)]
    fn frame(&self) -> &Frame {
        &self.frame
    }

    #[inline(always)]
    fn root(&self) -> Child {
        self.root
    }

    #[inline(always)]
    fn node<'a>(&'a self, index: usize, _room: &'a mut Node) -> Option<&'a Node> {
        self.nodes.get(index)
    }

    #[inline(always)]
    fn prefetch(&self, child: Child) {
        if child.is_leaf() {
            self.leaves.prefetch(child.leaf_range());
        } else if let Some(node) = self.nodes.get(child.index()) {
            prefetch(node);
        }
    }

    #[inline(always)]
    fn leaf(&self, i: usize) -> Option<Child> {
        (i < self.leaf_count).then(|| Child::leaf(i, 1))
    }
}
