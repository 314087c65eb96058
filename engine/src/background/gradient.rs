//! A sky: blended by the height of the direction.

use glam::Vec3;

use crate::math::normalize;
use crate::packet::{SubPacket, set_vec3, vec3};
use crate::stack::{Background, Context};

/// From the nadir over the horizon to the zenith, linear in the direction's height above the scene's ground. Colours are linear RGB.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gradient {
    /// Straight up.
    pub zenith: Vec3,
    /// Level.
    pub horizon: Vec3,
    /// Straight down.
    pub nadir: Vec3,
}

impl Default for Gradient {
    /// A pale sky over a warm floor.
    fn default() -> Self {
        Self {
            zenith: Vec3::new(0.30, 0.45, 0.70),
            horizon: Vec3::new(0.80, 0.85, 0.90),
            nadir: Vec3::new(0.32, 0.30, 0.28),
        }
    }
}

impl Gradient {
    /// The colour seen along a direction of any length.
    #[inline(always)]
    fn at(&self, up: Vec3, direction: Vec3) -> Vec3 {
        let height = normalize(direction).dot(up);
        let end = if height < 0.0 { self.nadir } else { self.zenith };
        self.horizon + (end - self.horizon) * height.abs().min(1.0)
    }
}

impl Background for Gradient {
    fn shade(&self, context: &Context<'_>, misses: &mut SubPacket<'_>) {
        let up = context.scene.up.vector();
        let count = misses.len();
        let (directions, mut colors) = misses.directions_and_colors();
        for i in 0..count {
            set_vec3(&mut colors, i, self.at(up, vec3(&directions, i)));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_gradient_passes_through_its_colors() {
        let gradient = Gradient { zenith: Vec3::X, horizon: Vec3::Y, nadir: Vec3::Z };
        assert_eq!(gradient.at(Vec3::Z, Vec3::Z * 7.0), Vec3::X);
        assert_eq!(gradient.at(Vec3::Z, Vec3::X), Vec3::Y);
        assert_eq!(gradient.at(Vec3::Z, Vec3::NEG_Z), Vec3::Z);
    }
}
