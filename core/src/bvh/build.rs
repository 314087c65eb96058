//! Building: references to the primitives, a topology of ranges, then blocks and bounds from the leaves up.

use alloc::vec::Vec;

use mobula_simd::AnyToken;

use super::centroids::CentroidBounds;
use super::frame::{frame, samples};
use super::join::reduce;
use super::memory::{filled, zeroed};
use super::morton::{self, Morton};
use super::reference::{self, Reference};
use super::sah::{Range, Sah};
use super::wide::{Branch, Shape, Topology};
use super::{Bvh, Child, Join, Node, WideBvh};
use crate::kernel::margin::Frame;
use crate::leaf::{BLOCK, Block, Bounds, SphereBlock, TriangleBlock};

/// How much work goes into a tree.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Quality {
    /// Little: the order along a curve. For scenes that are built anew each frame.
    Fast,
    /// The surface area heuristic over bins.
    #[default]
    Good,
}

impl<B: Block> Bvh<B> {
    /// Builds over primitives `0..count`, whose ids are `first_id..first_id + count`. Those without
    /// [bounds](Block::bounds) are left out; [`primitives`](Bvh::primitives) says how many are in. The tree depends on the
    /// primitives only, not on who builds.
    ///
    /// # Panics
    /// If the ids do not fit 32 bits.
    pub fn build(
        count: usize,
        first_id: u32,
        quality: Quality,
        join: &impl Join,
        primitive: impl Fn(usize) -> B::Primitive + Sync,
    ) -> Self {
        Self::build_sound(count, first_id, quality, join, |i| Some(primitive(i)), &primitive)
    }

    /// As [`build`](Self::build), where it takes a test to know which primitives may be in the tree: `sound` makes it, once for each, and
    /// `primitive` gives those that passed, without.
    ///
    /// # Panics
    /// If the ids do not fit 32 bits.
    pub fn build_sound(
        count: usize,
        first_id: u32,
        quality: Quality,
        join: &impl Join,
        sound: impl Fn(usize) -> Option<B::Primitive> + Sync,
        primitive: impl Fn(usize) -> B::Primitive + Sync,
    ) -> Self {
        assert!(count <= (u32::MAX - first_id) as usize, "more primitives than ids");
        let bounds = |i: usize| sound(i).and_then(|primitive| B::bounds(&primitive));
        let frame = frame(samples(count).filter_map(bounds));
        let unit = unit(&frame);
        let (mut references, centroids) = references(count, unit, join, &bounds);
        let mut topology = Topology::new(if B::COMPACT { Shape::Compact } else { Shape::Exact });
        let mut bvh = WideBvh {
            nodes: Vec::new(),
            leaves: Vec::new(),
            leaf_count: 0,
            root: Child::EMPTY,
            bounds: Bounds::EMPTY,
            frame,
            primitives: references.len(),
            first_id,
        };
        match quality {
            Quality::Fast => {
                let mut keys = morton::sorted(join, &references, &centroids.among(&frame, unit));
                bvh.root = topology.root(join, &Morton { references: &references, full: B::COMPACT }, &mut keys[..]);
                topology.emit(&mut bvh, join, &primitive, |i| morton::index(keys[i]));
            }
            Quality::Good => {
                let sah = Sah { token: AnyToken::detect(), full: B::COMPACT };
                bvh.root = topology.root(join, &sah, Range::new(&mut references));
                topology.emit(&mut bvh, join, &primitive, |i| reference::index(&references[i]));
            }
        }
        bvh
    }
}

impl Bvh<TriangleBlock> {
    /// Builds over triangles `0..count`, whose ids are `first_id..first_id + count`. Those with a corner that is not
    /// finite or without area (two corners equal) are left out; [`primitives`](Bvh::primitives) says how many are in.
    pub fn triangles(
        count: usize,
        first_id: u32,
        join: &impl Join,
        corners: impl Fn(usize) -> [[f32; 3]; 3] + Sync,
    ) -> Self {
        Self::build(count, first_id, Quality::Good, join, corners)
    }
}

impl Bvh<SphereBlock> {
    /// Builds over spheres `0..count` (`[x, y, z, radius]`), whose ids are `first_id..first_id + count`. Those that are
    /// not finite or whose radius is not one of [`RADII`](crate::kernel::sphere::RADII) are left out.
    pub fn spheres(count: usize, first_id: u32, join: &impl Join, sphere: impl Fn(usize) -> [f32; 4] + Sync) -> Self {
        Self::build(count, first_id, Quality::Good, join, sphere)
    }
}

impl Topology {
    /// Nodes and blocks, filled from the leaves up; `number` says which primitive is at a place of the order.
    fn emit<B: Block>(
        self,
        bvh: &mut Bvh<B>,
        join: &impl Join,
        primitive: &(impl Fn(usize) -> B::Primitive + Sync),
        number: impl Fn(usize) -> u32 + Sync,
    ) {
        let Self { nodes: branches, counts, .. } = self;
        let (nodes, (blocks, starts)) = join.join(
            || {
                let nodes =
                    branches.iter().map(|&Branch { child, first_block }| Node { child, first_block, ..Node::EMPTY });
                filled(branches.len(), nodes)
            },
            || (filled(counts.len(), core::iter::repeat_n(B::EMPTY, counts.len())), starts(&counts)),
        );
        (bvh.nodes, bvh.leaves, bvh.leaf_count) = (nodes, blocks, counts.len());
        let (frame, first_id) = (bvh.frame, bvh.first_id);
        bvh.fill::<true>(join, frame, &|at, block: &mut B| {
            let mut ids = [u32::MAX; BLOCK];
            let places = starts[at] as usize..starts[at + 1] as usize;
            let count = places.len();
            for (id, place) in ids.iter_mut().zip(places) {
                *id = number(place);
            }
            for (place, &id) in sorted(ids)[..count].iter().enumerate() {
                block.set(place, first_id + id, &primitive(id as usize));
            }
        });
    }
}

/// Rising, without a branch.
fn sorted([a, b, c, d]: [u32; BLOCK]) -> [u32; BLOCK] {
    let (low, high) = ([a.min(b), c.min(d)], [a.max(b), c.max(d)]);
    let (x, y) = (low[0].max(low[1]), high[0].min(high[1]));
    [low[0].min(low[1]), x.min(y), x.max(y), high[0].max(high[1])]
}

/// Where blocks start, and the end.
fn starts(counts: &[u8]) -> Vec<u32> {
    let mut start = 0;
    let ends = counts.iter().map(|&count| {
        start += u32::from(count);
        start
    });
    core::iter::once(0).chain(ends).collect()
}

/// A power of two that makes primitives about as large as 1, so that areas neither overflow nor vanish; exact as a factor.
fn unit(frame: &Frame) -> f32 {
    let exponent = (frame.size.to_bits() >> 23 & 0xff) as i32 - 127;
    f32::from_bits(((127 - exponent.clamp(-126, 126)) as u32) << 23)
}

/// References to all primitives with bounds, and the bounds of their centroids, in multiples of `unit`.
fn references(
    count: usize,
    unit: f32,
    join: &impl Join,
    bounds: &(impl Fn(usize) -> Option<Bounds> + Sync),
) -> (Vec<Reference>, CentroidBounds) {
    let mut references = zeroed::<Reference>(count);
    let run = |references: &mut [Reference], start: usize| {
        let (mut kept, mut centroids) = (0, CentroidBounds::empty());
        for i in start..start + references.len() {
            if let Some(bounds) = bounds(i) {
                references[kept] = reference::new(&bounds, unit, i as u32);
                centroids.take(&references[kept]);
                kept += 1;
            }
        }
        (kept, centroids)
    };
    let (kept, centroids) = reduce(join, &mut references, 0, &run, &|all, middle, (left, a), (right, b)| {
        // Mostly nothing is left out, and all is where it belongs.
        if left < middle {
            all.copy_within(middle..middle + right, left);
        }
        (left + right, a.merge(&b))
    });
    references.truncate(kept);
    (references, centroids)
}
