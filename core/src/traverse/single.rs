//! One ray through the tree: against eight boxes and four primitives at a time.

use mobula_simd::{F32Lanes, MaskLanes, Task, Token};

use super::stack::{Entry, Met};
use super::{PAD, Target};
use crate::bvh::block::BLOCK;
use crate::bvh::{Block, Bvh, Child, Node, STACK};
use crate::kernel::splat3;
use crate::{Properties, Rays};

/// A ray in every lane, as primitive kernels want it.
#[derive(Clone, Copy, Debug)]
pub struct SingleRay<T: Token> {
    /// Origin.
    pub origin: [T::F32; 3],
    /// Direction.
    pub direction: [T::F32; 3],
    /// See [`Rays::inverse_directions`].
    pub inverse: [T::F32; 3],
    /// See [`Rays::shears`].
    pub shear: [T::F32; 2],
    /// The dominant axis.
    pub axis: usize,
    /// Does the direction have length 1?
    pub unit: bool,
    /// Near end of the interval.
    pub t_min: T::F32,
    /// Far end, lowered by hits.
    pub t_max: T::F32,
}

/// Traces ray `i` through a subtree: a task, so that packets share one copy of it. The stack is the caller's.
pub(super) struct Alone<'a, const N: usize, B, H> {
    pub(super) bvh: &'a Bvh<B>,
    pub(super) rays: &'a mut Rays<N>,
    pub(super) target: &'a mut H,
    pub(super) child: Child,
    /// See [`edge`].
    pub(super) edge: [[f32; 3]; 2],
    pub(super) stack: &'a mut [Entry; STACK],
    /// Where the stack is free.
    pub(super) base: usize,
    pub(super) i: usize,
}

impl<const N: usize, B: Block, H: Target<N>> Task for Alone<'_, N, B, H> {
    type Output = ();

    #[inline(always)]
    fn run<T: Token>(self, token: T) {
        let Self { bvh, rays, target, child, edge, stack, base, i } = self;
        let mut walk = Walk::new(token.narrow(), bvh, rays, &edge, i, target.id(i));
        walk.down::<N, H>(child, stack, base);
        if let Some((t, id)) = walk.found {
            target.set(rays, i, t, id);
        }
    }
}

/// What to subtract from the distances of low and of high planes: those of ray `i`'s origin, moved outwards by the margin of
/// rounding. NaN, which `min` and `max` pass over, where products overflow, as those of short directions.
#[inline(always)]
pub(super) fn edge<const N: usize>(rays: &Rays<N>, scale: f32, i: usize) -> [[f32; 3]; 2] {
    let (origin, inverse) = (rays.origins(), rays.inverse_columns());
    let largest = (0..3).fold(scale, |s, k| if origin[k][i].abs() > s { origin[k][i].abs() } else { s });
    let margin = largest * PAD;
    let mut edge = [[f32::NAN; 3]; 2];
    for k in 0..3 {
        let inverse = inverse[k][i];
        if (4.0 * largest * inverse).is_finite() {
            (edge[0][k], edge[1][k]) = ((origin[k][i] + margin) * inverse, (origin[k][i] - margin) * inverse);
        }
    }
    edge
}

struct Walk<'a, T: Token, B> {
    token: T,
    bvh: &'a Bvh<B>,
    ray: SingleRay<T>,
    /// What to subtract from the distances of the nearer and farther planes.
    edge: [[T::F32; 3]; 2],
    /// Rows of a node's planes that the ray meets first and last.
    rows: [[usize; 3]; 2],
    t_max: f32,
    id: u32,
    found: Option<(f32, u32)>,
}

impl<'a, T: Token, B: Block> Walk<'a, T, B> {
    #[inline(always)]
    fn new<const N: usize>(token: T, bvh: &'a Bvh<B>, rays: &Rays<N>, edge: &[[f32; 3]; 2], i: usize, id: u32) -> Self {
        let (origin, direction) = (rays.origins(), rays.directions());
        let shear = rays.shear_columns();
        let inverse = rays.inverse_columns();
        let [mut near, mut far] = [[token.splat(0.0); 3]; 2];
        let mut rows = [[0; 3]; 2];
        for k in 0..3 {
            let negative = usize::from(inverse[k][i] < 0.0);
            (near[k], far[k]) = (token.splat(edge[negative][k]), token.splat(edge[1 - negative][k]));
            (rows[0][k], rows[1][k]) = (k + 3 * negative, k + 3 * (1 - negative));
        }
        Self {
            token,
            bvh,
            ray: SingleRay {
                origin: splat3(token, [origin[0][i], origin[1][i], origin[2][i]]),
                direction: splat3(token, [direction[0][i], direction[1][i], direction[2][i]]),
                inverse: splat3(token, [inverse[0][i], inverse[1][i], inverse[2][i]]),
                shear: [token.splat(shear[0][i]), token.splat(shear[1][i])],
                axis: rays.axes()[i] as usize,
                unit: rays.properties().contains(Properties::NORMALIZED_DIRECTIONS),
                t_min: token.splat(rays.t_min()[i]),
                t_max: token.splat(rays.t_max[i]),
            },
            edge: [near, far],
            rows,
            t_max: rays.t_max[i],
            id,
            found: None,
        }
    }

    /// Walks down from a child; what waits is on the stack from `base`.
    #[inline(always)]
    fn down<const N: usize, H: Target<N>>(&mut self, mut child: Child, stack: &mut [Entry; STACK], base: usize) {
        let mut top = base;
        loop {
            // Down to a leaf by the nearest child each time; the others wait.
            while !child.is_leaf() {
                let Some(node) = self.bvh.nodes.get(child.index()) else { return };
                child = self.nearest::<N, H>(node, stack, &mut top);
            }
            self.leaf(child);
            if H::ANY && self.found.is_some() {
                return;
            }
            child = loop {
                if top <= base {
                    return;
                }
                top -= 1;
                if stack[top].near <= self.t_max {
                    break stack[top].child;
                }
            };
        }
    }

    /// The nearest child that the ray meets ([`Child::EMPTY`] if none); pushes the others, the nearer ones last.
    #[inline(always)]
    fn nearest<const N: usize, H: Target<N>>(&self, node: &Node, stack: &mut [Entry; STACK], top: &mut usize) -> Child {
        let token = self.token;
        let mut met = 0u32;
        let mut nears = [0.0f32; 8];
        let mut at = 0;
        while at < 8 {
            let low = node.rows(token, self.rows[0], at);
            let high = node.rows(token, self.rows[1], at);
            let mut near = self.ray.t_min;
            let mut far = self.ray.t_max;
            for k in 0..3 {
                near = low[k].mul_sub(self.ray.inverse[k], self.edge[0][k]).max(near);
                far = high[k].mul_sub(self.ray.inverse[k], self.edge[1][k]).min(far);
            }
            met |= near.le(far).bits() << at;
            near.store(&mut nears, at);
            at += T::LANES;
        }
        let mut children = Met::new(stack, *top);
        while met != 0 {
            let slot = met.trailing_zeros() as usize % 8;
            met &= met - 1;
            let child = node.child[slot];
            self.bvh.prefetch(child);
            children.add(Entry { child, near: nears[slot], groups: 1 }, !H::ANY);
        }
        *top = children.top;
        children.nearest.child
    }

    #[inline(always)]
    fn leaf(&mut self, child: Child) {
        let token = self.token;
        let Some(blocks) = self.bvh.blocks.get(child.blocks()) else { return };
        for block in blocks {
            let mut first = 0;
            while first < BLOCK {
                let (hit, t) = block.test_single(token, &self.ray, first);
                let mut hits = hit.bits();
                if hits != 0 {
                    let mut distance = [0.0; 16];
                    t.store(&mut distance, 0);
                    while hits != 0 {
                        let lane = hits.trailing_zeros() as usize % 16;
                        hits &= hits - 1;
                        let (t, id) = (distance[lane], block.ids()[(first + lane) % BLOCK]);
                        if t < self.t_max || (t == self.t_max && id < self.id) {
                            (self.t_max, self.id) = (t, id);
                            self.found = Some((t, id));
                            self.ray.t_max = token.splat(t);
                        }
                    }
                }
                first += T::LANES;
            }
        }
    }
}
