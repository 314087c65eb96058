//! Building: references to the primitives, a skeleton of ranges, then blocks and bounds from the leaves up.

use alloc::vec;
use alloc::vec::Vec;

use mobula_simd::AnyToken;

use super::join::reduce;
use super::morton::{self, Morton};
use super::reference::{self, Reference};
use super::sah::{Range, Sah};
use super::wide::Skeleton;
use super::{Block, Bounds, Bvh, Child, Join, Node, block::BLOCK};

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
        assert!(count <= (u32::MAX - first_id) as usize, "more primitives than ids");
        let mut references = references::<B>(count, join, &primitive);
        let (primitives, mut skeleton) = (references.len(), Skeleton::default());
        if primitives == 0 {
            return skeleton.flesh(Child::EMPTY, primitives, first_id, join, &primitive, |_| 0);
        }
        match quality {
            Quality::Fast => {
                let keys = morton::sorted(join, &mut references);
                drop(references);
                let root = skeleton.append(join, &Morton, &keys, 0);
                skeleton.flesh(root, primitives, first_id, join, &primitive, |i| morton::index(keys[i]))
            }
            Quality::Good => {
                let sah = Sah { token: AnyToken::detect() };
                let root = skeleton.append(join, &sah, Range::new(&mut references), 0);
                skeleton.flesh(root, primitives, first_id, join, &primitive, |i| reference::index(&references[i]))
            }
        }
    }
}

impl Skeleton {
    /// Nodes and blocks, filled from the leaves up; `number` says which primitive is at a place of the order.
    fn flesh<B: Block>(
        self,
        root: Child,
        primitives: usize,
        first_id: u32,
        join: &impl Join,
        primitive: &(impl Fn(usize) -> B::Primitive + Sync),
        number: impl Fn(usize) -> u32 + Sync,
    ) -> Bvh<B> {
        let Self { nodes, counts } = self;
        let (nodes, (blocks, starts)) = join.join(
            || nodes.into_iter().map(|child| Node { child, ..Node::EMPTY }).collect(),
            || (vec![B::EMPTY; counts.len()], starts(&counts)),
        );
        let mut bvh = Bvh { nodes, blocks, root, bounds: Bounds::EMPTY, scale: 0.0, primitives, first_id };
        bvh.fill(join, &|at, block: &mut B| {
            let (mut bounds, mut ids) = (Bounds::EMPTY, [u32::MAX; BLOCK]);
            let places = starts[at] as usize..starts[at + 1] as usize;
            let count = places.len();
            for (id, place) in ids.iter_mut().zip(places) {
                *id = number(place);
            }
            ids.sort_unstable();
            for (place, &id) in ids[..count].iter().enumerate() {
                let its = primitive(id as usize);
                bounds.merge(&B::bounds(&its).unwrap_or(Bounds::EMPTY));
                block.set(place, first_id + id, &its);
            }
            bounds
        });
        bvh
    }
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

/// References to all primitives with bounds.
fn references<B: Block>(
    count: usize,
    join: &impl Join,
    primitive: &(impl Fn(usize) -> B::Primitive + Sync),
) -> Vec<Reference> {
    let mut references = vec![[0.0; 8]; count];
    let run = |references: &mut [Reference], start: usize| {
        let mut kept = 0;
        for i in start..start + references.len() {
            if let Some(bounds) = B::bounds(&primitive(i)) {
                references[kept] = reference::new(&bounds, i as u32);
                kept += 1;
            }
        }
        kept
    };
    let kept = reduce(join, &mut references, 0, &run, &|all, middle, left, right| {
        all.copy_within(middle..middle + right, left);
        left + right
    });
    references.truncate(kept);
    references
}
