//! A light without extent.

use glam::Vec3;

use crate::packet::{set_vec3, vec3};
use crate::stack::{Illumination, Light};

/// Light from a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Where it is.
    pub position: Vec3,
    /// Radiance that arrives; with falloff, at distance 1. Linear RGB.
    pub color: Vec3,
    /// Does it get weaker with the square of the distance?
    pub falloff: bool,
}

impl Point {
    /// The light of scenes that have none, at the origin: a little warm, as bright everywhere.
    pub const KEY: Self = Self { position: Vec3::ZERO, color: Vec3::new(0.95, 0.90, 0.82), falloff: false };
}

impl Default for Point {
    /// White, at the origin, as bright everywhere.
    fn default() -> Self {
        Self { position: Vec3::ZERO, color: Vec3::ONE, falloff: false }
    }
}

impl Light for Point {
    /// A point at the light itself gets nothing.
    fn illuminate(&self, points: [&[f32]; 3], out: &mut Illumination) {
        for i in 0..points[0].len() {
            let v = self.position - vec3(&points, i);
            let square = v.dot(v);
            let distance = square.sqrt();
            let usable = square > 0.0 && square < f32::INFINITY;
            let scale = if usable { 1.0 / distance } else { 0.0 };
            set_vec3(&mut out.direction, i, v * scale);
            let weight = match (usable, self.falloff) {
                (false, _) => 0.0,
                (true, false) => 1.0,
                (true, true) => 1.0 / square,
            };
            set_vec3(&mut out.radiance, i, self.color * weight);
            out.distance[i] = distance;
        }
    }

    fn position(&self) -> Option<Vec3> {
        Some(self.position)
    }
}
