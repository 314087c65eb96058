//! Rays that have nothing in common, 64 at a time: as long as several of them meet the same boxes they go together, each box
//! tested against each ray, then alone.
//!
//! Benthin et al., "Combining Single and Packet-Ray Tracing for Arbitrary Ray Distributions on the Intel MIC
//! Architecture", TVCG 2012.

use mobula_simd::{F32Lanes, MaskLanes, Token};

use super::stack::{Entry, Met};
use super::{PAD, Roots, Target, single};
use crate::bvh::block::BLOCK;
use crate::bvh::{Block, Bvh, Node, STACK};
use crate::{Column, NO_HIT, Rays};

/// Rays that go together, at most.
pub(super) const TOGETHER: usize = 64;
/// As many of a packet.
const fn together(width: usize) -> usize {
    if width < TOGETHER { width.next_multiple_of(16) } else { TOGETHER }
}
/// So few rays go on alone: three that look for any hit where a vector has 16 lanes, more where it takes more vectors to test as
/// many together; those that look for the nearest hit a little earlier, as they want an order of their own.
const fn lonely(lanes: usize, any: bool) -> u32 {
    (if any { 48 } else { 96 }) / lanes as u32
}

/// Those of a mask in the vector from `lane`.
#[inline(always)]
fn part<T: Token>(rays: u64, lane: usize) -> u32 {
    (rays >> lane) as u32 & (u32::MAX >> (32 - T::LANES))
}

/// The rays `at..at + 64` of a packet.
pub(super) struct Loose<'a, const N: usize, B, H> {
    bvh: &'a Bvh<B>,
    rays: &'a mut Rays<N>,
    target: &'a mut H,
    at: usize,
    /// What to subtract from the distances of low and of high planes: those of the origins, moved outwards by the margin
    /// of rounding.
    edge: [[Column<f32, TOGETHER>; 3]; 2],
    /// The least and the greatest coordinates of the rays, moved outwards by the margin.
    around: [[f32; 3]; 2],
}

impl<'a, const N: usize, B: Block, H: Target<N>> Loose<'a, N, B, H> {
    /// Looks at the rays `at..at + 64`, whose inverse directions are derived.
    #[inline(always)]
    pub(super) fn new<T: Token>(
        token: T,
        bvh: &'a Bvh<B>,
        rays: &'a mut Rays<N>,
        target: &'a mut H,
        at: usize,
    ) -> Self {
        let mut edge = [[Column::splat(0.0); 3]; 2];
        let (inf, minus_inf, nan) = (token.splat(f32::INFINITY), token.splat(f32::NEG_INFINITY), token.splat(f32::NAN));
        let (mut least, mut greatest) = ([inf; 3], [minus_inf; 3]);
        let mut lane = 0;
        while lane < together(N) {
            let mut largest = token.splat(bvh.scale);
            for origin in rays.origins() {
                largest = token.load(&origin[..], at + lane).abs().max(largest);
            }
            let margin = largest * token.splat(PAD);
            let (t_min, t_max) = (token.load(&rays.t_min()[..], at + lane), token.load(&rays.t_max[..], at + lane));
            let searching = rays.active(token, at + lane) & t_min.le(t_max);
            // Where it starts: at the origin, unless behind it.
            let t_min = t_min.min(token.splat(0.0));
            for k in 0..3 {
                let origin = token.load(&rays.origins()[k][..], at + lane);
                let inverse = token.load(&rays.inverse_columns()[k][..], at + lane);
                // Where products overflow, as those of short directions, NaN: `min` and `max` pass over the axis.
                let small = (largest * token.splat(4.0) * inverse).abs().lt(inf);
                let inverse = inverse.select(small, nan);
                ((origin + margin) * inverse).store(&mut edge[0][k][..], lane);
                ((origin - margin) * inverse).store(&mut edge[1][k][..], lane);
                // A NaN on the left of `min` and `max` is passed over: rays that are done, and 0 times infinity, which leads nowhere.
                let direction = token.load(&rays.directions()[k][..], at + lane);
                let (start, end) = (direction.mul_add(t_min, origin), direction.mul_add(t_max, origin));
                let low = end.min(start.min(origin)).select(searching, nan);
                let high = end.max(start.max(origin)).select(searching, nan);
                least[k] = (low - margin).min(least[k]);
                greatest[k] = (high + margin).max(greatest[k]);
            }
            lane += T::LANES;
        }
        let mut around = [[0.0; 3]; 2];
        for k in 0..3 {
            around[0][k] = least[k].reduce_min();
            around[1][k] = greatest[k].reduce_max();
        }
        Self { bvh, rays, target, at, edge, around }
    }

    /// Walks the rays of a mask down from the roots.
    #[inline(always)]
    pub(super) fn down<T: Token>(&mut self, token: T, rays: u64, roots: Roots, stack: &mut [Entry; STACK]) {
        let mut nears = [[0.0; TOGETHER]; 8];
        for root in roots {
            stack[0] = Entry { child: root, near: f32::NEG_INFINITY, groups: rays };
            let mut top = 1;
            while top > 0 {
                top -= 1;
                let mut entry = stack[top];
                entry.groups &= self.reaching(token, entry.near);
                while !entry.child.is_leaf() && entry.groups.count_ones() > lonely(T::LANES, H::ANY) {
                    let Some(node) = self.bvh.nodes.get(entry.child.index()) else { return };
                    entry = self.nearest(token, node, entry.groups, &mut nears, stack, &mut top);
                }
                if entry.groups.count_ones() > lonely(T::LANES, H::ANY) {
                    self.leaf(token, entry);
                } else {
                    self.go_alone(token, entry, stack, top);
                }
            }
        }
    }

    /// Which rays may still hit something from `near` on.
    #[inline(always)]
    fn reaching<T: Token>(&self, token: T, near: f32) -> u64 {
        let mut reaching = 0;
        let mut lane = 0;
        while lane < together(N) {
            let t_max = token.load(&self.rays.t_max[..], self.at + lane);
            reaching |= u64::from(token.splat(near).le(t_max).bits()) << lane;
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
        rays: u64,
        nears: &mut [[f32; TOGETHER]; 8],
        stack: &mut [Entry; STACK],
        top: &mut usize,
    ) -> Entry {
        // All tests first, then what follows from them: one branch that nobody foresees in place of one a child.
        let mut close = self.close(token, node);
        let mut meeting = [0u64; 8];
        let mut met = 0u32;
        while close != 0 {
            let slot = close.trailing_zeros() as usize % 8;
            close &= close - 1;
            let (mut these, mut lane) = (0, 0);
            while lane < together(N) {
                if part::<T>(rays, lane) != 0 {
                    let (hit, near) = self.slabs(token, node, slot, lane);
                    these |= u64::from(hit.bits()) << lane;
                    if !H::ANY {
                        near.store(&mut nears[slot], lane);
                    }
                }
                lane += T::LANES;
            }
            meeting[slot] = these & rays;
            met |= u32::from(meeting[slot] != 0) << slot;
        }
        let mut children = Met::new(stack, *top);
        while met != 0 {
            let slot = met.trailing_zeros() as usize % 8;
            met &= met - 1;
            let child = node.child[slot];
            self.bvh.prefetch(child);
            // The order of any hits is the node's.
            let near = if H::ANY { f32::NEG_INFINITY } else { Self::first(token, &nears[slot], meeting[slot]) };
            children.add(Entry { child, near, groups: meeting[slot] }, !H::ANY);
        }
        *top = children.top;
        children.nearest
    }

    /// Where the first of the rays gets to a child.
    #[inline(always)]
    fn first<T: Token>(token: T, nears: &[f32; TOGETHER], rays: u64) -> f32 {
        let inf = token.splat(f32::INFINITY);
        let mut first = inf;
        let mut lane = 0;
        while lane < together(N) {
            first = token.load(nears, lane).select(token.mask(part::<T>(rays, lane)), inf).min(first);
            lane += T::LANES;
        }
        first.reduce_min()
    }

    /// Which children overlap the box around all rays: few, where rays are short.
    #[inline(always)]
    fn close<T: Token>(&self, token: T, node: &Node) -> u32 {
        let token = token.narrow();
        let mut close = 0;
        let mut at = 0;
        while at < 8 {
            let mut inside = token.mask(u32::MAX);
            for k in 0..3 {
                let (low, high) = (token.load(&node.planes[k], at), token.load(&node.planes[k + 3], at));
                inside = inside & low.le(token.splat(self.around[1][k])) & high.ge(token.splat(self.around[0][k]));
            }
            close |= inside.bits() << at;
            at += <T::Narrow as Token>::LANES;
        }
        close
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
                while lane < together(N) {
                    let rays = part::<T>(entry.groups, lane);
                    if rays == 0 {
                        lane += T::LANES;
                        continue;
                    }
                    let rays = token.mask(rays);
                    let (hit, t) =
                        B::test::<T, N, false, true>(token, &prepared, i, 0, self.rays, self.at + lane, rays);
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
    fn go_alone<T: Token>(&mut self, token: T, entry: Entry, stack: &mut [Entry; STACK], top: usize) {
        let mut rays = entry.groups;
        while rays != 0 {
            let lane = rays.trailing_zeros() as usize % TOGETHER;
            rays &= rays - 1;
            let mut edge = [[0.0; 3]; 2];
            for (edge, columns) in edge.iter_mut().zip(&self.edge) {
                for (edge, column) in edge.iter_mut().zip(columns) {
                    *edge = column[lane];
                }
            }
            token.run(single::Alone {
                bvh: self.bvh,
                rays: self.rays,
                target: self.target,
                child: entry.child,
                edge,
                stack,
                base: top,
                i: self.at + lane,
            });
        }
    }
}
