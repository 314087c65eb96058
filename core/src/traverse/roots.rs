//! Where walks start, and what they ask for before they get there.

use mobula_simd::prefetch;

use crate::bvh::{Child, WideBvh};
use crate::leaf::Leaf;

/// Where walks start: at the tree's root, or at every leaf, as if there were no tree.
#[derive(Clone, Copy, Debug)]
pub(super) struct Roots {
    root: Option<Child>,
    next: usize,
    end: usize,
}

impl Roots {
    pub(super) fn tree<L>(bvh: &WideBvh<L>) -> Self {
        Self { root: Some(bvh.root), next: 0, end: 1 }
    }

    pub(super) fn all<L>(bvh: &WideBvh<L>) -> Self {
        Self { root: None, next: 0, end: bvh.leaf_count }
    }
}

impl Iterator for Roots {
    type Item = Child;

    #[inline(always)]
    fn next(&mut self) -> Option<Child> {
        let here = self.next;
        self.next += 1;
        (here < self.end).then(|| self.root.unwrap_or_else(|| Child::leaf(here, 1)))
    }
}

impl<L: Leaf> WideBvh<L> {
    /// Asks for what a child holds before it is visited.
    #[inline(always)]
    pub(super) fn prefetch(&self, child: Child) {
        if child.is_leaf() {
            self.leaves.prefetch(child.leaf_range());
        } else if let Some(node) = self.nodes.get(child.index()) {
            prefetch(node);
        }
    }
}
