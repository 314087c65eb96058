//! Rays of which only is asked whether, or how much of the light, they let through.

use mobula_core::simd::AnyToken;
use mobula_core::sink::Opacity;
use mobula_core::traverse::Paths;

use super::intersect::EveryWidth;
use super::rays::{Rays, StoredAnyHit};

/// Rays of which only is asked whether they hit anything, or how much of the light gets through (shadows): no storage for shading.
#[derive(Clone, Debug)]
pub struct AnyHitPacket {
    stored: StoredAnyHit,
}

impl AnyHitPacket {
    /// A packet for so many rays. The first use is [`reset`](Self::reset).
    ///
    /// # Panics
    /// If there are no packets so wide: see [`PacketWidth::WIDEST`](super::PacketWidth::WIDEST).
    pub fn new(width: usize) -> Self {
        Self { stored: StoredAnyHit::new(width) }
    }

    /// Makes the first `count` rays the active ones: full intervals, no properties.
    ///
    /// # Panics
    /// If there are not so many.
    pub fn reset(&mut self, count: usize) {
        self.stored.reset(count);
    }

    /// The active rays.
    pub fn rays(&self) -> &dyn Rays {
        self.stored.rays()
    }

    /// The active rays, to change.
    pub fn rays_mut(&mut self) -> &mut dyn Rays {
        self.stored.rays_mut()
    }

    /// The [optical depths](super::optical_depth) of what the rays have met, where surfaces let light through.
    pub fn depths(&self) -> &[u32] {
        self.stored.depths()
    }

    /// Finds what is in the way of the rays: see [`Intersect::occlude`](super::Intersect::occlude).
    pub fn occlude<S: EveryWidth + ?Sized>(
        &mut self,
        token: AnyToken,
        structure: &S,
        opacity: Option<&dyn Opacity>,
    ) -> Paths {
        self.stored.occlude(token, structure, opacity)
    }
}
