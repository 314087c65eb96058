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

/// The frustum of all that travel together, as a node's boxes meet it.
#[derive(Clone, Copy, Debug)]
struct Frustum {
    /// The four sides: x from below, y from below, x from above, y from above.
    side: [Side; 4],
    /// The planes of a box that its rays meet first and last.
    near: Plane,
    far: Plane,
    inverse: f32,
    t_min: f32,
    t_max: f32,
    axis: usize,
    backward: bool,
}

/// A side of a frustum: the corner of a box that is farthest inside has these two coordinates.
#[derive(Clone, Copy, Debug)]
struct Side {
    slope: f32,
    x: Plane,
    z: Plane,
}

/// A row of a node's planes, and what to subtract from it: the origin, moved outwards by the margin.
#[derive(Clone, Copy, Debug)]
struct Plane {
    row: usize,
    origin: f32,
}

impl Frustum {
    const NONE: Self = Self {
        side: [Side { slope: 0.0, x: Plane::NONE, z: Plane::NONE }; 4],
        near: Plane::NONE,
        far: Plane::NONE,
        inverse: 0.0,
        t_min: 0.0,
        t_max: 0.0,
        axis: 0,
        backward: false,
    };
}

impl Plane {
    const NONE: Self = Self { row: 0, origin: 0.0 };

    /// These planes of eight children, relative to the origin.
    #[inline(always)]
    fn load<T: Token>(self, token: T, node: &Node, at: usize) -> T::F32 {
        token.load(&node.planes[self.row % 6], at) - token.splat(self.origin)
    }
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
            all: Frustum::NONE,
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
        let axis = usize::from(class / 2) % 3;
        let backward = class & 1 != 0;
        let [x, y, z] = AXES[axis];
        let (low_z, high_z) = (self.plane(z, false), self.plane(z, true));
        let mut side = self.all.side;
        for (k, axis) in [x, y].into_iter().enumerate() {
            let (below, above) = (&self.slope[0][k], &self.slope[1][k]);
            // Where z is negative the bounds are turned, and so is which of them is the outermost.
            let (below, above) = if backward {
                (greatest(below, groups), least(above, groups))
            } else {
                (least(below, groups), greatest(above, groups))
            };
            // slope * z is least, or greatest, at one end of the box.
            let (z_below, z_above) =
                (if below >= 0.0 { low_z } else { high_z }, if above >= 0.0 { high_z } else { low_z });
            side[k] = Side { slope: below, x: self.plane(axis, true), z: z_below };
            side[k + 2] = Side { slope: above, x: self.plane(axis, false), z: z_above };
        }
        let (near, far) = if backward { (high_z, low_z) } else { (low_z, high_z) };
        let inverse = if backward { greatest(&self.inverse, groups) } else { least(&self.inverse, groups) };
        let (t_min, t_max) = (least(&self.t_min, groups), greatest(&self.t_max, groups));
        self.all = Frustum { side, near, far, inverse, t_min, t_max, axis, backward };
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
        let zero = token.splat(0.0);
        let mut met = 0;
        let mut at = 0;
        while at < 8 {
            // Is the box's innermost corner inside of each side?
            let [left, bottom, right, top] = &all.side;
            let room = least4::<T>(
                left.z.load(token, node, at).neg_mul_add(token.splat(left.slope), left.x.load(token, node, at)),
                bottom.z.load(token, node, at).neg_mul_add(token.splat(bottom.slope), bottom.x.load(token, node, at)),
                right.z.load(token, node, at).mul_sub(token.splat(right.slope), right.x.load(token, node, at)),
                top.z.load(token, node, at).mul_sub(token.splat(top.slope), top.x.load(token, node, at)),
            );
            let inverse = token.splat(all.inverse);
            let entry = (all.near.load(token, node, at) * inverse).max(token.splat(all.t_min));
            let exit = all.far.load(token, node, at) * inverse;
            let hit = room.ge(zero) & exit.ge(zero) & entry.le(token.splat(all.t_max));
            entry.store(near, at);
            met |= hit.bits() << at;
            at += T::LANES;
        }
        met & 0xff
    }

    #[inline(always)]
    fn compact(&self) -> bool {
        let [left, bottom, right, top] = &self.all.side;
        (right.slope - left.slope).abs() <= COMPACT && (top.slope - bottom.slope).abs() <= COMPACT
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
    fn margin(&self) -> f32 {
        self.margin
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

/// A frustum no wider than this (a tile of 8x8 pixels is a few thousandths wide) is tested group by group, a wider one,
/// which has come apart, ray by ray.
const COMPACT: f32 = 1.0 / 32.0;

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

    /// The low or high planes along an axis.
    #[inline(always)]
    fn plane(&self, axis: usize, high: bool) -> Plane {
        let origin = self.origin[axis % 3];
        let origin = if high { origin - self.margin } else { origin + self.margin };
        Plane { row: axis + if high { 3 } else { 0 }, origin }
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
fn least4<T: Token>(a: T::F32, b: T::F32, c: T::F32, d: T::F32) -> T::F32 {
    a.min(b).min(c.min(d))
}
