//! A packet against one box: see [`crate::kernel::aabb`].

use mobula_simd::Token;

use crate::kernel::aabb::{aabb, slabs};
use crate::kernel::{load3, splat3, sub};
use crate::lab::find::{RayTest, in_reach, ray_in_reach};
use crate::lab::{Agrees, Dice};
use crate::oracle::{self, Truth};
use crate::{Properties, Rays};

/// Nothing is known of the rays.
pub const GENERAL: u8 = 0;
/// One origin: the box is moved once.
pub const COMMON_ORIGIN: u8 = 1;
/// One sign an axis: which plane is nearer is known.
pub const CONSTANT_SIGNS: u8 = 2;
/// Both.
pub const COMMON_ORIGIN_CONSTANT_SIGNS: u8 = COMMON_ORIGIN | CONSTANT_SIGNS;

/// The test, by what is known of the rays.
#[derive(Debug)]
pub struct Slab<const CASE: u8>;

impl<const CASE: u8> RayTest for Slab<CASE> {
    /// Low and high corner.
    type Primitive = [[f32; 3]; 2];
    type General = Slab<GENERAL>;
    /// The planes met first and last where that is known, the low and high ones otherwise.
    /// The common origin, and whether directions are negative by axis.
    type Common = ([f32; 3], [bool; 3]);
    type Prepared<T: Token> = [[T::F32; 3]; 2];
    const PROMISES: Properties = match CASE {
        COMMON_ORIGIN => Properties::COMMON_ORIGIN,
        CONSTANT_SIGNS => Properties::CONSTANT_SIGNS,
        COMMON_ORIGIN_CONSTANT_SIGNS => Properties::COMMON_ORIGIN.union(Properties::CONSTANT_SIGNS),
        _ => Properties::empty(),
    };
    // Boxes without NaN give the same bits; with one, the answer is arbitrary.
    const AGREES: Agrees = if CASE & CONSTANT_SIGNS == 0 { Agrees::Exactly } else { Agrees::WithinBound };

    fn draw(dice: &mut Dice<'_>) -> [[f32; 3]; 2] {
        let (a, b) = (dice.point(), dice.point());
        let b = [0, 1, 2].map(|k| a[k] + 0.25 * b[k]);
        [[0, 1, 2].map(|k| a[k].min(b[k])), [0, 1, 2].map(|k| a[k].max(b[k]))]
    }

    fn aim(dice: &mut Dice<'_>, &[low, high]: &[[f32; 3]; 2]) -> [f32; 3] {
        // A corner on each axis half of the time: edges and corners are aimed at often.
        [0, 1, 2].map(|k| match dice.below(4) {
            0 => low[k],
            1 => high[k],
            _ => low[k] + dice.unit() * (high[k] - low[k]),
        })
    }

    #[inline(always)]
    fn derive<T: Token, const N: usize>(token: T, rays: &mut Rays<N>) {
        rays.inverse_directions(token);
    }

    #[inline(always)]
    fn common<const N: usize>(rays: &Rays<N>) -> ([f32; 3], [bool; 3]) {
        let first = rays.range().start % N;
        let [x, y, z] = rays.inverse_columns();
        let negative = [x[first] < 0.0, y[first] < 0.0, z[first] < 0.0];
        (rays.ray(first).0.to_array(), negative)
    }

    #[inline(always)]
    fn prepare<T: Token>(
        token: T,
        corners: &[[f32; 3]; 2],
        (origin, negative): ([f32; 3], [bool; 3]),
    ) -> [[T::F32; 3]; 2] {
        let mut planes = *corners;
        for axis in 0..3 {
            if CASE & CONSTANT_SIGNS != 0 && negative[axis] {
                (planes[0][axis], planes[1][axis]) = (corners[1][axis], corners[0][axis]);
            }
            if CASE & COMMON_ORIGIN != 0 {
                planes[0][axis] -= origin[axis];
                planes[1][axis] -= origin[axis];
            }
        }
        [splat3(token, planes[0]), splat3(token, planes[1])]
    }

    #[inline(always)]
    fn test<T: Token, const N: usize>(
        token: T,
        &[near, far]: &[[T::F32; 3]; 2],
        _common: ([f32; 3], [bool; 3]),
        rays: &Rays<N>,
        at: usize,
    ) -> (T::Mask, T::F32) {
        let (t_min, t_max) = (token.load(&rays.t_min()[..], at), token.load(&rays.t_max[..], at));
        let inverse = load3(token, rays.inverse_columns(), at);
        let (near, far) = if CASE & COMMON_ORIGIN != 0 {
            (near, far)
        } else {
            let origin = load3(token, rays.origins(), at);
            (sub(near, origin), sub(far, origin))
        };
        if CASE & CONSTANT_SIGNS != 0 {
            slabs(token, near, far, inverse, t_min, t_max)
        } else {
            aabb(token, near, far, inverse, t_min, t_max)
        }
    }

    fn truth(corners: &[[f32; 3]; 2], ray: &oracle::Ray) -> Option<(Truth, f64)> {
        let [low, high] = *corners;
        box_truth(low, high, ray)
    }
}

/// What the oracle says of a box, where it can tell.
pub(super) fn box_truth(low: [f32; 3], high: [f32; 3], ray: &oracle::Ray) -> Option<(Truth, f64)> {
    // A NaN makes the answer arbitrary; most are out of reach anyway.
    let interval = !ray.t_min.is_nan() && !ray.t_max.is_nan();
    let usual = interval && ray.direction.iter().all(|&d| in_reach(d as f32));
    if !usual || !ray_in_reach(ray) || !low.iter().chain(&high).all(|&x| in_reach(x)) {
        return None;
    }
    // Boxes whose planes nearly meet have a margin of their own.
    let size = ray.origin.iter().fold(0.0f64, |s, o| s.max(o.abs()));
    let size = low.iter().chain(&high).fold(size, |s, &x| s.max(f64::from(x).abs()));
    let slowest = ray.direction.iter().fold(f64::INFINITY, |s, d| if *d == 0.0 { s } else { s.min(d.abs()) });
    Some((oracle::aabb(ray, low, high), 4.0 * size / slowest))
}
