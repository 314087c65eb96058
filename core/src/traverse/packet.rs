//! Packets through the tree.
//!
//! ```text
//! split the groups by octant; groups without one go ray by ray
//! for each octant: stack = [root, all its groups]
//!     pop; skip if farther than the farthest hit
//!     node: test eight children against the packet's beam at once
//!           each child met: which groups' beams meet it?  push, nearest last
//!     leaf: each primitive against each group's rays, W at a time
//! ```

use mobula_simd::{F32Lanes, MaskLanes, Token};

use super::beams::{Beam, Beams, GROUPS, MIXED, group_size};
use super::{Paths, Roots, Target, single};
use crate::bvh::{Block, Bvh, Child, Node, STACK};
use crate::kernel::{aabb, splat3, sub};
use crate::{NO_HIT, Rays};

/// Groups with fewer rays in all travel ray by ray.
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
    let mut paths = Paths::default();
    let range = rays.range();
    if range.is_empty() || bvh.primitives() == 0 {
        return paths;
    }
    B::derive(token, rays);
    rays.inverse_directions(token);
    let hoisted = B::can_hoist(rays);
    let size = group_size(N);
    let all_groups = range.start / size..range.end.div_ceil(size);
    if range.len() < FEW {
        paths.single += single::traverse(token, bvh, rays, target, roots, range);
        return paths;
    }
    let mut beams = Beams::new(token, rays, bvh.scale);
    let mut left = 0u32;
    for group in all_groups {
        let rays_of = range.start.max(group * size)..range.end.min((group + 1) * size);
        if beams.octant[group] == MIXED {
            paths.single += single::traverse(token, bvh, rays, target, roots, rays_of);
        } else {
            left |= 1 << group;
            if hoisted { paths.common_origin += rays_of.len() as u64 } else { paths.general += rays_of.len() as u64 }
        }
    }
    while left != 0 {
        let octant = beams.octant[left.trailing_zeros() as usize];
        let groups = (0..GROUPS).filter(|&g| beams.octant[g] == octant).fold(0, |m, g| m | 1 << g) & left;
        left &= !groups;
        let beam = beams.around(groups, octant);
        let mut walk = Walk { bvh, rays, target, beams: &mut beams, beam, octant };
        for child in roots {
            let root = Entry { child, near: f32::NEG_INFINITY, groups };
            if hoisted { walk.from::<T, true>(token, root) } else { walk.from::<T, false>(token, root) }
        }
    }
    paths
}

struct Walk<'a, const N: usize, B, H> {
    bvh: &'a Bvh<B>,
    rays: &'a mut Rays<N>,
    target: &'a mut H,
    beams: &'a mut Beams,
    beam: Beam,
    octant: u8,
}

impl<const N: usize, B: Block, H: Target<N>> Walk<'_, N, B, H> {
    #[inline(always)]
    fn from<T: Token, const HOISTED: bool>(&mut self, token: T, root: Entry) {
        let mut stack = [root; STACK];
        let mut top = 1;
        while top > 0 {
            top -= 1;
            let entry = stack[top];
            if entry.near > self.beam.t_max {
                continue;
            }
            if entry.child.is_leaf() {
                self.leaf::<T, HOISTED>(token, entry);
            } else if let Some(node) = self.bvh.nodes.get(entry.child.index()) {
                self.node(token, node, entry.groups, &mut stack, &mut top);
            }
        }
    }

    /// Pushes the children of `node` that any of the groups meets, the nearest last.
    #[inline(always)]
    fn node<T: Token>(&mut self, token: T, node: &Node, groups: u32, stack: &mut [Entry; STACK], top: &mut usize) {
        let narrow = token.narrow();
        let beam = &self.beam;
        let rows = self.rows();
        let mut met = 0u32;
        let mut nears = [0.0f32; 8];
        let mut at = 0;
        while at < 8 {
            let to_near = sub(pick(narrow, node, rows[0], at), splat3(narrow, beam.origin[0]));
            let to_far = sub(pick(narrow, node, rows[1], at), splat3(narrow, beam.origin[1]));
            let inverse = [splat3(narrow, beam.inverse[0]), splat3(narrow, beam.inverse[1])];
            let (hit, near) =
                aabb::beam(narrow, to_near, to_far, inverse, narrow.splat(beam.t_min), narrow.splat(beam.t_max));
            met |= hit.bits() << at;
            near.store(&mut nears, at);
            at += <T::Narrow as Token>::LANES;
        }
        let first = *top;
        while met != 0 {
            let slot = met.trailing_zeros() as usize % 8;
            met &= met - 1;
            let mut of_child = groups;
            if N > 16 && groups.count_ones() > 1 {
                let [mut near, mut far] = [[0.0; 3]; 2];
                for axis in 0..3 {
                    near[axis] = node.planes[rows[0][axis] % 6][slot];
                    far[axis] = node.planes[rows[1][axis] % 6][slot];
                }
                of_child &= self.beams.meet(token, near, far, N.div_ceil(group_size(N)));
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

    /// Rows of a node's planes that this octant meets first and last.
    #[inline(always)]
    fn rows(&self) -> [[usize; 3]; 2] {
        let mut rows = [[0, 1, 2], [3, 4, 5]];
        for axis in 0..3 {
            if self.octant >> axis & 1 != 0 {
                (rows[0][axis], rows[1][axis]) = (axis + 3, axis);
            }
        }
        rows
    }

    #[inline(always)]
    fn leaf<T: Token, const HOISTED: bool>(&mut self, token: T, entry: Entry) {
        let Some(blocks) = self.bvh.blocks.get(entry.child.blocks()) else { return };
        let mut changed = 0u32;
        for block in blocks {
            changed |= leaf::<T, N, B, H, HOISTED>(token, block, self.rays, self.target, entry.groups);
        }
        if changed != 0 {
            self.shorten(token, changed);
        }
    }

    /// After hits in the groups `changed`: their beams, and the packet's, reach no farther than their farthest ray.
    #[inline(always)]
    fn shorten<T: Token>(&mut self, token: T, changed: u32) {
        let size = group_size(N);
        let minus_inf = token.splat(f32::NEG_INFINITY);
        for group in (0..GROUPS).filter(|group| changed >> group & 1 != 0) {
            let mut farthest = minus_inf;
            let mut at = group * size;
            while at < N.min((group + 1) * size) {
                let t = token.load(&self.rays.t_max[..], at).select(self.rays.active(token, at), minus_inf);
                farthest = farthest.max(t);
                at += T::LANES;
            }
            self.beams.t_max[group] = farthest.reduce_max();
        }
        let mut farthest = f32::NEG_INFINITY;
        for (t, octant) in self.beams.t_max.iter().zip(self.beams.octant) {
            if octant == self.octant && *t > farthest {
                farthest = *t;
            }
        }
        self.beam.t_max = farthest;
    }
}

/// The planes `rows` of the children from `at`.
#[inline(always)]
pub(super) fn pick<T: Token>(token: T, node: &Node, rows: [usize; 3], at: usize) -> [T::F32; 3] {
    [
        token.load(&node.planes[rows[0] % 6], at),
        token.load(&node.planes[rows[1] % 6], at),
        token.load(&node.planes[rows[2] % 6], at),
    ]
}

/// Tests the primitives of a block against the rays of the groups; returns the groups in which something was found.
#[inline(always)]
fn leaf<T: Token, const N: usize, B: Block, H: Target<N>, const HOISTED: bool>(
    token: T,
    block: &B,
    rays: &mut Rays<N>,
    target: &mut H,
    groups: u32,
) -> u32 {
    let size = group_size(N);
    let mut changed = 0;
    for (i, &id) in block.ids().iter().enumerate() {
        if id == NO_HIT {
            break;
        }
        let prepared = block.prepare::<T, N, HOISTED>(token, i, rays);
        let mut groups = groups;
        while groups != 0 {
            let group = groups.trailing_zeros() as usize;
            groups &= groups - 1;
            let mut at = group * size;
            while at < N.min((group + 1) * size) {
                let (hit, t) = B::test::<T, N, HOISTED>(token, &prepared, rays, at);
                if hit.any() && target.record(token, rays, at, hit, t, id) {
                    changed |= 1 << group;
                }
                at += T::LANES;
            }
        }
    }
    changed
}
