//! The bounds of the centroids of primitives' boxes: what is split.

use mobula_simd::{F32Lanes, Token};

use super::reference::{Reference, middle2};
use crate::kernel::margin::Frame;
use crate::leaf::{FOUR, Four};

/// How many times as far as most reach primitives count as being among them.
const AMONG: f32 = 4.0;

/// Bounds of centroids, times two.
pub(super) struct CentroidBounds {
    pub(super) low: Four,
    pub(super) high: Four,
}

impl CentroidBounds {
    /// Of nothing.
    #[inline(always)]
    pub(super) fn empty() -> Self {
        Self { low: FOUR.splat(f32::INFINITY), high: FOUR.splat(f32::NEG_INFINITY) }
    }

    #[inline(always)]
    pub(super) fn of(references: &[Reference]) -> Self {
        let mut bounds = Self::empty();
        references.iter().for_each(|reference| bounds.take(reference));
        bounds
    }

    /// Takes the centroid of a box in.
    #[inline(always)]
    pub(super) fn take(&mut self, reference: &Reference) {
        let middle = middle2(reference);
        self.low = middle.min(self.low);
        self.high = middle.max(self.high);
    }

    /// Where most primitives are, in a frame; `unit` is what coordinates were multiplied by. A few far away would leave one cell
    /// for all others.
    pub(super) fn among(&self, frame: &Frame, unit: f32) -> Self {
        let [x, y, z] = frame.center;
        let middle = FOUR.load(&[x, y, z, 0.0], 0) * FOUR.splat(2.0 * unit);
        let reach = FOUR.splat(2.0 * AMONG * unit * frame.size);
        Self { low: self.low.max(middle - reach), high: self.high.min(middle + reach) }
    }

    pub(super) fn merge(&self, other: &Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }
}
