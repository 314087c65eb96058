//! A light that is infinitely far away.

use glam::Vec3;

use crate::math::normalize_or;
use crate::stack::{Context, Illumination, Light, Receivers};

/// Parallel light, with hard shadows. The [sun](super::Sun) has a disk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Directional {
    /// Towards the light, of any length; from above along y if it has none.
    pub direction: Vec3,
    /// Radiance that arrives, linear RGB.
    pub color: Vec3,
}

impl Default for Directional {
    /// White, from the upper left.
    fn default() -> Self {
        Self { direction: Vec3::new(-0.4, 1.0, 0.6), color: Vec3::splat(0.9) }
    }
}

impl Light for Directional {
    fn illuminate(&self, _context: &Context<'_>, points: Receivers<'_>, out: &mut Illumination) {
        let count = points.len();
        let direction = normalize_or(self.direction.to_array().map(f64::from), Vec3::Y);
        for axis in 0..3 {
            out.direction[axis][..count].fill(direction[axis]);
            out.radiance[axis][..count].fill(self.color[axis]);
        }
        out.distance[..count].fill(f32::INFINITY);
    }

    fn position(&self, _context: &Context<'_>) -> Option<Vec3> {
        None
    }
}
