//! A primitive while the tree is built: its bounds and its number in eight floats.
//!
//! High corners are negated, so that two boxes are merged by one minimum of eight lanes. Plain arrays, because a vector of
//! them starts as pages that the system hands out when they are first written.

use mobula_simd::{F32Lanes, Token};

use crate::leaf::{Bounds, FOUR, Four};

/// `[low x, y, z, *, -high x, -y, -z, *]`: each star holds half of the number in its low bits, as a float from 1 on, for
/// arithmetic that passes over it would be slow with denormal numbers.
pub(super) type Reference = [f32; 8];

/// Contains nothing.
pub(super) const EMPTY: Reference = [f32::INFINITY; 8];

/// Coordinates whose squares do not overflow.
const FARTHEST: f32 = 1e18;
const ONE: u32 = 1.0f32.to_bits();

/// Coordinates are multiplied by `unit`; what is then very far away counts as less far.
#[inline(always)]
pub(super) fn new(bounds: &Bounds, unit: f32, index: u32) -> Reference {
    let scaled = |row: &[f32; 4]| {
        let (mut scaled, far) = ([0.0; 4], FOUR.splat(FARTHEST));
        (FOUR.load(row, 0) * FOUR.splat(unit)).min(far).max(-far).store(&mut scaled, 0);
        scaled
    };
    let ([x, y, z, _], [far_x, far_y, far_z, _]) = (scaled(&bounds.low), scaled(&bounds.high));
    let half = |bits: u32| f32::from_bits(ONE | bits & 0xffff);
    [x, y, z, half(index), -far_x, -far_y, -far_z, half(index >> 16)]
}

#[inline(always)]
pub(super) fn index(reference: &Reference) -> u32 {
    reference[3].to_bits() & 0xffff | reference[7].to_bits() << 16
}

/// Takes another box in.
#[inline(always)]
pub(super) fn merge<T: Token>(token: T, to: &mut Reference, other: &Reference) {
    let mut at = 0;
    while at < 8 {
        token.load(to, at).min(token.load(other, at)).store(to, at);
        at += T::LANES;
    }
}

/// Half the surface area; anything when empty.
#[inline(always)]
pub(super) fn half_area(of: &Reference) -> f32 {
    let (x, y, z) = (of[0] + of[4], of[1] + of[5], of[2] + of[6]);
    x * y + (y * z + z * x)
}

/// Twice the middle: what is sorted by.
#[inline(always)]
pub(super) fn middle2(of: &Reference) -> Four {
    FOUR.load(of, 0) - FOUR.load(of, 4)
}
