//! Rays that have nothing in common, 16 at a time: as long as several of them meet the same boxes they go together, each box
//! tested against each ray, then alone.
//!
//! Benthin et al., "Combining Single and Packet-Ray Tracing for Arbitrary Ray Distributions on the Intel MIC
//! Architecture", TVCG 2012.

use mobula_simd::{F32Lanes, MaskLanes, Token};

use super::packet::Entry;
use super::{PAD, Roots, Target, single};
use crate::bvh::block::BLOCK;
use crate::bvh::{Block, Bvh, Child, Node, STACK};
use crate::{Column, NO_HIT, Rays};

/// Rays that go together.
pub(super) const TOGETHER: usize = 16;
/// So few rays go on alone; those that look for the nearest hit a little earlier, as they want an order of their own.
const fn lonely(any: bool) -> u32 {
    if any { 2 } else { 4 }
}

/// The rays `at..at + 16` of a packet.
pub(super) struct Loose<'a, const N: usize, B, H> {
    bvh: &'a Bvh<B>,
    rays: &'a mut Rays<N>,
    target: &'a mut H,
    at: usize,
    /// What to subtract from the distances of low and of high planes: those of the origins, moved outwards by the margin
    /// of rounding.
    edge: [[Column<f32, TOGETHER>; 3]; 2],
    /// For rays that go on alone.
    alone: &'a mut [single::Entry; STACK],
}

impl<'a, const N: usize, B: Block, H: Target<N>> Loose<'a, N, B, H> {
    /// Looks at the rays `at..at + 16`, whose inverse directions are derived.
    #[inline(always)]
    pub(super) fn new<T: Token>(
        token: T,
        bvh: &'a Bvh<B>,
        rays: &'a mut Rays<N>,
        target: &'a mut H,
        at: usize,
        alone: &'a mut [single::Entry; STACK],
    ) -> Self {
        let mut edge = [[Column::splat(0.0); 3]; 2];
        let mut lane = 0;
        while lane < TOGETHER {
            let mut largest = token.splat(bvh.scale);
            for origin in rays.origins() {
                largest = token.load(&origin[..], at + lane).abs().max(largest);
            }
            let margin = largest * token.splat(PAD);
            for k in 0..3 {
                let origin = token.load(&rays.origins()[k][..], at + lane);
                let inverse = token.load(&rays.inverse_columns()[k][..], at + lane);
                ((origin + margin) * inverse).store(&mut edge[0][k][..], lane);
                ((origin - margin) * inverse).store(&mut edge[1][k][..], lane);
            }
            lane += T::LANES;
        }
        Self { bvh, rays, target, at, edge, alone }
    }

    /// Walks the rays of a mask down from the roots.
    #[inline(always)]
    pub(super) fn down<T: Token>(&mut self, token: T, rays: u32, roots: Roots, stack: &mut [Entry; STACK]) {
        for root in roots {
            stack[0] = Entry { child: root, near: f32::NEG_INFINITY, groups: rays };
            let mut top = 1;
            while top > 0 {
                top -= 1;
                let mut entry = stack[top];
                entry.groups &= self.reaching(token, entry.near);
                while !entry.child.is_leaf() && entry.groups.count_ones() > lonely(H::ANY) {
                    let Some(node) = self.bvh.nodes.get(entry.child.index()) else { return };
                    entry = self.nearest(token, node, entry.groups, stack, &mut top);
                }
                if entry.groups.count_ones() > lonely(H::ANY) {
                    self.leaf(token, entry);
                } else {
                    self.go_alone(token, entry);
                }
            }
        }
    }

    /// Which rays may still hit something from `near` on.
    #[inline(always)]
    fn reaching<T: Token>(&self, token: T, near: f32) -> u32 {
        let mut reaching = 0;
        let mut lane = 0;
        while lane < TOGETHER {
            let t_max = token.load(&self.rays.t_max[..], self.at + lane);
            reaching |= token.splat(near).le(t_max).bits() << lane;
            lane += T::LANES;
        }
        reaching
    }

    /// The nearest child that any of the rays meets ([`Child::EMPTY`] and no rays if none); pushes the others, the nearer
    /// ones last.
    #[inline(always)]
    fn nearest<T: Token>(
        &self,
        token: T,
        node: &Node,
        rays: u32,
        stack: &mut [Entry; STACK],
        top: &mut usize,
    ) -> Entry {
        let mut nearest = Entry { child: Child::EMPTY, near: f32::INFINITY, groups: 0 };
        let first = *top;
        for slot in 0..8 {
            let mut met = 0;
            let mut near = token.splat(f32::INFINITY);
            let mut lane = 0;
            while lane < TOGETHER {
                let (hit, entry) = self.slabs(token, node, slot, lane);
                let hit = hit & token.mask(rays >> lane);
                met |= hit.bits() << lane;
                near = entry.select(hit, token.splat(f32::INFINITY)).min(near);
                lane += T::LANES;
            }
            if met == 0 {
                continue;
            }
            // The order of any hits is not worth a sort.
            let near = if H::ANY { f32::NEG_INFINITY } else { near.reduce_min() };
            self.bvh.prefetch(node.child[slot]);
            let mut entry = Entry { child: node.child[slot], near, groups: met };
            if nearest.groups == 0 {
                nearest = entry;
                continue;
            }
            if !H::ANY && entry.near < nearest.near {
                core::mem::swap(&mut entry, &mut nearest);
            }
            let mut place = *top;
            while !H::ANY && place > first && stack[place - 1].near < entry.near {
                stack[place] = stack[place - 1];
                place -= 1;
            }
            stack[place] = entry;
            *top += 1;
        }
        nearest
    }

    /// Which rays from `lane` meet a child, and where.
    #[inline(always)]
    fn slabs<T: Token>(&self, token: T, node: &Node, slot: usize, lane: usize) -> (T::Mask, T::F32) {
        let at = self.at + lane;
        let mut near = token.load(&self.rays.t_min()[..], at);
        let mut far = token.load(&self.rays.t_max[..], at);
        for k in 0..3 {
            let inverse = token.load(&self.rays.inverse_columns()[k][..], at);
            let low = token.splat(node.planes[k][slot]).mul_sub(inverse, token.load(&self.edge[0][k][..], lane));
            let high = token.splat(node.planes[k + 3][slot]).mul_sub(inverse, token.load(&self.edge[1][k][..], lane));
            near = low.min(high).max(near);
            far = low.max(high).min(far);
        }
        (near.le(far), near)
    }

    /// Tests the primitives of a leaf against the rays.
    #[inline(always)]
    fn leaf<T: Token>(&mut self, token: T, entry: Entry) {
        let Some(blocks) = self.bvh.blocks.get(entry.child.blocks()) else { return };
        for block in blocks {
            let prepared = block.prepare::<N, false>(self.rays);
            for i in 0..BLOCK {
                let id = block.ids()[i];
                if id == NO_HIT {
                    break;
                }
                let mut lane = 0;
                while lane < TOGETHER {
                    let rays = token.mask(entry.groups >> lane);
                    let (hit, t) = B::test::<T, N, false, true>(token, &prepared, i, 0, self.rays, self.at + lane);
                    let hit = hit & rays;
                    if hit.any() {
                        self.target.record(token, self.rays, self.at + lane, hit, t, id);
                    }
                    lane += T::LANES;
                }
            }
        }
    }

    /// Traces the few rays of an entry one by one.
    #[inline(always)]
    fn go_alone<T: Token>(&mut self, token: T, entry: Entry) {
        let mut rays = entry.groups;
        while rays != 0 {
            let i = self.at + rays.trailing_zeros() as usize;
            rays &= rays - 1;
            token.run(single::Alone {
                bvh: self.bvh,
                rays: self.rays,
                target: self.target,
                roots: Roots::at(entry.child),
                stack: self.alone,
                i,
            });
        }
    }
}
