//! Light that comes from everywhere, without shadows.

use glam::Vec3;

use crate::camera::Up;
use crate::scene::AmbientDescription;

/// A sky and a ground, blended by how much a surface faces up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ambient {
    middle: Vec3,
    half_difference: Vec3,
    up: Vec3,
}

impl Ambient {
    /// The hemisphere light of a description.
    pub fn new(description: &AmbientDescription, up: Up) -> Self {
        let AmbientDescription { above, below } = *description;
        Self { middle: (above + below) * 0.5, half_difference: (above - below) * 0.5, up: up.vector() }
    }

    /// What a surface with this unit normal gets.
    #[inline(always)]
    pub fn at(&self, normal: Vec3) -> Vec3 {
        self.middle + self.half_difference * normal.dot(self.up)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blends_between_the_poles() {
        let ambient = Ambient::new(&AmbientDescription { above: Vec3::ONE, below: Vec3::ZERO }, Up::Z);
        assert_eq!([Vec3::Z, Vec3::X, Vec3::NEG_Z].map(|n| ambient.at(n).x), [1.0, 0.5, 0.0]);
    }
}
