//! The ray packet: rays and what they hit (paper 5.1).

use core::ops::{Deref, DerefMut, Range};

use crate::{Column, Properties, Rays};

/// "No primitive" in [`Hits::primitive`].
pub const NO_HIT: u32 = u32::MAX;

/// What the rays of a packet hit. The distance is the ray's `t_max`.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub struct Hits<const N: usize> {
    /// Primitive id; [`NO_HIT`] where nothing was hit.
    pub primitive: Column<u32, N>,
}

impl<const N: usize> Default for Hits<N> {
    fn default() -> Self {
        Self { primitive: Column::splat(NO_HIT) }
    }
}

/// Up to `N` rays with their hits. It dereferences to its [`Rays`].
///
/// Make one per thread or tile and [`reset`](Self::reset) it: making one clears some 80 bytes a ray.
#[derive(Clone, Debug, Default)]
#[repr(C, align(64))]
pub struct RayPacket<const N: usize> {
    rays: Rays<N>,
    /// What was hit.
    pub hits: Hits<N>,
}

impl<const N: usize> RayPacket<N> {
    /// Makes `range` the active rays: full intervals, no hits, no properties.
    ///
    /// # Panics
    /// If the range is not within `0..N`.
    pub fn reset(&mut self, range: Range<usize>) {
        self.rays.reset(range, Properties::empty());
        self.reset_hits();
    }

    /// Forgets all hits. The rays and their `t_max` stay.
    pub fn reset_hits(&mut self) {
        let range = self.range();
        self.hits.primitive[range].fill(NO_HIT);
    }

    /// The rays together with the hits, for kernels.
    #[inline(always)]
    pub fn split(&mut self) -> (&mut Rays<N>, &mut Hits<N>) {
        (&mut self.rays, &mut self.hits)
    }

    /// Did ray `i` hit anything?
    #[inline(always)]
    pub fn was_hit(&self, i: usize) -> bool {
        self.hits.primitive[i] != NO_HIT
    }
}

impl<const N: usize> Deref for RayPacket<N> {
    type Target = Rays<N>;
    #[inline(always)]
    fn deref(&self) -> &Rays<N> {
        &self.rays
    }
}

impl<const N: usize> DerefMut for RayPacket<N> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut Rays<N> {
        &mut self.rays
    }
}
