//! Packets through the tree.
//!
//! ```text
//! groups with nothing in common go loose, 64 rays at a time
//! for each class of the others: stack = [root, all groups of the class]
//!     pop; leave out groups that have found something nearer
//!     node: which of eight children may any ray meet?  all at once
//!           each such child: which groups may meet it?  all at once; ask for its memory
//!           which rays of groups that came apart meet it?  a few: alone from here
//!           on with the nearest; push the others, the nearer ones last
//!     leaf: each triangle that any ray may hit: which groups?  all at once; then each such group's rays, W at a time
//! ```

use mobula_simd::{F32Lanes, MaskLanes, Token};

use super::beams::{Beams, MIXED, Passage};
use super::loose::{Loose, TOGETHER};
use super::stack::{Entry, Met};
use super::{Paths, Roots, Target, single};
use crate::bvh::block::BLOCK;
use crate::bvh::{Block, Bvh, Child, Node, STACK};
use crate::kernel::groups::{GROUPS, group_size};
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
    let mut stack = [Entry::NONE; STACK];
    let single = if N < FEW || range.len() < FEW {
        u32::MAX
    } else if rays.properties().contains(Properties::COMMON_ORIGIN) {
        together::<T, N, B, H, true>(token, bvh, rays, target, roots, &mut stack, &mut paths.common_origin)
    } else {
        together::<T, N, B, H, false>(token, bvh, rays, target, roots, &mut stack, &mut paths.general)
    };
    if single != 0 {
        rays.inverse_directions(token);
        let mut at = range.start / TOGETHER * TOGETHER;
        while at < range.end {
            let (mut active, mut lane) = (0, 0);
            while lane < TOGETHER && at + lane < range.end {
                if single >> ((at + lane) / group_size(N)) & 1 != 0 {
                    active |= u64::from(rays.active(token, at + lane).bits()) << lane;
                }
                lane += T::LANES;
            }
            if active != 0 {
                paths.single += u64::from(active.count_ones());
                Loose::new(token, bvh, rays, target, at).down(token, active, roots, &mut stack);
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
    stack: &mut [Entry; STACK],
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
        let mut walk = Walk { bvh, rays, target, beams: &mut beams, wide, octant, lanes, stale: 0 };
        for child in roots {
            stack[0] = Entry { child, near: f32::NEG_INFINITY, groups: groups.into() };
            walk.down::<T, COMMON_ORIGIN>(token, stack);
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
    /// Groups with hits since their beam was shortened.
    stale: u32,
    /// A bit a ray: see [`rays_in`](Self::rays_in).
    lanes: [u64; WORDS],
}

impl<const N: usize, B: Block, H: Target<N>> Walk<'_, N, B, H> {
    /// Walks down from `stack[0]`.
    #[inline(always)]
    fn down<T: Token, const COMMON_ORIGIN: bool>(&mut self, token: T, stack: &mut [Entry; STACK]) {
        let mut top = 1;
        while top > 0 {
            top -= 1;
            let mut entry = stack[top];
            let stale = self.stale & entry.groups as u32;
            if stale != 0 {
                self.shorten(token, stale);
            }
            entry.groups = self.beams.reaching::<T, N>(token, entry.groups as u32, entry.near).into();
            if entry.groups == 0 {
                continue;
            }
            // Down to a leaf by the nearest child each time; the others wait.
            while !entry.child.is_leaf() {
                let Some(node) = self.bvh.nodes.get(entry.child.index()) else { return };
                entry = self.nearest::<T, COMMON_ORIGIN>(token, node, entry.groups as u32, stack, &mut top);
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
        let mut passage = Passage::NONE;
        let mut met = self.beams.children(token, node, &mut passage);
        let mut children = Met::new(stack, *top);
        while met != 0 {
            let slot = met.trailing_zeros() as usize % 8;
            met &= met - 1;
            let mut groups = groups & self.beams.meeting::<T, N, COMMON_ORIGIN>(token, node, slot, &passage);
            if groups == 0 {
                continue;
            }
            let child = node.child[slot];
            if groups & self.wide != 0 {
                let (meeting, count) = self.rays_in::<T, COMMON_ORIGIN>(token, node, slot, groups & self.wide);
                groups = groups & !self.wide | meeting;
                if groups == 0 {
                    continue;
                }
                if groups == meeting && count <= LONELY {
                    self.go_alone(token, child, meeting, &mut children);
                    continue;
                }
            }
            self.bvh.prefetch(child);
            // The order of any hits is the node's.
            children.add(Entry { child, near: passage.near[slot], groups: groups.into() }, !H::ANY);
        }
        *top = children.top;
        children.nearest
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
    fn go_alone<T: Token>(&mut self, token: T, child: Child, groups: u32, above: &mut Met) {
        for word in 0..N.div_ceil(64) {
            let mut lanes = self.lanes[word];
            while lanes != 0 {
                let i = 64 * word + lanes.trailing_zeros() as usize;
                lanes &= lanes - 1;
                let edge = single::edge(self.rays, self.bvh.scale, i);
                token.run(single::Alone {
                    bvh: self.bvh,
                    rays: self.rays,
                    target: self.target,
                    child,
                    edge,
                    stack: above.stack,
                    base: above.top,
                    i,
                });
            }
        }
        self.stale |= groups;
    }

    /// Tests the primitives of a leaf against the rays of the groups.
    #[inline(always)]
    fn leaf<T: Token, const COMMON_ORIGIN: bool>(&mut self, token: T, entry: Entry) {
        let size = group_size(N);
        let axis = self.beams.axis();
        let Some(blocks) = self.bvh.blocks.get(entry.child.blocks()) else { return };
        let all = token.mask(u32::MAX);
        for block in blocks {
            let prepared = block.prepare::<N, COMMON_ORIGIN>(self.rays);
            // A group that is one vector is tested in less time than bounded.
            let touched = match self.beams.groups() {
                Some(groups) if size > T::LANES || !entry.groups.is_power_of_two() => {
                    B::touched::<T, N>(token, &prepared, axis, groups)
                }
                _ => [u32::MAX; BLOCK],
            };
            for i in 0..BLOCK {
                let id = block.ids()[i];
                let mut groups = touched[i] & entry.groups as u32;
                if id == NO_HIT {
                    break;
                }
                while groups != 0 {
                    let group = groups.trailing_zeros() as usize % GROUPS;
                    groups &= groups - 1;
                    let mut at = group * size;
                    while at < (group + 1) * size {
                        let (hit, t) =
                            B::test::<T, N, COMMON_ORIGIN, false>(token, &prepared, i, axis, self.rays, at, all);
                        // In a wide vector a hit is as likely as none: a branch would be guessed wrong.
                        if T::LANES >= 8 || hit.any() {
                            let changed = self.target.record(token, self.rays, at, hit, t, id);
                            self.stale |= u32::from(changed) << group;
                        }
                        at += T::LANES;
                    }
                }
            }
        }
    }

    /// Stale groups, and the packet, reach no farther than their farthest ray.
    #[inline(always)]
    fn shorten<T: Token>(&mut self, token: T, mut stale: u32) {
        self.stale &= !stale;
        let size = group_size(N);
        let minus_inf = token.splat(f32::NEG_INFINITY);
        while stale != 0 {
            let group = stale.trailing_zeros() as usize % GROUPS;
            stale &= stale - 1;
            let mut farthest = minus_inf;
            let mut at = group * size;
            while at < (group + 1) * size {
                let t = token.load(&self.rays.t_max[..], at).select(self.rays.active(token, at), minus_inf);
                // On the left of `max` a NaN is passed over: a ray without an interval reaches nowhere.
                farthest = t.max(farthest);
                at += T::LANES;
            }
            self.beams.shorten(token, group, farthest.reduce_max());
        }
        self.beams.shortened::<T, N>(token);
    }
}
