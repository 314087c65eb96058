//! What a stretch of a medium does to light: it takes a part of what comes through, and adds what it emits, less what of that it takes
//! itself (Max, "Optical Models for Direct Volume Rendering", 1995, section 4).
//!
//! - NaN: a stretch whose extinction or emission is NaN gives NaN; [`classify`](super::classify) gives none for a finite transfer function.
//! - A stretch without extinction changes nothing, one of length zero neither.

use mobula_simd::{F32Lanes, I32Lanes, Token};

/// The light of a ray on its way: what is seen so far, and the part of what is behind that comes through.
#[derive(Clone, Copy, Debug)]
pub struct Light<F> {
    /// Radiance, linear RGB.
    pub radiance: [F; 3],
    /// From 1 down to 0.
    pub transmittance: F,
}

/// Adds a stretch of a length behind what is there: its average extinction and emission (extinction times colour).
#[inline(always)]
pub fn absorb<T: Token>(token: T, light: &mut Light<T::F32>, seen: [T::F32; 4], length: T::F32) {
    let depth = seen[0] * length;
    let through = exp_minus(token, depth);
    // Of what is emitted, on average (1 - exp(-x)) / x gets out. That cancels where x is small: there the series.
    let one = token.splat(1.0);
    let series = depth
        .mul_add(token.splat(-1.0 / 24.0), token.splat(1.0 / 6.0))
        .mul_add(depth, token.splat(-0.5))
        .mul_add(depth, one);
    let out = series.select(depth.lt(token.splat(1.0 / 32.0)), (one - through) / depth);
    let weight = light.transmittance * (out * length);
    for i in 0..3 {
        light.radiance[i] = weight.mul_add(seen[i + 1], light.radiance[i]);
    }
    light.transmittance = light.transmittance * through;
}

/// `exp(-x)` for x not below 0; relative error below 3e-7. 0 above 87, where it is hardly a number any more.
#[inline(always)]
pub fn exp_minus<T: Token>(token: T, x: T::F32) -> T::F32 {
    // Rounded to the nearest whole number by the addition.
    let round = token.splat(12_582_912.0);
    let whole = x.mul_add(token.splat(-core::f32::consts::LOG2_E), round) - round;
    // ln 2 in two parts, of which the first has so few bits that its multiples are exact.
    let rest = whole.mul_add(token.splat(-0.693_359_4), -x);
    let rest = whole.mul_add(token.splat(2.121_944_4e-4), rest);
    // The series of exp: |rest| is at most 0.35.
    let mut sum = token.splat(1.0 / 720.0);
    for factor in [1.0 / 120.0, 1.0 / 24.0, 1.0 / 6.0, 0.5, 1.0, 1.0] {
        sum = sum.mul_add(rest, token.splat(factor));
    }
    let power = (whole.to_i32() + token.splat_i32(127)).shl(23).from_bits_f32();
    (sum * power).select(x.le(token.splat(87.0)), token.splat(0.0))
}
