//! Ray/triangle: see [`crate::kernel::triangle`], [`crate::kernel::edges`] and [`TriangleBlock`].

use crate::lab::Dice;
use crate::lab::find::{in_reach, ray_in_reach};
use crate::lab::leaves::LabBlock;
use crate::leaf::TriangleBlock;
use crate::oracle::{self, Truth};

impl LabBlock for TriangleBlock {
    const GUARD: f64 = 1.0 / (1 << 19) as f64;

    fn draw(dice: &mut Dice<'_>) -> [[f32; 3]; 3] {
        let middle = dice.point();
        [0; 3].map(|_| {
            let offset = dice.point();
            [0, 1, 2].map(|k| middle[k] + 0.25 * offset[k])
        })
    }

    fn aim(dice: &mut Dice<'_>, &[a, b, c]: &[[f32; 3]; 3]) -> [f32; 3] {
        let (u, v) = (dice.unit(), dice.unit());
        match dice.below(4) {
            0 => a,
            1 => [0, 1, 2].map(|k| b[k] + u * (c[k] - b[k])),
            _ => [0, 1, 2].map(|k| a[k] + u * (b[k] - a[k]) + (1.0 - u) * v * (c[k] - a[k])),
        }
    }

    fn tile([a, b, c, d]: [[f32; 3]; 4]) -> [[[f32; 3]; 3]; 2] {
        [[a, c, b], [b, c, d]]
    }

    fn primitive(&self, place: usize) -> [[f32; 3]; 3] {
        self.corners(place)
    }

    fn truth(&corners: &[[f32; 3]; 3], ray: &oracle::ExactRay) -> Option<(Truth, f64)> {
        if !ray_in_reach(ray) || !corners.iter().flatten().all(|&x| in_reach(x)) {
            return None;
        }
        let truth = oracle::triangle(ray, corners);
        // Where the plane is met at a grazing angle, a small move of the plane is a large one of the hit.
        let [a, b, c] = corners.map(|corner| corner.map(f64::from));
        let (ab, ac) = (difference(b, a), difference(c, a));
        let normal = cross(ab, ac);
        let size = corners.iter().flatten().zip(ray.origin.iter().cycle()).map(|(&x, o)| f64::from(x).abs() + o.abs());
        let size = size.fold(0.0f64, f64::max);
        let slope = dot(normal, ray.direction).abs();
        // A sliver's normal is uncertain by the sliver's shape.
        let shape = dot(ab, ab).max(dot(ac, ac)) / libm::sqrt(dot(normal, normal));
        Some((truth, 4.0 * size * shape * libm::sqrt(dot(normal, normal)) / slope))
    }
}

pub(super) fn difference(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(super) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
