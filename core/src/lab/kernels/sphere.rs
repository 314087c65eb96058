//! Ray/sphere: see [`crate::kernel::sphere`] and [`SphereBlock`].

use super::triangle::{difference, dot};
use crate::lab::Dice;
use crate::lab::find::{in_reach, ray_in_reach};
use crate::lab::leaves::LabBlock;
use crate::leaf::SphereBlock;
use crate::oracle::{self, Truth};

impl LabBlock for SphereBlock {
    // Lengths of 1 up to rounding: their squares are off by 2^-23 already.
    const GUARD: f64 = 1.0 / (1 << 18) as f64;

    fn draw(dice: &mut Dice<'_>) -> [f32; 4] {
        let [x, y, z] = dice.point();
        [x, y, z, 0.3 * dice.value().abs()]
    }

    fn aim(dice: &mut Dice<'_>, &[x, y, z, radius]: &[f32; 4]) -> [f32; 3] {
        // The centre, the outline (of a distant viewer), or the surface.
        let [a, b, c] = [dice.signed(), dice.signed(), dice.signed()];
        match dice.below(4) {
            0 => [x, y, z],
            1 => [x + radius, y, z],
            2 => [x, y - radius, z],
            _ => [x + a * radius, y + b * radius, z + c * radius],
        }
    }

    fn tile([a, b, c, _]: [[f32; 3]; 4]) -> [[f32; 4]; 2] {
        let radius = 0.4 * (b[0] - a[0]).abs();
        [[a[0], a[1], a[2], radius], [0.5 * (b[0] + c[0]), 0.5 * (b[1] + c[1]), 0.5 * (b[2] + c[2]), radius]]
    }

    fn primitive(&self, place: usize) -> [f32; 4] {
        self.sphere(place)
    }

    fn truth(&[x, y, z, radius]: &[f32; 4], ray: &oracle::ExactRay) -> Option<(Truth, f64)> {
        if !ray_in_reach(ray) || ![x, y, z, radius].into_iter().all(in_reach) || radius == 0.0 {
            return None;
        }
        let truth = oracle::sphere(ray, [x, y, z, radius]);
        let center = difference([x, y, z].map(f64::from), ray.origin);
        let size = ray.origin.iter().fold(libm::sqrt(dot(center, center)) + f64::from(radius), |s, o| s.max(o.abs()));
        let length2 = dot(ray.direction, ray.direction);
        let along = dot(center, ray.direction) / length2;
        let closest2 = dot(center, center) - along * along * length2;
        let half = libm::sqrt((f64::from(radius) * f64::from(radius) - closest2).max(0.0));
        // Moves of the surface by `size` in the middle of the sphere, more towards the outline.
        Some((truth, 4.0 * size * size / half / libm::sqrt(length2)))
    }
}
