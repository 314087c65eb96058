//! From ranges of primitives that know how to split to nodes of eight children.
//!
//! A node starts as one range; the child with the greatest weight is split until there are eight or all are small enough
//! for a leaf. In a [compact](Shape::Compact) tree weights count little: see [`Shape::rank`]. What comes out is the topology:
//! who is whose child, and how many primitives each block takes, in the order in which the ranges lie. Bounds are the business
//! of [`refit`](super::refit).

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

/// How a tree is put together.
#[derive(Clone, Copy)]
pub(super) enum Shape {
    /// A block in each leaf; the heaviest range is split first.
    Exact,
    /// Two blocks in a leaf; few nodes have few children.
    Compact,
}

impl Shape {
    /// The most primitives in a leaf.
    fn leaf(self) -> usize {
        match self {
            Self::Exact => BLOCK,
            Self::Compact => 2 * BLOCK,
        }
    }

    /// How soon a range of `count` primitives is split in a node: the greatest number first, below 0 never.
    ///
    /// In a compact tree, first the first range that is more than a node of leaves holds: so ranges of all sizes come to be, and not all
    /// nodes just above the leaves have few children at once. Then the smallest that a leaf cannot hold, which saves the most nodes.
    /// At last those that could stay leaves, by weight.
    fn rank(self, count: usize, weight: f32) -> f32 {
        // NaN counts as 0.
        let weight = weight.max(0.0);
        match self {
            _ if count <= BLOCK => -1.0,
            Self::Exact => weight,
            Self::Compact if count > 8 * self.leaf() => f32::INFINITY,
            Self::Compact if count > self.leaf() => 2.0 + 1.0 / count as f32,
            Self::Compact => weight / (1.0 + weight),
        }
    }
}

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
pub(super) struct Topology {
    shape: Shape,
    pub(super) nodes: Vec<Branch>,
    /// How many primitives each block has.
    pub(super) counts: Vec<u8>,
}

impl Topology {
    /// Without anything.
    pub(super) fn new(shape: Shape) -> Self {
        Self { shape, nodes: Vec::new(), counts: Vec::new() }
    }

    /// The tree of everything; nothing if there is nothing.
    pub(super) fn root<'a, R: Ranges<'a>>(&mut self, join: &impl Join, ranges: &R, range: R::Range) -> Child {
        if R::len(&range) == 0 { Child::EMPTY } else { self.append(join, ranges, range, 0) }
    }

    /// Appends the subtree of a range and returns where it is.
    fn append<'a, R: Ranges<'a>>(&mut self, join: &impl Join, ranges: &R, range: R::Range, depth: usize) -> Child {
        let count = R::len(&range);
        if count <= self.shape.leaf() {
            let first = self.counts.len();
            self.counts.extend((0..count).step_by(BLOCK).map(|start| (count - start).min(BLOCK) as u8));
            return Child::leaf(first, self.counts.len() - first);
        }
        let node = self.nodes.len();
        self.nodes.push(Branch { child: [Child::EMPTY; 8], first_block: self.counts.len() as u32 });
        let (mut children, len) = open(join, ranges, range, depth, self.shape);
        if count > GRAIN {
            let subtrees = each(join, &mut children[..len], &|child| {
                let mut subtree = Self::new(self.shape);
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

/// Splits a range into up to eight children, those of the highest rank first; they keep their order.
fn open<'a, R: Ranges<'a>>(
    join: &impl Join,
    ranges: &R,
    range: R::Range,
    depth: usize,
    shape: Shape,
) -> ([Option<R::Range>; 8], usize) {
    let mut children = [const { None }; 8];
    let (mut ranks, mut len) = ([f32::INFINITY; 8], 1);
    children[0] = Some(range);
    while len < 8 {
        let first = (0..len).fold(0, |best, i| if ranks[i] > ranks[best] { i } else { best });
        let Some(range) = children[first].take_if(|_| ranks[first] >= 0.0) else { break };
        let by_count = depth >= DEPTH;
        let parts = ranges.split(join, range, by_count);
        children[first + 1..=len].rotate_right(1);
        ranks[first + 1..=len].rotate_right(1);
        for (i, part) in parts.into_iter().enumerate() {
            let count = R::len(&part);
            ranks[first + i] =
                if by_count && count > BLOCK { count as f32 } else { shape.rank(count, R::weight(&part)) };
            children[first + i] = Some(part);
        }
        len += 1;
    }
    (children, len)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::Serial;

    /// Ranges of so many primitives, of which a split takes a block off, as long as it may.
    struct Slices;

    impl Ranges<'_> for Slices {
        type Range = usize;

        fn len(range: &usize) -> usize {
            *range
        }

        fn weight(_: &usize) -> f32 {
            0.0
        }

        fn split(&self, _: &impl Join, range: usize, by_count: bool) -> [usize; 2] {
            let left = if by_count { (range / 2).next_multiple_of(BLOCK) } else { BLOCK };
            [left, range - left]
        }
    }

    #[test]
    fn no_splits_make_a_tree_deeper_than_the_stacks_of_walks() {
        for shape in [Shape::Exact, Shape::Compact] {
            let mut tree = Topology::new(shape);
            let root = tree.root(&Serial, &Slices, 1 << 20);
            let mut depths = alloc::vec![0; tree.nodes.len()];
            // Nodes stand before their children.
            for at in root.index()..tree.nodes.len() {
                let nodes = tree.nodes[at].child.into_iter().filter(|child| !child.is_leaf());
                nodes.for_each(|child| depths[child.index()] = depths[at] + 1);
            }
            assert_eq!(tree.counts.iter().map(|&count| usize::from(count)).sum::<usize>(), 1 << 20);
            let deepest = depths.into_iter().max().unwrap_or(0);
            assert!((DEPTH..DEPTH + 10).contains(&deepest), "{deepest}");
        }
    }
}
