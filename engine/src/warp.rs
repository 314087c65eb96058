//! Points of a square moved to disks and directions, so that what is even on the square is even there.

use std::f32::consts::FRAC_PI_4;

use mobula_core::simd::{F32Lanes, Token};

use crate::lanes::{add, scale};

/// A point of the unit disk: squares become rings, without tearing them (Shirley and Chiu, "A Low Distortion Map Between Disk and Square",
/// 1997).
#[inline(always)]
pub(crate) fn disk<T: Token>(token: T, [u, v]: [T::F32; 2]) -> [T::F32; 2] {
    let (one, tiny) = (token.splat(1.0), token.splat(f32::MIN_POSITIVE));
    let (a, b) = (u + u - one, v + v - one);
    let wide = a.abs().gt(b.abs());
    let (radius, other) = (a.select(wide, b), b.select(wide, a));
    // At the middle any angle will do.
    let angle = other / radius.select(radius.abs().gt(tiny), one) * token.splat(FRAC_PI_4);
    let (sine, cosine) = sine_and_cosine(token, angle);
    let (long, short) = (radius * cosine, radius * sine);
    [long.select(wide, short), short.select(wide, long)]
}

/// A unit vector about z, as often as its z is large: a point of the disk, and up from there to the sphere.
#[inline(always)]
pub(crate) fn cosine_weighted<T: Token>(token: T, square: [T::F32; 2]) -> [T::F32; 3] {
    let [x, y] = disk(token, square);
    let z = (token.splat(1.0) - x * x - y * y).max(token.splat(0.0)).sqrt();
    [x, y, z]
}

/// A unit vector about z, evenly from the cap of the sphere whose height is `height`: 1 less the cosine of the angle to its rim. The part
/// of the height that is above it is that of the disk's area inside of its point, so thin cones lose no digits. (A sphere seen from
/// outside: Shirley, Wang and Zimmerman, "Monte Carlo Techniques for Direct Lighting Calculations", 1996, section 3.2.)
#[inline(always)]
pub(crate) fn cap<T: Token>(token: T, square: [T::F32; 2], height: T::F32) -> [T::F32; 3] {
    let [x, y] = disk(token, square);
    let below = (x * x + y * y) * height;
    let stretch = (height * (token.splat(2.0) - below)).max(token.splat(0.0)).sqrt();
    [x * stretch, y * stretch, token.splat(1.0) - below]
}

/// Of an angle of at most pi / 4: Taylor series, good to 4e-7.
#[inline(always)]
fn sine_and_cosine<T: Token>(token: T, angle: T::F32) -> (T::F32, T::F32) {
    let q = angle * angle;
    let sine = token.splat(1.0)
        - q * (token.splat(1.0 / 6.0) - q * (token.splat(1.0 / 120.0) - q * token.splat(1.0 / 5040.0)));
    let cosine = token.splat(1.0)
        - q * (token.splat(0.5)
            - q * (token.splat(1.0 / 24.0) - q * (token.splat(1.0 / 720.0) - q * token.splat(1.0 / 40320.0))));
    (angle * sine, cosine)
}

/// A vector about z, turned to be about `normal`, which has unit length (Duff et al., "Building an Orthonormal Basis, Revisited", JCGT
/// 2017).
#[inline(always)]
pub(crate) fn above<T: Token>(token: T, normal: [T::F32; 3], v: [T::F32; 3]) -> [T::F32; 3] {
    let (zero, one) = (token.splat(0.0), token.splat(1.0));
    let sign = (-one).select(normal[2].lt(zero), one);
    let a = -one / (sign + normal[2]);
    let b = normal[0] * normal[1] * a;
    let tangent = [one + sign * normal[0] * normal[0] * a, sign * b, -sign * normal[0]];
    let bitangent = [b, sign + normal[1] * normal[1] * a, -normal[1]];
    add(add(scale(tangent, v[0]), scale(bitangent, v[1])), scale(normal, v[2]))
}
