//! The ray packet: rays, hits, and lazily derived values (paper 5.1, 5.1.4).

use core::ops::{Deref, DerefMut, Range};

use crate::{Column, Columns3, Properties, Rays, SubPacket};

/// "No primitive" in [`Hits::primitive`].
pub const NO_HIT: u32 = u32::MAX;

/// What the rays of a packet hit. The distance is the ray's `t_max`.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub struct Hits<const N: usize> {
    /// Primitive id, scene-wide; [`NO_HIT`] where nothing was hit.
    pub primitive: Column<u32, N>,
    /// Material id; filled by the scene after traversal.
    pub material: Column<u32, N>,
}

/// Values derived from rays and hits; the packet's properties say which are there.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(crate) struct Derived<const N: usize> {
    pub(crate) position: Columns3<N>,
    pub(crate) normal: Columns3<N>,
    pub(crate) geometric_normal: Columns3<N>,
    pub(crate) texture: Columns3<N>,
    pub(crate) derivative_u: Columns3<N>,
    pub(crate) derivative_v: Columns3<N>,
}

/// Up to `N` rays with their hits and derived values. It dereferences to its [`Rays`].
///
/// Make one per thread or tile and [`reset`](Self::reset) it: making one clears a few hundred bytes a ray.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub struct RayPacket<const N: usize> {
    rays: Rays<N>,
    /// What was hit.
    pub hits: Hits<N>,
    pub(crate) derived: Derived<N>,
    /// Image coordinates of each sample, in pixels (0.5, 0.5 is the middle of the first pixel).
    pub image: [Column<f32, N>; 2],
    /// Colour of each ray, linear RGB: the result. Written by materials and backgrounds.
    pub color: Columns3<N>,
    /// Index of the channel (viewpoint) that the packet belongs to.
    pub channel: u32,
    /// How many reflections or refractions the rays have behind them.
    pub depth: u32,
}

impl<const N: usize> Default for Hits<N> {
    fn default() -> Self {
        Self { primitive: Column::splat(NO_HIT), material: Column::splat(NO_HIT) }
    }
}

impl<const N: usize> Default for RayPacket<N> {
    fn default() -> Self {
        let zero = [Column::splat(0.0); 3];
        Self {
            rays: Rays::default(),
            hits: Hits::default(),
            derived: Derived {
                position: zero,
                normal: zero,
                geometric_normal: zero,
                texture: zero,
                derivative_u: zero,
                derivative_v: zero,
            },
            image: [Column::splat(0.0); 2],
            color: zero,
            channel: 0,
            depth: 0,
        }
    }
}

impl<const N: usize> RayPacket<N> {
    /// Makes `range` the active rays: full intervals, no hits, no properties.
    ///
    /// # Panics
    /// If the range is not within `0..N`.
    pub fn reset(&mut self, range: Range<usize>) {
        self.rays.reset(range, Properties::empty());
        self.depth = 0;
        self.reset_hits();
    }

    /// Forgets all hits and what was derived from them. The rays and their `t_max` stay.
    pub fn reset_hits(&mut self) {
        let range = self.range();
        self.hits.primitive[range.clone()].fill(NO_HIT);
        self.hits.material[range].fill(NO_HIT);
        self.rays.forget(Properties::OF_HITS);
    }

    /// The rays together with the hits, for kernels.
    #[inline(always)]
    pub fn split(&mut self) -> (&mut Rays<N>, &mut Hits<N>) {
        (&mut self.rays, &mut self.hits)
    }

    /// The parts that a derivation reads, and the one that it writes.
    pub(crate) fn parts(&mut self) -> (&Rays<N>, &Hits<N>, &mut Derived<N>) {
        (&self.rays, &self.hits, &mut self.derived)
    }

    /// Did ray `i` hit anything?
    #[inline(always)]
    pub fn was_hit(&self, i: usize) -> bool {
        self.hits.primitive[i] != NO_HIT
    }

    /// The sub-packet of the rays `range`: it shares this packet's storage (paper 5.1, Figure 6).
    ///
    /// # Panics
    /// If the range is not within the active rays.
    pub fn sub_packet(&mut self, range: Range<usize>) -> SubPacket<'_, N> {
        assert!(self.begin_end_contains(&range), "rays {range:?} of the active {:?}", self.range());
        let properties = self.properties();
        SubPacket::new(self, range, properties)
    }

    fn begin_end_contains(&self, range: &Range<usize>) -> bool {
        let active = self.range();
        range.start <= range.end && active.start <= range.start && range.end <= active.end
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
