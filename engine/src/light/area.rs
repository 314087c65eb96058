//! What lights with an area share: where they face, and what arrives from a point of them.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;
use mobula_core::simd::{F32Lanes, Token};

use crate::lanes::{dot, neg, scale, store3, sub};
use crate::math::{normalize, normalize_or};
use crate::stack::Illumination;

/// Unit vectors right, up and forward, where forward is along `direction`, or down along y if that leads nowhere, and up as near to `up`
/// as it can be.
pub(super) fn aim(direction: Vec3, up: Vec3) -> [Vec3; 3] {
    let forward = normalize_or(direction.to_array().map(f64::from), Vec3::NEG_Y);
    let up = normalize_or(up.to_array().map(f64::from), Vec3::Y);
    let across = forward.cross(up);
    let least = if forward.x.abs() < 0.5 { Vec3::X } else { Vec3::Z };
    let right = normalize(if across.dot(across) > 1e-8 { across } else { forward.cross(least) });
    [right, right.cross(forward), forward]
}

/// Sets a vector of rows of `out`, from `at` on, to what arrives at `points` from `chosen` ones of a surface that shines to the side of its
/// unit `normal`, each of which stands for the whole `area`: the estimate of an integral over area (Shirley, Wang and Zimmerman, "Monte
/// Carlo Techniques for Direct Lighting Calculations", 1996, section 2), over pi, as [`Illumination::radiance`] counts.
#[inline(always)]
#[allow(clippy::too_many_arguments, reason = "columns and rows")]
pub(super) fn emit<T: Token>(
    token: T,
    chosen: [T::F32; 3],
    normal: [T::F32; 3],
    area: T::F32,
    color: [T::F32; 3],
    points: [T::F32; 3],
    out: &mut Illumination,
    at: usize,
) {
    let (zero, one) = (token.splat(0.0), token.splat(1.0));
    let v = sub(chosen, points);
    let square = dot(v, v);
    let distance = square.sqrt();
    let direction = scale(v, one / distance);
    let weight = dot(neg(direction), normal) * area / square * token.splat(FRAC_1_PI);
    let usable = square.gt(zero) & weight.gt(zero) & weight.lt(token.splat(f32::INFINITY));
    store3(direction.map(|x| x.select(usable, zero)), &mut out.direction, at);
    store3(scale(color, weight.select(usable, zero)), &mut out.radiance, at);
    distance.store(&mut out.distance, at);
}
