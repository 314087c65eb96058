//! From ranges of primitives that know how to split to nodes of eight children.
//!
//! A node starts as one range; the child with the greatest weight is split until there are eight or all are small enough
//! for a leaf. What comes out is the topology: who is whose child, and how many primitives each block takes, in the order
//! in which the ranges lie. Bounds are the business of [`refit`](super::refit).

use alloc::vec::Vec;

use super::Child;
use super::join::{Join, each};
use crate::leaf::BLOCK;

/// Ranges up to this are built without asking [`Join`].
const GRAIN: usize = 1 << 14;
/// From this depth on ranges are halved by count: a node then has eight children of equal size, and 10 more levels hold
/// 2^30 primitives. So no input makes a tree deeper than `DEPTH + 10`.
const DEPTH: usize = 16;
/// Entries that a walk's stack needs: seven siblings a level wait while the eighth is walked.
pub(crate) const STACK: usize = 7 * (DEPTH + 10) + 8;

/// Ranges of primitives in some order, and how they split.
pub(super) trait Ranges<'a>: Sync {
    /// One of them.
    type Range: Send;
    /// How many primitives it has.
    fn len(range: &Self::Range) -> usize;
    /// The heaviest is split first.
    fn weight(range: &Self::Range) -> f32;
    /// Splits one with more than a block of primitives in two; where, depends on the primitives only.
    fn split(&self, join: &impl Join, range: Self::Range, by_count: bool) -> [Self::Range; 2];
}

/// A node without bounds.
pub(super) struct Branch {
    pub(super) child: [Child; 8],
    pub(super) first_block: u32,
}

/// A tree without bounds. Children are relative to its own nodes and blocks.
#[derive(Default)]
pub(super) struct Topology {
    pub(super) nodes: Vec<Branch>,
    /// How many primitives each block has.
    pub(super) counts: Vec<u8>,
}

impl Topology {
    /// The tree of everything; nothing if there is nothing.
    pub(super) fn root<'a, R: Ranges<'a>>(&mut self, join: &impl Join, ranges: &R, range: R::Range) -> Child {
        if R::len(&range) == 0 { Child::EMPTY } else { self.append(join, ranges, range, 0) }
    }

    /// Appends the subtree of a range and returns where it is.
    fn append<'a, R: Ranges<'a>>(&mut self, join: &impl Join, ranges: &R, range: R::Range, depth: usize) -> Child {
        let count = R::len(&range);
        if count <= BLOCK {
            self.counts.push(count as u8);
            return Child::leaf(self.counts.len() - 1, 1);
        }
        let node = self.nodes.len();
        self.nodes.push(Branch { child: [Child::EMPTY; 8], first_block: self.counts.len() as u32 });
        let (mut children, len) = open(join, ranges, range, depth);
        if count > GRAIN {
            let subtrees = each(join, &mut children[..len], &|child| {
                let mut subtree = Self::default();
                let root = child.take().map(|child| {
                    let count = R::len(&child);
                    let root = subtree.append(join, ranges, child, depth + 1);
                    // Larger ones are counted in parts.
                    if count <= GRAIN {
                        join.done_with(count);
                    }
                    root
                });
                (root.unwrap_or(Child::EMPTY), subtree)
            });
            for (slot, (root, subtree)) in subtrees.into_iter().enumerate() {
                self.nodes[node].child[slot] = self.adopt(root, subtree);
            }
        } else {
            for (slot, child) in children.into_iter().flatten().enumerate() {
                self.nodes[node].child[slot] = self.append(join, ranges, child, depth + 1);
            }
        }
        Child::node(node)
    }

    /// Appends another topology and returns where its `child` is now.
    fn adopt(&mut self, child: Child, other: Self) -> Child {
        let (nodes, blocks) = (self.nodes.len(), self.counts.len());
        self.counts.extend(other.counts);
        self.nodes.extend(other.nodes);
        // If the last fit, all do.
        let _ = (Child::node(self.nodes.len()), Child::leaf(self.counts.len(), 1));
        for branch in &mut self.nodes[nodes..] {
            branch.child = branch.child.map(|child| child.moved(nodes, blocks));
            branch.first_block += blocks as u32;
        }
        child.moved(nodes, blocks)
    }
}

/// Splits a range into up to eight children, the heaviest first; they keep their order.
fn open<'a, R: Ranges<'a>>(
    join: &impl Join,
    ranges: &R,
    range: R::Range,
    depth: usize,
) -> ([Option<R::Range>; 8], usize) {
    let mut children = [const { None }; 8];
    let (mut weights, mut len) = ([f32::INFINITY; 8], 1);
    children[0] = Some(range);
    while len < 8 {
        let heaviest = (0..len).fold(0, |best, i| if weights[i] > weights[best] { i } else { best });
        let Some(range) = children[heaviest].take_if(|_| weights[heaviest] >= 0.0) else { break };
        let parts = ranges.split(join, range, depth >= DEPTH);
        children[heaviest + 1..=len].rotate_right(1);
        weights[heaviest + 1..=len].rotate_right(1);
        for (i, part) in parts.into_iter().enumerate() {
            // Leaves are not split.
            weights[heaviest + i] = if R::len(&part) > BLOCK { R::weight(&part).max(0.0) } else { -1.0 };
            children[heaviest + i] = Some(part);
        }
        len += 1;
    }
    (children, len)
}
