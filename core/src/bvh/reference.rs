//! A primitive while the tree is built: its bounds and its number in eight floats.
//!
//! High corners are negated, so that two boxes are merged by one minimum of eight lanes. Plain arrays, because a vector of
//! them starts as pages that the system hands out when they are first written.

use super::Bounds;

/// `[low x, y, z, number, -high x, -y, -z, 0]`.
pub(super) type Reference = [f32; 8];

/// Contains nothing.
pub(super) const EMPTY: Reference = [f32::INFINITY; 8];

pub(super) fn new(bounds: &Bounds, index: u32) -> Reference {
    let ([x, y, z, _], [far_x, far_y, far_z, _]) = (bounds.low, bounds.high);
    [x, y, z, f32::from_bits(index), -far_x, -far_y, -far_z, 0.0]
}

#[inline(always)]
pub(super) fn index(reference: &Reference) -> u32 {
    reference[3].to_bits()
}

#[inline(always)]
pub(super) fn merge(to: &mut Reference, other: &Reference) {
    for i in 0..8 {
        to[i] = if other[i] < to[i] { other[i] } else { to[i] };
    }
}

/// Half the surface area; anything when empty.
#[inline(always)]
pub(super) fn half_area(of: &Reference) -> f32 {
    let [x, y, z] = [0, 1, 2].map(|axis| of[axis] + of[axis + 4]);
    x * y + (y * z + z * x)
}

/// Twice the middle: what is sorted by.
#[inline(always)]
pub(super) fn middle2(of: &Reference) -> [f32; 4] {
    [of[0] - of[4], of[1] - of[5], of[2] - of[6], 0.0]
}
