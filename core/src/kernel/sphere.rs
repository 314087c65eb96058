//! Ray/sphere.
//!
//! The quadratic in the form of Haines et al., "Precision Improvements for Ray/Sphere Intersection", Ray Tracing Gems
//! (2019), ch. 7: the discriminant comes from the ray's closest approach to the centre, so that small far spheres keep
//! their outline. The nearer root in the interval counts, so a ray from inside hits the far side.
//!
//! - NaN: missed.
//! - Zero direction: missed, and so is one shorter than 2^-50 or longer than 2^63, unless it is promised to be of length 1.
//! - Far: missed where half the way through the sphere, in lengths of the direction, is more than a float holds.
//! - Degenerate: a radius of zero or less is missed, except that a ray exactly through the centre of a zero sphere hits it;
//!   outside of [`RADII`] the answer means nothing.
//! - Grazing: the discriminant's rounding decides; it is within a few ulp of `radius^2 + |closest approach|^2`.

use core::ops::RangeInclusive;

use mobula_simd::{F32Lanes, MaskLanes, Token};

use crate::vector::dot;

/// Squares of lengths outside of this range have lost bits to underflow, or are infinite.
const SQUARES: [f32; 2] = [1.0 / (1u128 << 100) as f32, f32::MAX];

/// The radii of spheres that trees take in, 2^-60 to 2^63 (8.7e-19 to 9.2e18): where the square has lost bits or is infinite,
/// a hit may be anywhere.
pub const RADII: RangeInclusive<f32> = 1.0 / (1u64 << 60) as f32..=(1u64 << 63) as f32;

/// Tests the sphere around `-center` of the ray's origin in the lanes `active`.
///
/// `center` is the vector from the sphere's centre to the ray's origin, `radius2` the squared radius. With `UNIT` the
/// direction is taken to have length 1. Returns which lanes hit and their distances.
#[inline(always)]
pub fn sphere<T: Token, const UNIT: bool>(
    token: T,
    active: T::Mask,
    center: [T::F32; 3],
    radius2: T::F32,
    direction: [T::F32; 3],
    t_min: T::F32,
    t_max: T::F32,
) -> (T::Mask, T::F32) {
    let zero = token.splat(0.0);
    let length2 = if UNIT { token.splat(1.0) } else { dot(direction, direction) };
    let along = dot(center, direction);
    // -middle is where the ray is closest to the centre, `closest` the vector to there.
    let middle = if UNIT { along } else { along / length2 };
    let closest = [
        middle.neg_mul_add(direction[0], center[0]),
        middle.neg_mul_add(direction[1], center[1]),
        middle.neg_mul_add(direction[2], center[2]),
    ];
    let discriminant = radius2 - dot(closest, closest);
    let real = active & discriminant.ge(zero);
    // In a wide vector some ray mostly passes within the radius: a branch would be guessed wrong.
    if T::LANES < 8 && !real.any() {
        return (real, zero);
    }
    // Where the square of the length has lost bits, the hit may be anywhere, and not where boxes let it through.
    let real =
        if UNIT { real } else { real & length2.ge(token.splat(SQUARES[0])) & length2.le(token.splat(SQUARES[1])) };
    let half = if UNIT { discriminant.sqrt() } else { (discriminant / length2).sqrt() };
    let near = -middle - half;
    let far = half - middle;
    let t = near.select(near.gt(t_min), far);
    // Where half is too much for a float, the farther root is no distance, and may be behind.
    let real = if UNIT { real } else { real & t.lt(token.splat(f32::INFINITY)) };
    (real & t.gt(t_min) & t.le(t_max), t)
}
