//! Ray/box: the slab test (Kay and Kajiya 1986), for W rays and a box or a ray and W boxes.
//!
//! - NaN: a NaN in the ray or box makes the answer arbitrary; builders let no NaN in, and packets of NaN rays hit nothing
//!   further down.
//! - Zero direction: reciprocals are finite ([`Rays::inverse_directions`](crate::Rays::inverse_directions)), so the
//!   slab is left at once or never.
//! - Degenerate: an empty box (low above high on some axis by more than rounding) is missed, a flat one can be hit.
//! - Grazing: a ray along a face hits within the rounding of the products; callers that must not lose a ray widen the
//!   box by that (see [`crate::traverse`]).

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

/// A beam of rays against boxes (or beams against a box): the same test by interval arithmetic.
///
/// `to_near` and `to_far` lead from the beam's origins to the planes that its rays meet first and last (so the caller has
/// looked at the signs of the directions, which are the same for all rays of the beam); `inverse` is the least and the
/// greatest reciprocal direction. The entry distance is at most that of any ray; a box that any ray meets is never missed,
/// up to rounding.
#[inline(always)]
pub fn beam<T: Token>(
    _token: T,
    to_near: [T::F32; 3],
    to_far: [T::F32; 3],
    inverse: [[T::F32; 3]; 2],
    t_min: T::F32,
    t_max: T::F32,
) -> (T::Mask, T::F32) {
    let (mut near, mut far) = (t_min, t_max);
    for axis in 0..3 {
        let (least, greatest) = (inverse[0][axis], inverse[1][axis]);
        near = (to_near[axis] * least).min(to_near[axis] * greatest).max(near);
        far = (to_far[axis] * least).max(to_far[axis] * greatest).min(far);
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

/// As [`slabs`], with `scaled` = origin * inverse worked out once per ray: no subtraction per box, where the level fuses
/// one operation a plane. A plane may be off by the rounding of `scaled`, some 2^-24 of the origin's distance to zero:
/// boxes must be widened by that.
#[inline(always)]
pub fn slabs_scaled<T: Token>(
    _token: T,
    near_planes: [T::F32; 3],
    far_planes: [T::F32; 3],
    inverse: [T::F32; 3],
    scaled: [T::F32; 3],
    t_min: T::F32,
    t_max: T::F32,
) -> (T::Mask, T::F32) {
    let (mut near, mut far) = (t_min, t_max);
    for axis in 0..3 {
        near = near_planes[axis].mul_sub(inverse[axis], scaled[axis]).max(near);
        far = far_planes[axis].mul_sub(inverse[axis], scaled[axis]).min(far);
    }
    (near.le(far), near)
}
