//! Ray/box: the slab test (Kay and Kajiya 1986), for W rays and a box or a ray and W boxes.
//!
//! - NaN: a NaN in the ray or box makes the answer arbitrary, except where a function says otherwise; builders let no NaN in,
//!   and packets of NaN rays hit nothing further down.
//! - Zero direction: reciprocals are finite ([`Rays::inverse_directions`](crate::Rays::inverse_directions)), so the
//!   slab is left at once or never.
//! - Degenerate: an empty box (low above high on some axis by more than rounding) is missed, a flat one can be hit.
//! - Grazing: a ray along a face hits within the rounding of the products; callers that must not lose a ray widen the
//!   box by that (see [`super::margin`]).

use mobula_simd::{F32Lanes, Token};

/// Entry distance into the box, and which lanes meet it within `[t_min, t_max]`. `to_low` and `to_high` are the box's
/// corners relative to the ray's origin.
#[inline(always)]
pub fn aabb<T: Token>(
    _token: T,
    to_low: [T::F32; 3],
    to_high: [T::F32; 3],
    inverse: [T::F32; 3],
    t_min: T::F32,
    t_max: T::F32,
) -> (T::Mask, T::F32) {
    let (mut near, mut far) = (t_min, t_max);
    for axis in 0..3 {
        let (a, b) = (to_low[axis] * inverse[axis], to_high[axis] * inverse[axis]);
        near = a.min(b).max(near);
        far = a.max(b).min(far);
    }
    (near.le(far), near)
}

/// As [`aabb`], for who knows which planes are met first (by the sign of the direction): half the comparisons. The same
/// bits where there is no NaN.
#[inline(always)]
pub fn slabs<T: Token>(
    _token: T,
    to_near: [T::F32; 3],
    to_far: [T::F32; 3],
    inverse: [T::F32; 3],
    t_min: T::F32,
    t_max: T::F32,
) -> (T::Mask, T::F32) {
    let (mut near, mut far) = (t_min, t_max);
    for axis in 0..3 {
        near = (to_near[axis] * inverse[axis]).max(near);
        far = (to_far[axis] * inverse[axis]).min(far);
    }
    (near.le(far), near)
}

/// What [`padded`] and [`padded_sorted`] subtract from the distances of low and of high planes: those of the origin, moved
/// outwards by `margin`, which widens every box by as much. `away` is the greatest coordinate of the origin. NaN, which
/// the tests pass over, where products with it overflow, as those of short directions; where those with planes do, they are
/// infinite, and the order of distances is kept.
#[inline(always)]
pub fn padded_origin<T: Token>(token: T, origin: T::F32, inverse: T::F32, margin: T::F32, away: T::F32) -> [T::F32; 2] {
    let finite = (away * token.splat(4.0) * inverse).abs().lt(token.splat(f32::INFINITY));
    let inverse = inverse.select(finite, token.splat(f32::NAN));
    [(origin + margin) * inverse, (origin - margin) * inverse]
}

/// As [`aabb`], with [`padded_origin`] worked out once a ray: no subtraction a box, and one operation a plane where the level
/// fuses. A NaN in `padded` leaves its axis out.
#[inline(always)]
pub fn padded<T: Token>(
    _token: T,
    low: [T::F32; 3],
    high: [T::F32; 3],
    inverse: [T::F32; 3],
    padded: [[T::F32; 3]; 2],
    t_min: T::F32,
    t_max: T::F32,
) -> (T::Mask, T::F32) {
    let (mut near, mut far) = (t_min, t_max);
    for axis in 0..3 {
        let a = low[axis].mul_sub(inverse[axis], padded[0][axis]);
        let b = high[axis].mul_sub(inverse[axis], padded[1][axis]);
        near = a.min(b).max(near);
        far = a.max(b).min(far);
    }
    (near.le(far), near)
}

/// As [`padded`], for who knows which planes are met first; `padded` then is of the nearer and of the farther planes.
#[inline(always)]
pub fn padded_sorted<T: Token>(
    _token: T,
    near_planes: [T::F32; 3],
    far_planes: [T::F32; 3],
    inverse: [T::F32; 3],
    padded: [[T::F32; 3]; 2],
    t_min: T::F32,
    t_max: T::F32,
) -> (T::Mask, T::F32) {
    let (mut near, mut far) = (t_min, t_max);
    for axis in 0..3 {
        near = near_planes[axis].mul_sub(inverse[axis], padded[0][axis]).max(near);
        far = far_planes[axis].mul_sub(inverse[axis], padded[1][axis]).min(far);
    }
    (near.le(far), near)
}
