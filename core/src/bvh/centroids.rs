//! The bounds of the centroids of primitives' boxes: what is split.

use mobula_simd::{F32Lanes, Token};

use super::reference::{Reference, middle2};
use crate::leaf::{FOUR, Four};

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

    pub(super) fn merge(&self, other: &Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }
}
