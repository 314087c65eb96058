//! Backgrounds: what colours the rays that hit nothing.

use std::sync::Arc;

use glam::Vec3;
use mobula_core::SubPacket;

use crate::camera::Up;
use crate::math::normalize;
use crate::scene::BackgroundDescription;
use crate::stack::{Background, Context};

/// The same colour everywhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Constant {
    /// The colour, linear RGB.
    pub color: Vec3,
}

/// From the nadir over the horizon to the zenith, linear in the direction's height.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gradient {
    /// Straight up, linear RGB.
    pub zenith: Vec3,
    /// Level, linear RGB.
    pub horizon: Vec3,
    /// Straight down, linear RGB.
    pub nadir: Vec3,
    /// Unit vector that points up.
    pub up: Vec3,
}

/// The background that a description describes.
pub fn build<const N: usize>(description: &BackgroundDescription, up: Up) -> Arc<dyn Background<N>> {
    match *description {
        BackgroundDescription::Constant { color } => Arc::new(Constant { color }),
        BackgroundDescription::Gradient { zenith, horizon, nadir } => {
            Arc::new(Gradient { zenith, horizon, nadir, up: up.vector() })
        }
    }
}

impl<const N: usize> Background<N> for Constant {
    fn shade(&self, _context: &Context<'_, N>, misses: &mut SubPacket<'_, N>) {
        let range = misses.range();
        for (column, value) in misses.colors_mut().iter_mut().zip(self.color.to_array()) {
            column[range.clone()].fill(value);
        }
    }
}

impl Gradient {
    /// The colour seen along a direction of any length.
    #[inline(always)]
    fn at(&self, direction: Vec3) -> Vec3 {
        let height = normalize(direction).dot(self.up);
        let end = if height < 0.0 { self.nadir } else { self.zenith };
        self.horizon + (end - self.horizon) * height.abs().min(1.0)
    }
}

impl<const N: usize> Background<N> for Gradient {
    fn shade(&self, _context: &Context<'_, N>, misses: &mut SubPacket<'_, N>) {
        for i in misses.range() {
            let (_, direction) = misses.ray(i);
            misses.set_color(i, self.at(direction));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_gradient_passes_through_its_colors() {
        let gradient = Gradient { zenith: Vec3::X, horizon: Vec3::Y, nadir: Vec3::Z, up: Vec3::Z };
        assert_eq!(gradient.at(Vec3::Z * 7.0), Vec3::X);
        assert_eq!(gradient.at(Vec3::X), Vec3::Y);
        assert_eq!(gradient.at(Vec3::NEG_Z), Vec3::Z);
    }
}
