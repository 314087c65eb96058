//! The same tree over primitives that have moved: blocks are filled anew, bounds follow from the leaves up.

use alloc::vec::Vec;
use core::mem::take;

use super::frame::{frame, reach, samples};
use super::join::{Join, each};
use super::{Bvh, Child, Node};
use crate::kernel::margin::Frame;
use crate::leaf::{Block, Bounds};

/// Subtrees of no more blocks are done without asking [`Join`].
const GRAIN: usize = 1024;

impl<B: Block> Bvh<B> {
    /// Follows primitives that moved: `primitive` gives what the tree was built over, by the same numbers, as it is now.
    /// Costs a small part of a build; rays then find what they would find in a tree built anew, but it gets slower the
    /// more the primitives have changed places.
    ///
    /// Who has become degenerate or not finite is hit by nothing until another refit mends it. Who was left out when the
    /// tree was built stays out, and a primitive more or less needs a tree of its own: build anew.
    pub fn refit(&mut self, join: &impl Join, primitive: impl Fn(usize) -> B::Primitive + Sync) {
        self.refit_sound(join, |i| Some(primitive(i)).filter(|moved| B::bounds(moved).is_some()));
    }

    /// As [`refit`](Self::refit), where whoever gives the primitives has tested them: `None` is hit by nothing, and all others have
    /// [bounds](Block::bounds).
    pub fn refit_sound(&mut self, join: &impl Join, sound: impl Fn(usize) -> Option<B::Primitive> + Sync) {
        let first_id = self.first_id;
        let first = |at: usize| sound((self.leaves[at].ids(at)[0] - first_id) as usize).and_then(|its| B::bounds(&its));
        let frame = frame(samples(self.leaves.len()).filter_map(first));
        self.fill::<false>(join, frame, &|at, block: &mut B| {
            let ids = block.ids(at);
            for (place, id) in ids.into_iter().enumerate().filter(|&(_, id)| id != crate::NO_HIT) {
                block.set(place, id, &sound((id - first_id) as usize).unwrap_or(B::NOWHERE));
            }
        });
    }

    /// Fills all blocks and then all bounds: `block` gets each block with its number.
    /// A `NEW` tree's children are sorted.
    pub(super) fn fill<const NEW: bool>(
        &mut self,
        join: &impl Join,
        frame: Frame,
        block: &(impl Fn(usize, &mut B) + Sync),
    ) {
        let (primitives, blocks) = (self.primitives, self.leaf_count.max(1));
        let mut whole = Subtree {
            frame: &frame,
            done: &|done: usize| join.done_with((done as u64 * primitives as u64 / blocks as u64) as usize),
            root: self.root,
            slot: 0,
            nodes: &mut self.nodes,
            first_node: 0,
            blocks: &mut self.leaves,
            first_block: 0,
        };
        self.bounds = whole.fill::<NEW>(join, block);
        self.frame = Frame { farthest: reach(&self.bounds, frame.center), ..frame };
    }
}

/// A subtree's nodes and blocks, and where they start in the whole tree.
struct Subtree<'a, B> {
    frame: &'a Frame,
    /// Hears how many more blocks are filled.
    done: &'a (dyn Fn(usize) + Sync),
    root: Child,
    /// Where its parent has it.
    slot: usize,
    nodes: &'a mut [Node],
    first_node: usize,
    blocks: &'a mut [B],
    first_block: usize,
}

impl<B: Block> Subtree<'_, B> {
    fn fill<const NEW: bool>(&mut self, join: &impl Join, block: &(impl Fn(usize, &mut B) + Sync)) -> Bounds {
        if self.nodes.is_empty() || self.blocks.len() <= GRAIN {
            // All blocks first, in the order of memory. They wait for primitives that lie anywhere: what needs them whole comes after, so
            // that many are waited for at once.
            self.blocks.iter_mut().enumerate().for_each(|(i, its)| block(self.first_block + i, its));
            let bounds: Vec<Bounds> = self.blocks.iter().map(B::whole).collect();
            // Children stand behind their parents: backwards, they are done first.
            let mut wholes = alloc::vec![Bounds::EMPTY; self.nodes.len()];
            for at in (0..self.nodes.len()).rev() {
                let mut node = self.nodes[at];
                for slot in 0..8 {
                    let its = self.bounds(node.child[slot], &bounds, &wholes);
                    wholes[at].merge(&its);
                    node.set(slot, &its.within(self.frame), node.child[slot]);
                }
                // Not the last ones above the leaves, which are most: their order hardly matters.
                if NEW && node.child.iter().any(|child| !child.is_leaf()) {
                    node.sort();
                }
                self.nodes[at] = node;
            }
            (self.done)(self.blocks.len());
            return self.bounds(self.root, &bounds, &wholes);
        }
        let bounds = each(join, &mut self.split(), &|part| (part.slot, part.fill::<NEW>(join, block)));
        let (root, mut whole) = (&mut self.nodes[0], Bounds::EMPTY);
        for (slot, bounds) in bounds {
            root.set(slot, &bounds.within(self.frame), root.child[slot]);
            whole.merge(&bounds);
        }
        if NEW {
            root.sort();
        }
        whole
    }

    /// The bounds of a child, from those of all blocks and nodes.
    #[inline(always)]
    fn bounds(&self, child: Child, blocks: &[Bounds], nodes: &[Bounds]) -> Bounds {
        if child == Child::EMPTY {
            return Bounds::EMPTY;
        }
        if !child.is_leaf() {
            return nodes[child.index() - self.first_node];
        }
        let mut bounds = Bounds::EMPTY;
        for at in child.leaf_range() {
            bounds.merge(&blocks[at - self.first_block]);
        }
        bounds
    }

    /// The children of the root.
    fn split(&mut self) -> Vec<Subtree<'_, B>> {
        let Self { nodes, first_node, blocks, first_block, .. } = self;
        let children = nodes[0].child;
        let starts = children.map(|child| match child.is_leaf() {
            true => child.leaf_range().start,
            false => nodes[child.index() - *first_node].first_block as usize,
        });
        let (mut nodes, mut blocks) = (&mut nodes[1..], &mut blocks[..]);
        let mut parts = Vec::with_capacity(8);
        // From the last in memory on: each begins where what is left ends.
        let mut slots = [0, 1, 2, 3, 4, 5, 6, 7];
        slots.sort_unstable_by_key(|&slot| core::cmp::Reverse(starts[slot]));
        for slot in slots.into_iter().filter(|&slot| children[slot] != Child::EMPTY) {
            let root = children[slot];
            let node = if root.is_leaf() { nodes.len() } else { root.index() - *first_node - 1 };
            let (rest, its_nodes) = take(&mut nodes).split_at_mut(node);
            let (others, its_blocks) = take(&mut blocks).split_at_mut(starts[slot] - *first_block);
            (nodes, blocks) = (rest, others);
            parts.push(Subtree {
                frame: self.frame,
                done: self.done,
                root,
                slot,
                first_node: *first_node + 1 + node,
                nodes: its_nodes,
                first_block: starts[slot],
                blocks: its_blocks,
            });
        }
        parts
    }
}
