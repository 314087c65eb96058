//! Ray/sphere: see [`crate::kernel::sphere`].

use mobula_simd::{MaskLanes, Token};

use super::triangle::{difference, dot};
use crate::kernel::sphere::{dismisses, outline, sphere};
use crate::kernel::{load3, splat3, sub};
use crate::lab::Dice;
use crate::lab::find::{RayTest, in_reach, ray_in_reach};
use crate::oracle::{self, Truth};
use crate::{Properties, Rays};

/// The test, with what is known of the rays. A common origin is a hoist; directions of length 1 are another formula.
#[derive(Debug)]
pub struct Sphere<const COMMON_ORIGIN: bool, const UNIT: bool>;

impl<const COMMON_ORIGIN: bool, const UNIT: bool> RayTest for Sphere<COMMON_ORIGIN, UNIT> {
    /// Centre and radius.
    type Primitive = [f32; 4];
    type General = Sphere<false, false>;
    /// The common origin.
    type Common = [f32; 3];
    /// The centre, or the vector from there to the common origin; the squared radius; the outline from a common origin.
    type Prepared<T: Token> = ([T::F32; 3], T::F32, T::F32);
    const PROMISES: Properties = match (COMMON_ORIGIN, UNIT) {
        (true, true) => Properties::COMMON_ORIGIN.union(Properties::NORMALIZED_DIRECTIONS),
        (true, false) => Properties::COMMON_ORIGIN,
        (false, true) => Properties::NORMALIZED_DIRECTIONS,
        (false, false) => Properties::empty(),
    };
    // Lengths are 1 up to 2^-23: twice that in the square, once in the distance, and as much in the general path's rounding.
    const ULPS: u32 = if UNIT { 8 } else { 0 };
    // Lengths of 1 up to rounding: their squares are off by 2^-23 already.
    const GUARD: f64 = 1.0 / (1 << 18) as f64;

    fn draw(dice: &mut Dice<'_>) -> [f32; 4] {
        let [x, y, z] = dice.point();
        [x, y, z, 0.3 * dice.value().abs()]
    }

    fn aim(dice: &mut Dice<'_>, &[x, y, z, radius]: &[f32; 4]) -> [f32; 3] {
        // The centre, the outline (of a distant viewer), or the surface.
        let [a, b, c] = [dice.signed(), dice.signed(), dice.signed()];
        match dice.below(4) {
            0 => [x, y, z],
            1 => [x + radius, y, z],
            2 => [x, y - radius, z],
            _ => [x + a * radius, y + b * radius, z + c * radius],
        }
    }

    #[inline(always)]
    fn common<T: Token, const N: usize>(_token: T, rays: &Rays<N>) -> [f32; 3] {
        rays.ray(rays.range().start % N).0.to_array()
    }

    #[inline(always)]
    fn prepare<T: Token>(token: T, &[x, y, z, radius]: &[f32; 4], origin: [f32; 3]) -> Self::Prepared<T> {
        let (center, radius) = (splat3(token, [x, y, z]), token.splat(radius));
        let center = if COMMON_ORIGIN { sub(splat3(token, origin), center) } else { center };
        let radius2 = radius * radius;
        (center, radius2, if COMMON_ORIGIN { outline(token, center, radius2) } else { radius2 })
    }

    const DISMISSES: bool = COMMON_ORIGIN;

    #[inline(always)]
    fn may_hit<T: Token, const N: usize>(
        token: T,
        &(center, _, outline): &Self::Prepared<T>,
        _i: usize,
        _origin: [f32; 3],
        rays: &Rays<N>,
        from: usize,
    ) -> u64 {
        let mut word = 0u64;
        let mut at = N.min(from + 64).next_multiple_of(T::LANES);
        while at > from {
            at -= T::LANES;
            let direction = load3(token, rays.directions(), at);
            word = word << T::LANES | u64::from(dismisses::<T, UNIT>(outline, center, direction).bits());
        }
        !word & (u64::MAX >> (64 - N.min(64)))
    }

    #[inline(always)]
    fn test<T: Token, const N: usize>(
        token: T,
        &(center, radius2, _): &Self::Prepared<T>,
        _i: usize,
        _origin: [f32; 3],
        rays: &Rays<N>,
        at: usize,
    ) -> (T::Mask, T::F32) {
        let direction = load3(token, rays.directions(), at);
        let (t_min, t_max) = (token.load(&rays.t_min()[..], at), token.load(&rays.t_max[..], at));
        let center = if COMMON_ORIGIN { center } else { sub(load3(token, rays.origins(), at), center) };
        sphere::<T, UNIT>(token, token.mask(u32::MAX), center, radius2, direction, t_min, t_max)
    }

    fn truth(&[x, y, z, radius]: &[f32; 4], _i: usize, ray: &oracle::Ray) -> Option<(Truth, f64)> {
        if !ray_in_reach(ray) || ![x, y, z, radius].into_iter().all(in_reach) || radius == 0.0 {
            return None;
        }
        let truth = oracle::sphere(ray, [x, y, z, radius]);
        let center = difference([x, y, z].map(f64::from), ray.origin);
        let size = ray.origin.iter().fold(libm::sqrt(dot(center, center)) + f64::from(radius), |s, o| s.max(o.abs()));
        let length2 = dot(ray.direction, ray.direction);
        let along = dot(center, ray.direction) / length2;
        let closest2 = dot(center, center) - along * along * length2;
        let half = libm::sqrt((f64::from(radius) * f64::from(radius) - closest2).max(0.0));
        // Moves of the surface by `size` in the middle of the sphere, more towards the outline.
        Some((truth, 4.0 * size * size / half / libm::sqrt(length2)))
    }
}
