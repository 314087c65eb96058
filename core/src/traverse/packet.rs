//! Packets through the tree.
//!
//! ```text
//! groups with nothing in common go loose, 16 rays at a time
//! for each class of the others: stack = [root, all groups of the class]
//!     pop; leave out groups that have found something nearer
//!     node: which groups may meet which of eight children?  all at once
//!           each child met: which rays of groups that came apart meet it?  a few: alone from here
//!           on with the nearest; push the others, the nearer ones last
//!     leaf: which groups may hit which triangles?  all at once; then each such triangle against each group's rays, W at a time
//! ```

use mobula_simd::{F32Lanes, MaskLanes, Token};

use super::beams::{Beams, GROUPS, MIXED, group_lanes, group_size};
use super::loose::{Loose, TOGETHER};
use super::{Paths, Roots, Target, single};
use crate::bvh::block::BLOCK;
use crate::bvh::{Block, Bvh, Child, Node, STACK};
use crate::kernel::{aabb, load3, splat3, sub};
use crate::{NO_HIT, Properties, Rays};

/// Packets with fewer rays travel ray by ray.
const FEW: usize = 4;
/// So few rays of a packet that meet a child go on alone there: a packet that has come apart (rays to a light from both
/// sides of a silhouette) would test them against all that lies between (after Benthin et al., "Combining Single and
/// Packet-Ray Tracing for Arbitrary Ray Distributions on the Intel MIC Architecture", TVCG 2012).
const LONELY: u32 = 3;
/// Words with a bit for each ray of the widest packet.
const WORDS: usize = 1024 / 64;

/// A subtree that waits, and for whom.
#[derive(Clone, Copy)]
pub(super) struct Entry {
    pub(super) child: Child,
    /// Where it is entered at the earliest.
    pub(super) near: f32,
    /// The groups (of [`Loose`] the rays) that may meet it.
    pub(super) groups: u32,
}

#[inline(always)]
pub(super) fn traverse<T: Token, const N: usize, B: Block, H: Target<N>>(
    token: T,
    bvh: &Bvh<B>,
    rays: &mut Rays<N>,
    target: &mut H,
    roots: Roots,
) -> Paths {
    let range = rays.range();
    if range.is_empty() || bvh.primitives() == 0 {
        return Paths::default();
    }
    rays.shears(token);
    let mut paths = Paths::default();
    let mut stack = [single::Entry::NONE; STACK];
    let single = if N < FEW || range.len() < FEW {
        u32::MAX
    } else if rays.properties().contains(Properties::COMMON_ORIGIN) {
        together::<T, N, B, H, true>(token, bvh, rays, target, roots, &mut stack, &mut paths.common_origin)
    } else {
        together::<T, N, B, H, false>(token, bvh, rays, target, roots, &mut stack, &mut paths.general)
    };
    if single != 0 {
        rays.inverse_directions(token);
        let mut entries = [Entry { child: bvh.root, near: 0.0, groups: 0 }; STACK];
        let mut at = range.start / TOGETHER * TOGETHER;
        while at < range.end {
            if single >> (at / group_size(N)) & 1 != 0 {
                let mut active = 0;
                let mut lane = 0;
                while lane < TOGETHER {
                    active |= rays.active(token, at + lane).bits() << lane;
                    lane += T::LANES;
                }
                paths.single += u64::from(active.count_ones());
                Loose::new(token, bvh, rays, target, at, &mut stack).down(token, active, roots, &mut entries);
            }
            at += TOGETHER;
        }
    }
    paths
}

/// Traces the groups that have something in common; returns the others.
#[inline(always)]
fn together<T: Token, const N: usize, B: Block, H: Target<N>, const COMMON_ORIGIN: bool>(
    token: T,
    bvh: &Bvh<B>,
    rays: &mut Rays<N>,
    target: &mut H,
    roots: Roots,
    alone_stack: &mut [single::Entry; STACK],
    traced: &mut u64,
) -> u32 {
    let size = group_size(N);
    let range = rays.range();
    let mut beams = Beams::new::<T, N, COMMON_ORIGIN>(token, rays, bvh.scale);
    let (mut left, mut alone) = (0u32, 0u32);
    for group in range.start / size..range.end.div_ceil(size) {
        if beams.class(group) == MIXED {
            alone |= 1 << group;
        } else {
            left |= 1 << group;
            *traced += (range.end.min((group + 1) * size) - range.start.max(group * size)) as u64;
        }
    }
    let mut stack = [Entry { child: bvh.root, near: 0.0, groups: 0 }; STACK];
    while left != 0 {
        let class = beams.class(left.trailing_zeros() as usize);
        let groups = beams.gather::<T, N, COMMON_ORIGIN>(token, rays, class);
        left &= !groups;
        let wide = beams.wide();
        if wide != 0 {
            rays.inverse_directions(token);
        }
        let octant = if wide == 0 { MIXED } else { rays.octant().unwrap_or(MIXED) };
        let lanes = [0; WORDS];
        let mut walk = Walk { bvh, rays, target, beams: &mut beams, wide, octant, lanes, stack: alone_stack };
        for child in roots {
            stack[0] = Entry { child, near: f32::NEG_INFINITY, groups };
            walk.down::<T, COMMON_ORIGIN>(token, &mut stack);
        }
    }
    alone
}

struct Walk<'a, const N: usize, B, H> {
    bvh: &'a Bvh<B>,
    rays: &'a mut Rays<N>,
    target: &'a mut H,
    beams: &'a mut Beams,
    /// Groups whose rays are tested one by one.
    wide: u32,
    /// Signs of all directions (bit k: axis k is negative), or `MIXED`.
    octant: u8,
    /// A bit a ray: see [`rays_in`](Self::rays_in).
    lanes: [u64; WORDS],
    /// For rays that go on alone.
    stack: &'a mut [single::Entry; STACK],
}

impl<const N: usize, B: Block, H: Target<N>> Walk<'_, N, B, H> {
    /// Walks down from `stack[0]`.
    #[inline(always)]
    fn down<T: Token, const COMMON_ORIGIN: bool>(&mut self, token: T, stack: &mut [Entry; STACK]) {
        let mut top = 1;
        while top > 0 {
            top -= 1;
            let mut entry = stack[top];
            entry.groups = self.beams.reaching::<T, N>(token, entry.groups, entry.near);
            if entry.groups == 0 {
                continue;
            }
            // Down to a leaf by the nearest child each time; the others wait.
            while !entry.child.is_leaf() {
                let Some(node) = self.bvh.nodes.get(entry.child.index()) else { return };
                entry = self.nearest::<T, COMMON_ORIGIN>(token, node, entry.groups, stack, &mut top);
            }
            self.leaf::<T, COMMON_ORIGIN>(token, entry);
        }
    }

    /// The nearest child that any ray of the groups meets ([`Child::EMPTY`] if none); pushes the others, the nearer ones last. Where
    /// only a few rays meet a child, they go on alone at once.
    #[inline(always)]
    fn nearest<T: Token, const COMMON_ORIGIN: bool>(
        &mut self,
        token: T,
        node: &Node,
        groups: u32,
        stack: &mut [Entry; STACK],
        top: &mut usize,
    ) -> Entry {
        let lanes = group_lanes(N);
        let mut nears = [0.0f32; 8];
        let mut met = self.beams.children::<T, N>(token, node, &mut nears) & repeat(groups, lanes);
        let mut nearest = Entry { child: Child::EMPTY, near: f32::INFINITY, groups: 0 };
        let first = *top;
        while let Some((slot, mut groups)) = next_child(&mut met, lanes) {
            let child = node.child[slot];
            if groups & self.wide != 0 {
                let (meeting, count) = self.rays_in::<T, COMMON_ORIGIN>(token, node, slot, groups & self.wide);
                groups = groups & !self.wide | meeting;
                if groups == 0 {
                    continue;
                }
                if groups == meeting && count <= LONELY {
                    self.go_alone(token, child, meeting);
                    continue;
                }
            }
            let mut entry = Entry { child, near: nears[slot], groups };
            if nearest.groups == 0 {
                nearest = entry;
                continue;
            }
            if entry.near < nearest.near {
                core::mem::swap(&mut entry, &mut nearest);
            }
            // Insertion: the farthest child stays lowest. The order of any hits is not worth a sort.
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

    /// Which groups have rays that meet a child's box, and how many rays; `self.lanes` says which.
    #[inline(always)]
    fn rays_in<T: Token, const COMMON_ORIGIN: bool>(
        &mut self,
        token: T,
        node: &Node,
        slot: usize,
        groups: u32,
    ) -> (u32, u32) {
        let size = group_size(N);
        let margin = self.beams.margin();
        let [mut low, mut high] = [[0.0; 3]; 2];
        for axis in 0..3 {
            let origin = if COMMON_ORIGIN { self.rays.origins()[axis][self.rays.range().start] } else { 0.0 };
            low[axis] = node.planes[axis][slot % 8] - (origin + margin);
            high[axis] = node.planes[axis + 3][slot % 8] - (origin - margin);
            if self.octant >> axis & 1 != 0 {
                (low[axis], high[axis]) = (high[axis], low[axis]);
            }
        }
        let (low, high) = (splat3(token, low), splat3(token, high));
        let (mut met, mut count) = (0, 0);
        self.lanes[..N.div_ceil(64)].fill(0);
        let mut left = groups;
        while left != 0 {
            let group = left.trailing_zeros() as usize % GROUPS;
            left &= left - 1;
            let mut at = group * size;
            while at < N.min((group + 1) * size) {
                let inverse = load3(token, self.rays.inverse_columns(), at);
                let (mut to_low, mut to_high) = (low, high);
                if !COMMON_ORIGIN {
                    let origin = load3(token, self.rays.origins(), at);
                    (to_low, to_high) = (sub(low, origin), sub(high, origin));
                }
                let t_min = token.load(&self.rays.t_min()[..], at);
                let t_max = token.load(&self.rays.t_max[..], at);
                let (hit, _) = if self.octant == MIXED {
                    aabb::aabb(token, to_low, to_high, inverse, t_min, t_max)
                } else {
                    aabb::slabs(token, to_low, to_high, inverse, t_min, t_max)
                };
                let hit = (hit & self.rays.active(token, at)).bits();
                self.lanes[at / 64 % WORDS] |= u64::from(hit) << (at % 64);
                met |= u32::from(hit != 0) << group;
                count += hit.count_ones();
                at += T::LANES;
            }
        }
        (met, count)
    }

    /// Traces the rays in `self.lanes`, which are of these groups, through a child, one by one.
    #[inline(always)]
    fn go_alone<T: Token>(&mut self, token: T, child: Child, groups: u32) {
        for word in 0..N.div_ceil(64) {
            let mut lanes = self.lanes[word];
            while lanes != 0 {
                let i = 64 * word + lanes.trailing_zeros() as usize;
                lanes &= lanes - 1;
                token.run(single::Alone {
                    bvh: self.bvh,
                    rays: self.rays,
                    target: self.target,
                    roots: Roots::at(child),
                    stack: self.stack,
                    i,
                });
            }
        }
        self.shorten(token, groups);
    }

    /// Tests the primitives of a leaf against the rays of the groups.
    #[inline(always)]
    fn leaf<T: Token, const COMMON_ORIGIN: bool>(&mut self, token: T, entry: Entry) {
        let size = group_size(N);
        let axis = self.beams.axis();
        let Some(blocks) = self.bvh.blocks.get(entry.child.blocks()) else { return };
        let mut changed = 0u32;
        for block in blocks {
            let prepared = block.prepare::<N, COMMON_ORIGIN>(self.rays);
            let mut pairs = quadruple(entry.groups);
            if COMMON_ORIGIN {
                pairs &= B::touches(token, &prepared, axis, self.beams.spread(), entry.groups);
            }
            while pairs != 0 {
                let pair = pairs.trailing_zeros() as usize;
                pairs &= pairs - 1;
                let (group, i) = (pair / BLOCK, pair % BLOCK);
                let id = block.ids()[i];
                if id == NO_HIT {
                    continue;
                }
                let mut at = group * size;
                while at < (group + 1) * size {
                    let (hit, t) = B::test::<T, N, COMMON_ORIGIN, false>(token, &prepared, i, axis, self.rays, at);
                    if hit.any() && self.target.record(token, self.rays, at, hit, t, id) {
                        changed |= 1 << group;
                    }
                    at += T::LANES;
                }
            }
        }
        if changed != 0 {
            self.shorten(token, changed);
        }
    }

    /// After hits in the groups `changed`: they, and the packet, reach no farther than their farthest ray.
    #[inline(always)]
    fn shorten<T: Token>(&mut self, token: T, mut changed: u32) {
        let size = group_size(N);
        let minus_inf = token.splat(f32::NEG_INFINITY);
        while changed != 0 {
            let group = changed.trailing_zeros() as usize % GROUPS;
            changed &= changed - 1;
            let mut farthest = minus_inf;
            let mut at = group * size;
            while at < (group + 1) * size {
                let t = token.load(&self.rays.t_max[..], at).select(self.rays.active(token, at), minus_inf);
                farthest = farthest.max(t);
                at += T::LANES;
            }
            self.beams.shorten::<T, N>(token, group, farthest.reduce_max());
        }
    }
}

/// Takes the first child that any group meets out of `met`, which has `lanes` (4 or 16) bits a child.
#[inline(always)]
fn next_child(met: &mut u128, lanes: usize) -> Option<(usize, u32)> {
    let low = *met as u64;
    let (shift, half) = if lanes == 4 || low != 0 { (0, low) } else { (4, (*met >> 64) as u64) };
    if half == 0 {
        return None;
    }
    let slot = half.trailing_zeros() as usize / lanes;
    let groups = (half >> (slot * lanes)) as u32 & ((1 << lanes) - 1);
    let left = half & !(u64::from(groups) << (slot * lanes));
    *met = if shift == 0 { *met & !u128::from(u64::MAX) | u128::from(left) } else { u128::from(left) << 64 };
    Some(((slot + shift) % 8, groups))
}

/// A mask of `lanes` (4 or 16) bits, eight times.
#[inline(always)]
fn repeat(groups: u32, lanes: usize) -> u128 {
    if lanes == 4 { u128::from(groups * 0x1111_1111) } else { u128::from(groups) * (u128::MAX / 0xffff) }
}

/// Each of 16 bits four times.
#[inline(always)]
fn quadruple(groups: u32) -> u64 {
    let mut bits = u64::from(groups);
    bits = (bits | bits << 24) & 0x0000_00ff_0000_00ff;
    bits = (bits | bits << 12) & 0x000f_000f_000f_000f;
    bits = (bits | bits << 6) & 0x0303_0303_0303_0303;
    bits = (bits | bits << 3) & 0x1111_1111_1111_1111;
    bits * 15
}
