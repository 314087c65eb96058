//! A light that is infinitely far away.

use std::ops::Range;

use glam::Vec3;
use mobula_core::Columns3;

use crate::math::normalize_or;
use crate::stack::{Illumination, Light};

/// Parallel light: the sun.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Directional {
    direction: Vec3,
    color: Vec3,
}

impl Directional {
    /// Light from `direction` (towards the light, of any length; from above along y if it has none), of radiance `color`.
    pub fn new(direction: Vec3, color: Vec3) -> Self {
        Self { direction: normalize_or(direction.to_array().map(f64::from), Vec3::Y), color }
    }
}

impl<const N: usize> Light<N> for Directional {
    fn illuminate(&self, _points: &Columns3<N>, range: Range<usize>, out: &mut Illumination<N>) {
        for axis in 0..3 {
            out.direction[axis][range.clone()].fill(self.direction[axis]);
            out.radiance[axis][range.clone()].fill(self.color[axis]);
        }
        out.distance[range].fill(f32::INFINITY);
    }

    fn position(&self) -> Option<Vec3> {
        None
    }
}
