//! Four triangles.

use mobula_simd::{F32Lanes, I32Lanes, MaskLanes, Token};

use super::block::{BLOCK, Block, Spread};
use super::reference::FOUR;
use super::{Bounds, Bvh, Join, Quality};
use crate::kernel::triangle::{ShearedRay, triangle};
use crate::rays::last_axis;
use crate::traverse::SingleRay;
use crate::{NO_HIT, Rays};

/// The axes in order when the last is dominant.
const AXES: [[usize; 3]; 3] = [[1, 2, 0], [2, 0, 1], [0, 1, 2]];

/// Four triangles by corner, axis, and place.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub struct TriangleBlock {
    corners: [[[f32; BLOCK]; 3]; 3],
    ids: [u32; BLOCK],
}

impl Bvh<TriangleBlock> {
    /// Builds over triangles `0..count`, whose ids are `first_id..first_id + count`. Those with a corner that is not
    /// finite or without area (two corners equal) are left out; [`primitives`](Bvh::primitives) says how many are in.
    pub fn triangles(
        count: usize,
        first_id: u32,
        join: &impl Join,
        corners: impl Fn(usize) -> [[f32; 3]; 3] + Sync,
    ) -> Self {
        Self::build(count, first_id, Quality::Good, join, corners)
    }
}

impl Block for TriangleBlock {
    /// The corners.
    type Primitive = [[f32; 3]; 3];
    const EMPTY: Self = Self { corners: [[[f32::NAN; BLOCK]; 3]; 3], ids: [NO_HIT; BLOCK] };
    const NOWHERE: [[f32; 3]; 3] = [[f32::NAN; 3]; 3];

    type Prepared = [[[f32; BLOCK]; 3]; 3];

    #[inline(always)]
    fn bounds(corners: &[[f32; 3]; 3]) -> Option<Bounds> {
        let [a, b, c] = corners;
        let row = |p: &[f32; 3]| FOUR.load(&[p[0], p[1], p[2], 0.0], 0);
        let (a, b, c) = (row(a), row(b), row(c));
        // What is not finite gives no number.
        let zero = FOUR.splat(0.0);
        let sound =
            (a * zero + b * zero + c * zero).eq(zero).all() && !a.eq(b).all() && !b.eq(c).all() && !c.eq(a).all();
        sound.then(|| {
            let mut bounds = Bounds::EMPTY;
            a.min(b).min(c).store(&mut bounds.low, 0);
            a.max(b).max(c).store(&mut bounds.high, 0);
            bounds
        })
    }

    #[inline(always)]
    fn set(&mut self, place: usize, id: u32, corners: &[[f32; 3]; 3]) {
        for (rows, corner) in self.corners.iter_mut().zip(corners) {
            for (row, &x) in rows.iter_mut().zip(corner) {
                row[place] = x;
            }
        }
        self.ids[place] = id;
    }

    #[inline(always)]
    fn ids(&self) -> &[u32; BLOCK] {
        &self.ids
    }

    #[inline(always)]
    fn prepare<const N: usize, const COMMON_ORIGIN: bool>(&self, rays: &Rays<N>) -> [[[f32; BLOCK]; 3]; 3] {
        let mut corners = self.corners;
        if COMMON_ORIGIN {
            let first = rays.range().start;
            for corner in &mut corners {
                for (row, origin) in corner.iter_mut().zip(rays.origins()) {
                    for x in row {
                        *x -= origin[first];
                    }
                }
            }
        }
        corners
    }

    /// The edge functions of the triangle test are linear in the slopes of a ray; here they are bounded over those of a group.
    /// A triangle is left out if one of them is negative for all rays and one positive.
    ///
    /// Corners are sheared by the middle of all rays first, so that they are small where the triangle is near the rays, and so
    /// is what is lost to rounding. Let u = 2^-24, Z the greatest depth of a corner, and X a bound on all sheared corners for all
    /// rays of the packet. The exact test shears corners with an error of u (Z + X) and rounds products of at most X^2: its
    /// edge functions err by at most u (4 Z X + 6 X^2). Ours have the same error in the corners and the rounding of nine
    /// products of at most 2 X^2: u (4 Z X + 36 X^2). `SLACK` is more than half again of both.
    #[inline(always)]
    fn touches<T: Token>(
        token: T,
        prepared: &[[[f32; BLOCK]; 3]; 3],
        axis: usize,
        spread: &Spread,
        groups: u32,
    ) -> u64 {
        let axes = AXES[axis % 3];
        let zero = token.splat(0.0);
        let together = if T::LANES > BLOCK { (1u32 << (T::LANES / BLOCK)) - 1 } else { 1 };
        let mut touched = 0;
        let mut at = 0;
        while groups >> (at / BLOCK) != 0 {
            if groups >> (at / BLOCK) & together == 0 {
                at += T::LANES;
                continue;
            }
            let mut corners = [[zero; 3]; 3];
            let (mut wide, mut deep) = (zero, zero);
            for (out, corner) in corners.iter_mut().zip(prepared) {
                let depth = token.tile(&corner[axes[2]], at);
                let x = token.splat(spread.center[0]).neg_mul_add(depth, token.tile(&corner[axes[0]], at));
                let y = token.splat(spread.center[1]).neg_mul_add(depth, token.tile(&corner[axes[1]], at));
                wide = x.abs().max(wide).max(y.abs());
                deep = depth.abs().max(deep);
                *out = [x, y, depth];
            }
            let [a, b, c] = corners;
            let wide = deep.mul_add(token.splat(spread.reach), wide);
            let slack = deep.mul_add(token.splat(SLACK[1]), wide * token.splat(SLACK[0]));
            // And more than what underflow loses.
            let error = slack.mul_add(wide, token.splat(1e-30));
            let x = [token.repeat(&spread.middle[0][..], BLOCK, at), token.repeat(&spread.radius[0][..], BLOCK, at)];
            let y = [token.repeat(&spread.middle[1][..], BLOCK, at), token.repeat(&spread.radius[1][..], BLOCK, at)];
            let [u, v, w] = [edge::<T>(c, b, x, y, error), edge::<T>(a, c, x, y, error), edge::<T>(b, a, x, y, error)];
            let positive_not = u[1].min(v[1]).min(w[1]).lt(zero);
            let negative_not = u[0].max(v[0]).max(w[0]).gt(zero);
            touched |= u64::from((!(positive_not & negative_not)).bits()) << at;
            at += T::LANES;
        }
        touched
    }

    #[inline(always)]
    fn test<T: Token, const N: usize, const COMMON_ORIGIN: bool, const OWN_AXES: bool>(
        token: T,
        prepared: &[[[f32; BLOCK]; 3]; 3],
        i: usize,
        axis: usize,
        rays: &Rays<N>,
        at: usize,
    ) -> (T::Mask, T::F32) {
        let shear = rays.shear_columns();
        let (t_min, t_max) = (token.load(&rays.t_min()[..], at), token.load(&rays.t_max[..], at));
        let inverse_forward = token.load(&shear[2][..], at);
        let shear = [token.load(&shear[0][..], at), token.load(&shear[1][..], at)];
        let ray = ShearedRay { shear, inverse_forward, t_min, t_max };
        let axes = if OWN_AXES { [0, 1, 2] } else { AXES[axis % 3] };
        let mut corners = [[token.splat(0.0); 3]; 3];
        for (out, corner) in corners.iter_mut().zip(prepared) {
            for (x, axis) in out.iter_mut().zip(axes) {
                *x = token.splat(corner[axis][i]);
                if !COMMON_ORIGIN {
                    *x = *x - token.load(&rays.origins()[axis][..], at);
                }
            }
        }
        if OWN_AXES {
            let axes = token.load_u32(&rays.axes()[..], at);
            let (on_y, on_z) = (axes.eq(token.splat_i32(1)), axes.eq(token.splat_i32(2)));
            for corner in &mut corners {
                *corner = last_axis::<T>(*corner, on_y, on_z);
            }
        }
        triangle(token, token.mask(u32::MAX), corners, &ray)
    }

    #[inline(always)]
    fn test_single<T: Token>(&self, token: T, ray: &SingleRay<T>, i: usize) -> (T::Mask, T::F32) {
        let axes = AXES[ray.axis % 3];
        let mut corners = [ray.origin; 3];
        for (out, corner) in corners.iter_mut().zip(&self.corners) {
            for (x, axis) in out.iter_mut().zip(axes) {
                *x = token.load(&corner[axis], i) - ray.origin[axis];
            }
        }
        let sheared = ShearedRay {
            shear: ray.shear,
            inverse_forward: ray.inverse[ray.axis % 3],
            t_min: ray.t_min,
            t_max: ray.t_max,
        };
        triangle(token, token.first(BLOCK), corners, &sheared)
    }
}

/// By X^2 and by Z X: see [`touches`](TriangleBlock::touches).
const SLACK: [f32; 2] = [64.0 / (1 << 24) as f32, 16.0 / (1 << 24) as f32];

/// The least and the greatest `(p x q) . (x, y, 1)` for x and y within a radius of a middle, and `error` beyond.
#[inline(always)]
fn edge<T: Token>(p: [T::F32; 3], q: [T::F32; 3], x: [T::F32; 2], y: [T::F32; 2], error: T::F32) -> [T::F32; 2] {
    let along_x = p[2].neg_mul_add(q[1], p[1] * q[2]);
    let along_y = p[0].neg_mul_add(q[2], p[2] * q[0]);
    let constant = p[1].neg_mul_add(q[0], p[0] * q[1]);
    let middle = along_x.mul_add(x[0], along_y.mul_add(y[0], constant));
    let radius = along_x.abs().mul_add(x[1], along_y.abs().mul_add(y[1], error));
    [middle - radius, middle + radius]
}
