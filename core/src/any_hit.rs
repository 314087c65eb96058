//! The packet of rays of which only is asked whether they hit anything.

use core::ops::{Deref, DerefMut, Range};

use crate::{Properties, Rays};

/// Rays of which only is asked whether they hit anything (shadows, ambient occlusion): no storage for shading.
/// It dereferences to its [`Rays`]; an occluded ray has `t_max == -inf`.
#[derive(Clone, Debug, Default)]
#[repr(C, align(64))]
pub struct AnyHitPacket<const N: usize> {
    rays: Rays<N>,
}

impl<const N: usize> AnyHitPacket<N> {
    /// Makes `range` the active rays: full intervals, no properties but [`Properties::ANY_HIT`].
    ///
    /// # Panics
    /// If the range is not within `0..N`.
    pub fn reset(&mut self, range: Range<usize>) {
        self.rays.reset(range, Properties::ANY_HIT);
    }

    /// Was ray `i` found to hit something?
    #[inline(always)]
    pub fn occluded(&self, i: usize) -> bool {
        self.rays.t_max[i] == f32::NEG_INFINITY
    }
}

impl<const N: usize> Deref for AnyHitPacket<N> {
    type Target = Rays<N>;
    #[inline(always)]
    fn deref(&self) -> &Rays<N> {
        &self.rays
    }
}

impl<const N: usize> DerefMut for AnyHitPacket<N> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut Rays<N> {
        &mut self.rays
    }
}
