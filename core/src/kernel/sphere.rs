//! Ray/sphere.
//!
//! The quadratic in the form of Haines et al., "Precision Improvements for Ray/Sphere Intersection", Ray Tracing Gems
//! (2019), ch. 7: the discriminant comes from the ray's closest approach to the centre, so that small far spheres keep
//! their outline. The nearer root in the interval counts, so a ray from inside hits the far side.
//!
//! - NaN: missed.
//! - Zero direction: missed, and so is one shorter than 2^-50 or longer than 2^63, unless it is promised to be of length 1.
//! - Degenerate: a radius of zero or less is missed, except that a ray exactly through the centre of a zero sphere hits it.
//! - Grazing: the discriminant's rounding decides; it is within a few ulp of `radius^2 + |closest approach|^2`.

use mobula_simd::{F32Lanes, MaskLanes, Token};

use super::dot;

/// Squares of lengths outside of this range have lost bits to underflow, or are infinite.
const SQUARES: [f32; 2] = [1.0 / (1u128 << 100) as f32, f32::MAX];

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
    let room = radius2 - dot(closest, closest);
    let real = active & room.ge(zero);
    if !real.any() {
        return (real, zero);
    }
    // Where the square of the length has lost bits, the hit may be anywhere, and not where boxes let it through.
    let real =
        if UNIT { real } else { real & length2.ge(token.splat(SQUARES[0])) & length2.le(token.splat(SQUARES[1])) };
    let half = if UNIT { room.sqrt() } else { (room / length2).sqrt() };
    let near = -middle - half;
    let far = half - middle;
    let t = near.select(near.gt(t_min), far);
    (real & t.gt(t_min) & t.le(t_max), t)
}

/// The least `(c.d)^2 / d.d` of a ray in direction d that hits a sphere whose centre is `-center` = -c from the origin of
/// all rays, negative from within it. With it, [`dismisses`] costs half of the exact test.
///
/// [`sphere`] hits only if its rounded `closest`, c - (c.d / d.d) d, is no longer than the radius, and the square of that
/// is c.c - (c.d)^2 / d.d. Let u = 2^-24. The same rounded c.d is used here and there; it is off by 3 u |c| |d|, and a
/// `closest` by 2 u |c| from what it is then; directions of length 1 are that up to 2 u, the square up to 4 u. Together with
/// the sums of squares, 18 u c.c of the square may be lost there, and 6 u c.c here: `SLACK` is more than twice that.
///
/// NaN where c.c overflows, which dismisses nothing.
#[inline(always)]
pub fn outline<T: Token>(token: T, center: [T::F32; 3], radius2: T::F32) -> T::F32 {
    let square = dot(center, center);
    square.neg_mul_add(token.splat(SLACK[0]), square) - (radius2 + token.splat(SLACK[1]))
}

/// As a fraction of `c.c`; and what is lost to underflow with the shortest directions.
const SLACK: [f32; 2] = [64.0 / (1 << 24) as f32, 1e-14];

/// Which rays miss for sure the sphere with this [`outline`].
#[inline(always)]
pub fn dismisses<T: Token, const UNIT: bool>(outline: T::F32, center: [T::F32; 3], direction: [T::F32; 3]) -> T::Mask {
    let along = dot(center, direction);
    (along * along).lt(if UNIT { outline } else { outline * dot(direction, direction) })
}
