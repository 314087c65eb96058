//! Where walks start.

use crate::bvh::{Child, Tree};

/// Where walks start: at the tree's root, or at every leaf, as if there were no tree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Roots {
    Tree,
    All,
}

impl Roots {
    /// The roots in a tree.
    #[inline(always)]
    pub(super) fn of<B: Tree>(self, tree: &B) -> impl Iterator<Item = Child> {
        let mut next = 0;
        core::iter::from_fn(move || {
            let here = next;
            next += 1;
            match self {
                Self::Tree => (here == 0).then(|| tree.root()),
                Self::All => tree.leaf(here),
            }
        })
    }
}
