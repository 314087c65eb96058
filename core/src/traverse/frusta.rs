//! Bounds of rays with a common origin: a frustum a group, four planes through the origin.
//!
//! Reshetov, Soupikov and Hurley, "Multi-Level Ray Tracing Algorithm", SIGGRAPH 2005. All directions of a group have the
//! same dominant axis z and go the same way along it; then `x = slope * z` with the slopes that the triangle test shears
//! by, so a frustum is two intervals of slopes and nothing has to be divided. A class is an axis and a way.

use mobula_simd::{F32Lanes, I32Lanes, MaskLanes, Token};

use super::PAD;
use super::cull::{Cull, GROUPS, MIXED, Row, greatest, group_size, least};
use crate::Rays;
use crate::bvh::Node;

/// Four slopes, of x then y: the least and the greatest.
type Slopes<F> = [[F; 2]; 2];

#[derive(Clone, Copy, Debug)]
pub(super) struct Frusta {
    /// Slopes of each group, turned so that `[0]` bounds x from below and `[1]` from above in front of the origin.
    slope: Slopes<Row>,
    /// The reciprocal of the direction along z that is least in size: it makes depths into the least distances.
    inverse: Row,
    t_min: Row,
    t_max: Row,
    class: [u8; GROUPS],
    origin: [f32; 3],
    margin: f32,
    /// The same of all that travel together.
    all: Frustum,
    travelling: u32,
}

#[derive(Clone, Copy, Debug)]
struct Frustum {
    slope: Slopes<f32>,
    inverse: f32,
    t_min: f32,
    t_max: f32,
    axis: usize,
    backward: bool,
}

impl Cull for Frusta {
    const COMMON_ORIGIN: bool = true;

    #[inline(always)]
    fn new<T: Token, const N: usize>(token: T, rays: &Rays<N>, scale: f32) -> Self {
        let range = rays.range();
        let (origin, _) = rays.ray(range.start);
        let origin = origin.to_array();
        let largest = origin.iter().fold(scale, |s, x| if x.abs() > s { x.abs() } else { s });
        let mut frusta = Self {
            slope: [[[0.0; GROUPS]; 2]; 2],
            inverse: [0.0; GROUPS],
            t_min: [f32::INFINITY; GROUPS],
            t_max: [f32::NEG_INFINITY; GROUPS],
            class: [MIXED; GROUPS],
            origin,
            margin: largest * PAD,
            all: Frustum { slope: [[0.0; 2]; 2], inverse: 0.0, t_min: 0.0, t_max: 0.0, axis: 0, backward: false },
            travelling: 0,
        };
        let size = group_size(N);
        for group in range.start / size..range.end.div_ceil(size) {
            if range.start <= group * size && (group + 1) * size <= range.end {
                frusta.look::<T, N, false>(token, rays, group);
            } else {
                frusta.look::<T, N, true>(token, rays, group);
            }
        }
        frusta
    }

    #[inline(always)]
    fn class(&self, group: usize) -> u8 {
        self.class[group]
    }

    #[inline(always)]
    fn gather(&mut self, groups: u32, class: u8) {
        self.travelling = groups;
        let [low, high] = &self.slope;
        self.all = Frustum {
            slope: [
                [least(&low[0], groups), least(&low[1], groups)],
                [greatest(&high[0], groups), greatest(&high[1], groups)],
            ],
            inverse: 0.0,
            t_min: least(&self.t_min, groups),
            t_max: greatest(&self.t_max, groups),
            axis: usize::from(class / 2),
            backward: class % 2 != 0,
        };
        self.all.inverse =
            if self.all.backward { greatest(&self.inverse, groups) } else { least(&self.inverse, groups) };
        if self.all.backward {
            // Behind the origin the lower slope bounds from above: turned already, so the other way round here.
            self.all.slope = [
                [greatest(&low[0], groups), greatest(&low[1], groups)],
                [least(&high[0], groups), least(&high[1], groups)],
            ];
        }
    }

    #[inline(always)]
    fn axis(&self) -> usize {
        self.all.axis
    }

    #[inline(always)]
    fn farthest(&self) -> f32 {
        self.all.t_max
    }

    #[inline(always)]
    fn children<T: Token>(&self, token: T, node: &Node, near: &mut [f32; 8]) -> u32 {
        let all = &self.all;
        let [x, y, z] = AXES[all.axis % 3];
        let zero = token.splat(0.0);
        let mut met = 0;
        let mut at = 0;
        while at < 8 {
            let (z_low, z_high) = self.slab(token, node, z, at);
            let (x_low, x_high) = self.slab(token, node, x, at);
            let (y_low, y_high) = self.slab(token, node, y, at);
            // x <= slope * z must hold for the low side somewhere in the box, and x >= slope * z for the high side.
            let room = least4::<T>(
                pick::<T>(all.slope[0][0] >= 0.0, z_low, z_high).neg_mul_add(token.splat(all.slope[0][0]), x_high),
                pick::<T>(all.slope[0][1] >= 0.0, z_low, z_high).neg_mul_add(token.splat(all.slope[0][1]), y_high),
                pick::<T>(all.slope[1][0] >= 0.0, z_high, z_low).mul_sub(token.splat(all.slope[1][0]), x_low),
                pick::<T>(all.slope[1][1] >= 0.0, z_high, z_low).mul_sub(token.splat(all.slope[1][1]), y_low),
            );
            let (z_near, in_front) = if all.backward { (z_high, z_low.le(zero)) } else { (z_low, z_high.ge(zero)) };
            let entry = (z_near * token.splat(all.inverse)).max(token.splat(all.t_min));
            let hit = room.ge(zero) & in_front & entry.le(token.splat(all.t_max));
            entry.store(near, at);
            met |= hit.bits() << at;
            at += T::LANES;
        }
        met & 0xff
    }

    #[inline(always)]
    fn groups<T: Token>(&self, token: T, node: &Node, slot: usize, groups: usize) -> u32 {
        let all = &self.all;
        let [x, y, z] = AXES[all.axis % 3];
        let (z_low, z_high) = self.slab_of(node, z, slot);
        let (x_low, x_high) = self.slab_of(node, x, slot);
        let (y_low, y_high) = self.slab_of(node, y, slot);
        let z_near = if all.backward { z_high } else { z_low };
        let (z_low, z_high) = (token.splat(z_low), token.splat(z_high));
        let (x_low, x_high) = (token.splat(x_low), token.splat(x_high));
        let (y_low, y_high) = (token.splat(y_low), token.splat(y_high));
        let mut met = 0;
        let mut at = 0;
        while at < groups {
            let (low_x, low_y) = (token.load(&self.slope[0][0], at), token.load(&self.slope[0][1], at));
            let (high_x, high_y) = (token.load(&self.slope[1][0], at), token.load(&self.slope[1][1], at));
            let room = least4::<T>(
                z_low.neg_mul_add(low_x, x_high).max(z_high.neg_mul_add(low_x, x_high)),
                z_low.neg_mul_add(low_y, y_high).max(z_high.neg_mul_add(low_y, y_high)),
                z_low.mul_sub(high_x, x_low).max(z_high.mul_sub(high_x, x_low)),
                z_low.mul_sub(high_y, y_low).max(z_high.mul_sub(high_y, y_low)),
            );
            let entry = token.splat(z_near) * token.load(&self.inverse, at);
            met |= (room.ge(token.splat(0.0)) & entry.le(token.load(&self.t_max, at))).bits() << at;
            at += T::LANES;
        }
        met
    }

    #[inline(always)]
    fn farthest_of_groups(&mut self) -> &mut Row {
        &mut self.t_max
    }

    #[inline(always)]
    fn shorten(&mut self) {
        self.all.t_max = greatest(&self.t_max, self.travelling);
    }
}

/// x, y, z in order when the axis z is dominant.
const AXES: [[usize; 3]; 3] = [[1, 2, 0], [2, 0, 1], [0, 1, 2]];

impl Frusta {
    /// Bounds the rays of a group, some of which may be inactive if `MASKED`.
    #[inline(always)]
    fn look<T: Token, const N: usize, const MASKED: bool>(&mut self, token: T, rays: &Rays<N>, group: usize) {
        let size = group_size(N);
        let (inf, minus_inf, zero) = (token.splat(f32::INFINITY), token.splat(f32::NEG_INFINITY), token.splat(0.0));
        let [mut low_x, mut low_y, mut low_i, mut low_t] = [inf; 4];
        let [mut high_x, mut high_y, mut high_i, mut high_t] = [minus_inf; 4];
        let first = rays.range().start.max(group * size);
        let axis = rays.axes()[first];
        let (mut mixed, mut early) = (false, false);
        let mut at = group * size;
        while at < N.min((group + 1) * size) {
            let shear = rays.shear_columns();
            let mut x = [token.load(&shear[0][..], at), token.load(&shear[1][..], at), token.load(&shear[2][..], at)];
            let mut t_min = token.load(&rays.t_min()[..], at);
            let mut t_max = token.load(&rays.t_max[..], at);
            let mut same = token.load_u32(&rays.axes()[..], at).eq(token.splat_i32(axis as i32));
            if MASKED {
                // Inactive lanes become NaN, which min and max pass over.
                let active = rays.active(token, at);
                let nan = token.splat(f32::NAN);
                for x in &mut x {
                    *x = x.select(active, nan);
                }
                t_min = t_min.select(active, nan);
                t_max = t_max.select(active, nan);
                same = same | !active;
            }
            (low_x, high_x) = (x[0].min(low_x), x[0].max(high_x));
            (low_y, high_y) = (x[1].min(low_y), x[1].max(high_y));
            (low_i, high_i) = (x[2].min(low_i), x[2].max(high_i));
            (low_t, high_t) = (t_min.min(low_t), t_max.max(high_t));
            early |= t_min.lt(zero).any();
            mixed |= !same.all();
            at += T::LANES;
        }
        let (low_i, high_i) = (low_i.reduce_min(), high_i.reduce_max());
        let backward = high_i < 0.0;
        let (low_x, low_y, high_x, high_y) =
            (low_x.reduce_min(), low_y.reduce_min(), high_x.reduce_max(), high_y.reduce_max());
        let (low, high) = ([low_x, low_y], [high_x, high_y]);
        for k in 0..2 {
            self.slope[0][k][group] = if backward { high[k] } else { low[k] };
            self.slope[1][k][group] = if backward { low[k] } else { high[k] };
        }
        self.inverse[group] = if backward { high_i } else { low_i };
        self.t_min[group] = low_t.reduce_min();
        self.t_max[group] = high_t.reduce_max();
        mixed |= early || (low_i < 0.0) != backward;
        self.class[group] = if mixed { MIXED } else { axis as u8 * 2 + u8::from(backward) };
    }

    /// The slabs of eight children along an axis, relative to the origin and widened by the margin.
    #[inline(always)]
    fn slab<T: Token>(&self, token: T, node: &Node, axis: usize, at: usize) -> (T::F32, T::F32) {
        let low = token.load(&node.planes[axis % 3], at) - token.splat(self.origin[axis % 3] + self.margin);
        let high = token.load(&node.planes[axis % 3 + 3], at) - token.splat(self.origin[axis % 3] - self.margin);
        (low, high)
    }

    /// The slab of one child.
    #[inline(always)]
    fn slab_of(&self, node: &Node, axis: usize, slot: usize) -> (f32, f32) {
        let low = node.planes[axis % 3][slot % 8] - (self.origin[axis % 3] + self.margin);
        let high = node.planes[axis % 3 + 3][slot % 8] - (self.origin[axis % 3] - self.margin);
        (low, high)
    }
}

#[inline(always)]
fn pick<T: Token>(first: bool, a: T::F32, b: T::F32) -> T::F32 {
    if first { a } else { b }
}

#[inline(always)]
fn least4<T: Token>(a: T::F32, b: T::F32, c: T::F32, d: T::F32) -> T::F32 {
    a.min(b).min(c.min(d))
}
