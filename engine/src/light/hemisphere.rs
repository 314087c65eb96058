//! Light that comes from everywhere, without shadows.

use glam::Vec3;

use crate::packet::{set_vec3, vec3};
use crate::stack::AmbientLight;

/// A sky and a ground, blended by how much a surface faces up. Equal colours make it constant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hemisphere {
    /// What a surface that faces up gets, linear RGB.
    pub above: Vec3,
    /// What a surface that faces down gets, linear RGB.
    pub below: Vec3,
}

impl Default for Hemisphere {
    fn default() -> Self {
        Self { above: Vec3::new(0.30, 0.33, 0.38), below: Vec3::new(0.12, 0.11, 0.10) }
    }
}

impl AmbientLight for Hemisphere {
    fn illuminate(&self, up: Vec3, normals: [&[f32]; 3], mut out: [&mut [f32]; 3]) {
        let (middle, half_difference) = ((self.above + self.below) * 0.5, (self.above - self.below) * 0.5);
        for i in 0..out[0].len() {
            set_vec3(&mut out, i, middle + half_difference * vec3(&normals, i).dot(up));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blends_between_the_poles() {
        let light = Hemisphere { above: Vec3::ONE, below: Vec3::ZERO };
        let mut out = [[9.0; 3]; 3];
        let [r, g, b] = &mut out;
        light.illuminate(Vec3::Z, [&[0.0, 1.0, 0.0], &[0.0; 3], &[1.0, 0.0, -1.0]], [r, g, b]);
        assert_eq!(out, [[1.0, 0.5, 0.0]; 3]);
    }
}
