//! The builder: binned SAH, top down, straight to eight children a node.
//!
//! Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", RT 2007. A node starts as one range of
//! primitives; the child with the largest surface is split until there are eight or all are small enough for a leaf.
//! The layout depends on the primitives only, not on who builds.

use alloc::vec::Vec;

use super::{Block, Bounds, Bvh, Child, Node, block::BLOCK};

/// How two halves of the work are done: one after the other, or by threads that somebody else has.
pub trait Join: Sync {
    /// Does both and returns both results.
    fn join<A: Send, B: Send>(&self, a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B);
}

/// One after the other.
#[derive(Clone, Copy, Debug, Default)]
pub struct Serial;

impl Join for Serial {
    fn join<A: Send, B: Send>(&self, a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
        (a(), b())
    }
}

/// A primitive while the tree is built.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reference {
    bounds: Bounds,
}

// The id lives in the padding of `low`: a reference is two vector loads.
impl Reference {
    pub(crate) fn new(mut bounds: Bounds, index: u32) -> Self {
        bounds.low[3] = f32::from_bits(index);
        bounds.high[3] = 0.0;
        Self { bounds }
    }

    pub(crate) fn index(&self) -> u32 {
        self.bounds.low[3].to_bits()
    }
}

const BINS: usize = 16;
/// Ranges below this are built without asking [`Join`].
const GRAIN: usize = 4096;
/// From this depth on ranges are halved by count: a node then has eight children of equal size, and 10 more levels hold
/// 2^30 primitives. So no input makes a tree deeper than `DEPTH + 10`.
const DEPTH: usize = 16;
/// Entries that a walk's stack needs: seven siblings a level wait while the eighth is walked.
pub(crate) const STACK: usize = 7 * (DEPTH + 10) + 8;

/// A subtree: children are relative to its own nodes and blocks.
struct Tree<B> {
    nodes: Vec<Node>,
    blocks: Vec<B>,
}

struct Range<'a> {
    references: &'a mut [Reference],
    bounds: Bounds,
    centers: Bounds,
}

impl<'a> Range<'a> {
    fn new(references: &'a mut [Reference]) -> Self {
        let (mut bounds, mut centers) = (Bounds::EMPTY, Bounds::EMPTY);
        for reference in references.iter() {
            bounds.merge(&reference.bounds);
            centers.grow(reference.bounds.middle2());
        }
        Self { references, bounds, centers }
    }

    fn is_leaf(&self) -> bool {
        self.references.len() <= BLOCK
    }

    fn split(self, by_count: bool) -> (Self, Self) {
        let found = if by_count { None } else { best_split(&self) };
        let middle = match found {
            Some((axis, bin)) => {
                let binning = Binning::new(&self.centers);
                partition(self.references, |r| binning.bin(r.bounds.middle2(), axis) < bin)
            }
            None => self.references.len() / 2,
        };
        let (left, right) = self.references.split_at_mut(middle);
        (Range::new(left), Range::new(right))
    }
}

/// Moves what satisfies `left` to the front and returns how many do. Keeps no order, but is deterministic.
fn partition(references: &mut [Reference], left: impl Fn(&Reference) -> bool) -> usize {
    let (mut i, mut j) = (0, references.len());
    loop {
        while i < j && left(&references[i]) {
            i += 1;
        }
        while i < j && !left(&references[j - 1]) {
            j -= 1;
        }
        if i >= j {
            return i;
        }
        references.swap(i, j - 1);
    }
}

struct Binning {
    low: [f32; 4],
    scale: [f32; 4],
}

impl Binning {
    fn new(centers: &Bounds) -> Self {
        let scale = core::array::from_fn(|axis| {
            let extent = centers.high[axis] - centers.low[axis];
            // Below this the quotient would overflow: all centres fall into bin 0 and the axis is not split.
            if extent > 1e-30 { BINS as f32 * 0.999_99 / extent } else { 0.0 }
        });
        Self { low: centers.low, scale }
    }

    #[inline(always)]
    fn bin(&self, middle2: [f32; 4], axis: usize) -> usize {
        (((middle2[axis] - self.low[axis]) * self.scale[axis]) as i32 as usize).min(BINS - 1)
    }
}

/// The axis and bin that cost least by the surface area heuristic, if a split is possible.
fn best_split(range: &Range<'_>) -> Option<(usize, usize)> {
    let binning = Binning::new(&range.centers);
    let mut bins = [[(Bounds::EMPTY, 0u32); BINS]; 3];
    for reference in range.references.iter() {
        let middle2 = reference.bounds.middle2();
        for (axis, bins) in bins.iter_mut().enumerate() {
            let bin = &mut bins[binning.bin(middle2, axis)];
            bin.0.merge(&reference.bounds);
            bin.1 += 1;
        }
    }
    let blocks = |count: u32| count.div_ceil(BLOCK as u32) as f32;
    let mut best = None;
    let mut least = f32::INFINITY;
    for (axis, bins) in bins.iter().enumerate() {
        let mut right = [(0.0f32, 0u32); BINS];
        let (mut bounds, mut count) = (Bounds::EMPTY, 0);
        for i in (1..BINS).rev() {
            bounds.merge(&bins[i].0);
            count += bins[i].1;
            right[i] = (bounds.half_area(), count);
        }
        let (mut bounds, mut count) = (Bounds::EMPTY, 0);
        for i in 1..BINS {
            bounds.merge(&bins[i - 1].0);
            count += bins[i - 1].1;
            let cost = bounds.half_area() * blocks(count) + right[i].0 * blocks(right[i].1);
            if count > 0 && right[i].1 > 0 && cost < least {
                least = cost;
                best = Some((axis, i));
            }
        }
    }
    best
}

/// Splits a range into up to eight children, the largest first.
fn open(range: Range<'_>, depth: usize) -> Vec<Range<'_>> {
    let mut children = Vec::with_capacity(8);
    children.push(range);
    while children.len() < 8 {
        let area = |i: usize| children[i].bounds.half_area();
        let largest = (0..children.len())
            .filter(|&i| !children[i].is_leaf())
            .max_by(|&a, &b| area(a).total_cmp(&area(b)).then(b.cmp(&a)));
        let Some(largest) = largest else { break };
        let (left, right) = children.swap_remove(largest).split(depth >= DEPTH);
        children.push(left);
        children.push(right);
    }
    children
}

/// What stays the same during a build.
struct Builder<'a, J, F> {
    join: &'a J,
    first_id: u32,
    primitive: F,
}

impl<J: Join, F: Sync> Builder<'_, J, F> {
    /// Appends the subtree of a range to `tree`.
    fn append<B: Block>(&self, tree: &mut Tree<B>, range: Range<'_>, depth: usize) -> Child
    where
        F: Fn(usize) -> B::Primitive,
    {
        if range.is_leaf() {
            range.references.sort_unstable_by_key(Reference::index);
            let mut block = B::EMPTY;
            for (place, reference) in range.references.iter().enumerate() {
                let index = reference.index();
                block.set(place, self.first_id + index, &(self.primitive)(index as usize));
            }
            tree.blocks.push(block);
            return Child::leaf(tree.blocks.len() - 1, 1);
        }
        let node = tree.nodes.len();
        tree.nodes.push(Node::EMPTY);
        let large = range.references.len() > GRAIN;
        let children = open(range, depth);
        let bounds: Vec<Bounds> = children.iter().map(|child| child.bounds).collect();
        let places: Vec<Child> = if large {
            let trees = self.separately(children, depth + 1);
            trees.into_iter().map(|(child, subtree)| tree.adopt(child, subtree)).collect()
        } else {
            children.into_iter().map(|child| self.append(tree, child, depth + 1)).collect()
        };
        for (slot, (place, bounds)) in places.into_iter().zip(&bounds).enumerate() {
            tree.nodes[node].set(slot, bounds, place);
        }
        Child::node(node)
    }

    /// A tree of its own for each range, so that threads need share nothing.
    fn separately<B: Block>(&self, mut ranges: Vec<Range<'_>>, depth: usize) -> Vec<(Child, Tree<B>)>
    where
        F: Fn(usize) -> B::Primitive,
    {
        if ranges.len() <= 1 {
            let alone = |range| {
                let mut tree = Tree { nodes: Vec::new(), blocks: Vec::new() };
                (self.append(&mut tree, range, depth), tree)
            };
            return ranges.into_iter().map(alone).collect();
        }
        let right = ranges.split_off(ranges.len() / 2);
        let (mut left, right) = self.join.join(|| self.separately(ranges, depth), || self.separately(right, depth));
        left.extend(right);
        left
    }
}

impl<B: Block> Tree<B> {
    /// Appends another tree and returns where its `child` is now.
    fn adopt(&mut self, child: Child, other: Self) -> Child {
        let (nodes, blocks) = (self.nodes.len(), self.blocks.len());
        self.blocks.extend(other.blocks);
        self.nodes.extend(other.nodes.into_iter().map(|mut node| {
            node.child = node.child.map(|c| c.moved(nodes, blocks));
            node
        }));
        child.moved(nodes, blocks)
    }
}

impl<B: Block> Bvh<B> {
    /// Builds over primitives `0..count`, whose ids are `first_id..first_id + count`. Those without bounds are left out.
    pub(crate) fn build(
        count: usize,
        first_id: u32,
        join: &impl Join,
        primitive: impl Fn(usize) -> B::Primitive + Sync,
    ) -> Self {
        let reference = |i| Some(Reference::new(B::bounds(&primitive(i))?, i as u32));
        let mut references: Vec<_> = (0..count).filter_map(reference).collect();
        let primitives = references.len();
        let range = Range::new(&mut references);
        let bounds = range.bounds;
        let mut tree = Tree { nodes: Vec::new(), blocks: Vec::new() };
        let root = match primitives {
            0 => Child::EMPTY,
            _ => Builder { join, first_id, primitive }.append(&mut tree, range, 0),
        };
        Self { nodes: tree.nodes, blocks: tree.blocks, root, bounds, scale: bounds.scale(), primitives, first_id }
    }
}
