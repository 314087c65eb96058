//! Building: references to the primitives, a skeleton of ranges, then blocks and bounds from the leaves up.

use alloc::vec;
use alloc::vec::Vec;

use mobula_simd::AnyToken;

use super::join::reduce;
use super::reference::{self, Reference};
use super::sah::{Range, Sah};
use super::wide::Skeleton;
use super::{Block, Bounds, Bvh, Child, Join, Node, block::BLOCK};

impl<B: Block> Bvh<B> {
    /// Builds over primitives `0..count`, whose ids are `first_id..first_id + count`. Those without bounds are left out.
    pub(crate) fn build(
        count: usize,
        first_id: u32,
        join: &impl Join,
        primitive: impl Fn(usize) -> B::Primitive + Sync,
    ) -> Self {
        let mut references = references::<B>(count, join, &primitive);
        let mut skeleton = Skeleton::default();
        let root = match references.len() {
            0 => Child::EMPTY,
            _ => skeleton.append(join, &Sah { token: AnyToken::detect() }, Range::new(&mut references), 0),
        };
        let Skeleton { nodes, counts } = skeleton;
        let (nodes, (blocks, starts)) = join.join(
            || nodes.into_iter().map(|child| Node { child, ..Node::EMPTY }).collect(),
            || (vec![B::EMPTY; counts.len()], starts(&counts)),
        );
        let primitives = references.len();
        let mut bvh = Self { nodes, blocks, root, bounds: Bounds::EMPTY, scale: 0.0, primitives, first_id };
        bvh.fill(join, &|at, block: &mut B| {
            let mut ids = [u32::MAX; BLOCK];
            let own = &references[starts[at] as usize..starts[at + 1] as usize];
            for (id, reference) in ids.iter_mut().zip(own) {
                *id = reference::index(reference);
            }
            ids.sort_unstable();
            let mut bounds = Bounds::EMPTY;
            for (place, &id) in ids[..own.len()].iter().enumerate() {
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
