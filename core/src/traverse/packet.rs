//! Packets through the tree.
//!
//! ```text
//! groups with nothing in common go ray by ray
//! for each class of the others: stack = [root, all groups of the class]
//!     pop; skip if farther than the farthest hit
//!     node: test eight children against the whole packet at once
//!           each child met: which rays meet it?  a few: alone from here; else push their groups, nearest last
//!     leaf: each primitive against each group's rays, W at a time
//! ```

use mobula_simd::{F32Lanes, MaskLanes, Token};

use super::cull::{Cull, GROUPS, MIXED, group_size};
use super::frusta::Frusta;
use super::intervals::Intervals;
use super::{Paths, Roots, Target, single};
use crate::bvh::{Block, Bvh, Child, Node, STACK};
use crate::kernel::{aabb, load3, splat3, sub};
use crate::{NO_HIT, Properties, Rays};

/// Packets with fewer rays travel ray by ray.
const FEW: usize = 4;
/// So few rays of a packet that meet a child go on alone there: a packet that has come apart (rays to a light from both
/// sides of a silhouette) would test them against all that lies between (after Benthin et al., "Combining Single and
/// Packet-Ray Tracing for Arbitrary Ray Distributions on the Intel MIC Architecture", TVCG 2012).
const LONELY: u32 = 3;

#[derive(Clone, Copy)]
struct Entry {
    child: Child,
    near: f32,
    groups: u32,
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
    let common_origin = rays.properties().contains(Properties::COMMON_ORIGIN);
    if common_origin || B::SHEARS {
        rays.shears(token);
    }
    let mut paths = Paths::default();
    let mut stack = [single::Entry::NONE; STACK];
    let single = if range.len() < FEW {
        u32::MAX
    } else if common_origin {
        together::<T, N, B, H, Frusta>(token, bvh, rays, target, roots, &mut stack, &mut paths.common_origin)
    } else {
        rays.inverse_directions(token);
        together::<T, N, B, H, Intervals>(token, bvh, rays, target, roots, &mut stack, &mut paths.general)
    };
    if single != 0 {
        rays.inverse_directions(token);
        for i in range {
            if single >> (i / group_size(N)) & 1 != 0 {
                token.run(single::Alone { bvh, rays, target, roots, stack: &mut stack, i });
                paths.single += 1;
            }
        }
    }
    paths
}

/// Traces the groups that have something in common; returns the others.
#[inline(always)]
fn together<T: Token, const N: usize, B: Block, H: Target<N>, C: Cull>(
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
    let mut cull = C::new(token, rays, bvh.scale);
    let (mut left, mut alone) = (0u32, 0u32);
    for group in range.start / size..range.end.div_ceil(size) {
        if cull.class(group) == MIXED {
            alone |= 1 << group;
        } else {
            left |= 1 << group;
            *traced += (range.end.min((group + 1) * size) - range.start.max(group * size)) as u64;
        }
    }
    let mut stack = [Entry { child: bvh.root, near: 0.0, groups: 0 }; STACK];
    while left != 0 {
        let class = cull.class(left.trailing_zeros() as usize);
        let mut groups = 0;
        for group in 0..GROUPS {
            groups |= u32::from(cull.class(group) == class) << group;
        }
        left &= !groups;
        cull.gather(groups, class);
        let compact = cull.compact();
        if !compact {
            rays.inverse_directions(token);
        }
        let octant = if compact { MIXED } else { rays.octant().unwrap_or(MIXED) };
        let lanes = [0; GROUPS];
        let mut walk = Walk { bvh, rays, target, cull: &mut cull, compact, octant, lanes, stack: alone_stack };
        for child in roots {
            stack[0] = Entry { child, near: f32::NEG_INFINITY, groups };
            walk.down(token, &mut stack);
        }
    }
    alone
}

struct Walk<'a, const N: usize, B, H, C> {
    bvh: &'a Bvh<B>,
    rays: &'a mut Rays<N>,
    target: &'a mut H,
    cull: &'a mut C,
    /// Are children tested group by group, not ray by ray?
    compact: bool,
    /// Signs of all directions (bit k: axis k is negative), or `MIXED`.
    octant: u8,
    /// Rays of each group: see [`rays_in`](Self::rays_in).
    lanes: [u64; GROUPS],
    /// For rays that go on alone.
    stack: &'a mut [single::Entry; STACK],
}

impl<const N: usize, B: Block, H: Target<N>, C: Cull> Walk<'_, N, B, H, C> {
    /// Walks down from `stack[0]`.
    #[inline(always)]
    fn down<T: Token>(&mut self, token: T, stack: &mut [Entry; STACK]) {
        let mut top = 1;
        while top > 0 {
            top -= 1;
            let entry = stack[top];
            if entry.near > self.cull.farthest() {
                continue;
            }
            if entry.child.is_leaf() {
                self.leaf(token, entry);
            } else if let Some(node) = self.bvh.nodes.get(entry.child.index()) {
                self.node(token, node, entry.groups, stack, &mut top);
            }
        }
    }

    /// Pushes the children of `node` that any of the groups' rays meets, the nearest last. Where only a few rays meet a
    /// child, they go on alone at once.
    #[inline(always)]
    fn node<T: Token>(&mut self, token: T, node: &Node, groups: u32, stack: &mut [Entry; STACK], top: &mut usize) {
        let mut nears = [0.0f32; 8];
        let mut met = self.cull.children(token.narrow(), node, &mut nears);
        let first = *top;
        while met != 0 {
            let slot = met.trailing_zeros() as usize % 8;
            met &= met - 1;
            let child = node.child[slot];
            let (groups, count) = if self.compact {
                let several = N > 16 && groups & (groups - 1) != 0;
                let count = N.div_ceil(group_size(N));
                let met = if several { self.cull.groups(token.narrow(), node, slot, count) } else { u32::MAX };
                (groups & met, if groups & met == 0 { 0 } else { u32::MAX })
            } else {
                self.rays_in(token, node, slot, groups)
            };
            if count == 0 {
                continue;
            }
            if count <= LONELY {
                self.go_alone(token, child, groups);
                continue;
            }
            // Insertion: the farthest child stays lowest.
            let near = nears[slot];
            let mut place = *top;
            while place > first && stack[place - 1].near < near {
                stack[place] = stack[place - 1];
                place -= 1;
            }
            stack[place] = Entry { child, near, groups };
            *top += 1;
        }
    }

    /// Which groups have rays that meet a child's box, and how many rays; `self.lanes` says which.
    #[inline(always)]
    fn rays_in<T: Token>(&mut self, token: T, node: &Node, slot: usize, groups: u32) -> (u32, u32) {
        let size = group_size(N);
        let margin = self.cull.margin();
        let [mut low, mut high] = [[0.0; 3]; 2];
        for axis in 0..3 {
            let origin = if C::COMMON_ORIGIN { self.rays.origins()[axis][self.rays.range().start] } else { 0.0 };
            low[axis] = node.planes[axis][slot % 8] - (origin + margin);
            high[axis] = node.planes[axis + 3][slot % 8] - (origin - margin);
            if self.octant >> axis & 1 != 0 {
                (low[axis], high[axis]) = (high[axis], low[axis]);
            }
        }
        let (low, high) = (splat3(token, low), splat3(token, high));
        let (mut met, mut count) = (0, 0);
        let mut left = groups;
        while left != 0 {
            let group = left.trailing_zeros() as usize % GROUPS;
            left &= left - 1;
            let mut lanes = 0u64;
            let mut at = group * size;
            while at < N.min((group + 1) * size) {
                let inverse = load3(token, self.rays.inverse_columns(), at);
                let (mut to_low, mut to_high) = (low, high);
                if !C::COMMON_ORIGIN {
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
                let hit = hit & self.rays.active(token, at);
                lanes |= u64::from(hit.bits()) << (at - group * size);
                at += T::LANES;
            }
            self.lanes[group] = lanes;
            met |= u32::from(lanes != 0) << group;
            count += lanes.count_ones();
        }
        (met, count)
    }

    /// Traces the rays in `self.lanes` of the groups through a child, one by one.
    #[inline(always)]
    fn go_alone<T: Token>(&mut self, token: T, child: Child, groups: u32) {
        let mut left = groups;
        while left != 0 {
            let group = left.trailing_zeros() as usize % GROUPS;
            left &= left - 1;
            let mut lanes = self.lanes[group];
            while lanes != 0 {
                let i = group * group_size(N) + lanes.trailing_zeros() as usize;
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
    fn leaf<T: Token>(&mut self, token: T, entry: Entry) {
        let size = group_size(N);
        let axis = self.cull.axis();
        let Some(blocks) = self.bvh.blocks.get(entry.child.blocks()) else { return };
        let mut changed = 0u32;
        for block in blocks {
            let prepared = if C::COMMON_ORIGIN {
                block.prepare::<N, true>(self.rays)
            } else {
                block.prepare::<N, false>(self.rays)
            };
            for (i, &id) in block.ids().iter().enumerate() {
                if id == NO_HIT {
                    break;
                }
                let mut groups = entry.groups;
                while groups != 0 {
                    let group = groups.trailing_zeros() as usize;
                    groups &= groups - 1;
                    let mut at = group * size;
                    while at < N.min((group + 1) * size) {
                        let (hit, t) = if C::COMMON_ORIGIN {
                            B::test::<T, N, true>(token, &prepared, i, axis, self.rays, at)
                        } else {
                            B::test::<T, N, false>(token, &prepared, i, axis, self.rays, at)
                        };
                        if hit.any() && self.target.record(token, self.rays, at, hit, t, id) {
                            changed |= 1 << group;
                        }
                        at += T::LANES;
                    }
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
            while at < N.min((group + 1) * size) {
                let t = token.load(&self.rays.t_max[..], at).select(self.rays.active(token, at), minus_inf);
                farthest = farthest.max(t);
                at += T::LANES;
            }
            self.cull.farthest_of_groups()[group] = farthest.reduce_max();
        }
        self.cull.shorten();
    }
}
