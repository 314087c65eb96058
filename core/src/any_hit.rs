//! The packet of rays of which only is asked whether they hit anything.

use core::ops::{Deref, DerefMut, Range};

use crate::{Column, Properties, Rays};

/// Rays of which only is asked whether they hit anything (shadows, ambient occlusion): no storage for shading.
/// It dereferences to its [`Rays`]; an occluded ray has `t_max == -inf`.
#[derive(Clone, Debug, Default)]
#[repr(C, align(64))]
pub struct AnyHitPacket<const N: usize> {
    rays: Rays<N>,
    depth: Column<u32, N>,
}

impl<const N: usize> AnyHitPacket<N> {
    /// Makes `range` the active rays: full intervals, no properties, and nothing met yet.
    ///
    /// # Panics
    /// If the range is not within `0..N`.
    pub fn reset(&mut self, range: Range<usize>) {
        self.rays.reset(range.clone(), Properties::empty());
        self.depth[range].fill(0);
    }

    /// The optical depth of what each ray has met where primitives have an [`Opacity`](crate::sink::Opacity).
    #[inline(always)]
    pub fn depth(&self) -> &Column<u32, N> {
        &self.depth
    }

    /// The rays together with their optical depths, for traversal.
    #[inline(always)]
    pub(crate) fn split(&mut self) -> (&mut Rays<N>, &mut Column<u32, N>) {
        (&mut self.rays, &mut self.depth)
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
