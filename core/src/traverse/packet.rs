//! Packets through the tree.
//!
//!     groups with nothing in common go ray by ray
//!     for each class of the others: stack = [root, all groups of the class]
//!         pop; skip if farther than the farthest hit
//!         node: test eight children against the whole packet at once
//!               each child met: which groups meet it?  push, nearest last
//!         leaf: each primitive against each group's rays, W at a time

use mobula_simd::{F32Lanes, MaskLanes, Token};

use super::cull::{Cull, GROUPS, MIXED, group_size};
use super::frusta::Frusta;
use super::intervals::Intervals;
use super::{Paths, Roots, Target, single};
use crate::bvh::{Block, Bvh, Child, Node, STACK};
use crate::{NO_HIT, Properties, Rays};

/// Packets with fewer rays travel ray by ray.
const FEW: usize = 4;

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
    let single = if range.len() < FEW {
        u32::MAX
    } else if common_origin {
        together::<T, N, B, H, Frusta>(token, bvh, rays, target, roots, &mut paths.common_origin)
    } else {
        rays.inverse_directions(token);
        together::<T, N, B, H, Intervals>(token, bvh, rays, target, roots, &mut paths.general)
    };
    if single != 0 {
        rays.inverse_directions(token);
        for i in range {
            if single >> (i / group_size(N)) & 1 != 0 {
                single::traverse(token, bvh, rays, target, roots, i);
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
        let mut walk = Walk { bvh, rays, target, cull: &mut cull };
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

    /// Pushes the children of `node` that any of the groups meets, the nearest last.
    #[inline(always)]
    fn node<T: Token>(&mut self, token: T, node: &Node, groups: u32, stack: &mut [Entry; STACK], top: &mut usize) {
        let mut nears = [0.0f32; 8];
        let mut met = self.cull.children(token.narrow(), node, &mut nears);
        let first = *top;
        while met != 0 {
            let slot = met.trailing_zeros() as usize % 8;
            met &= met - 1;
            let mut of_child = groups;
            if N > 16 && groups & (groups - 1) != 0 {
                of_child &= self.cull.groups(token.narrow(), node, slot, N.div_ceil(group_size(N)));
                if of_child == 0 {
                    continue;
                }
            }
            // Insertion: the farthest child stays lowest.
            let near = nears[slot];
            let mut place = *top;
            while place > first && stack[place - 1].near < near {
                stack[place] = stack[place - 1];
                place -= 1;
            }
            stack[place] = Entry { child: node.child[slot], near, groups: of_child };
            *top += 1;
        }
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
