//! The gradient of a grid's values at points between its samples.

use glam::{DVec3, Vec3};
use mobula_core::volume::Voxel;

use super::field::Field;
use crate::volume::with_voxels;

/// How a gradient is taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Gradient {
    /// That of the field as it is interpolated: exact within a cell, and another one in the next.
    Exact,
    /// Of differences between the samples on both sides, interpolated: it has no jumps.
    Smooth,
}

impl Field {
    /// The gradient in space of what samples are stored as, at points given in cells.
    pub fn gradients(&self, points: impl Iterator<Item = DVec3>, how: Gradient, mut out: impl FnMut(usize, Vec3)) {
        let dims = self.grid().dims();
        let back = self.to_cells().matrix3.transpose();
        with_voxels!(self.grid().voxels(), |voxels| {
            for (i, point) in points.enumerate() {
                let gradient = match how {
                    Gradient::Exact => exact(voxels, dims, point),
                    Gradient::Smooth => smooth(voxels, dims, point),
                };
                out(i, (back * gradient).as_vec3());
            }
        });
    }
}

/// The cell that a point is in, the nearest if it is in none, and where in it, from 0 to 1.
#[inline(always)]
fn cell(dims: [usize; 3], point: DVec3) -> ([usize; 3], [f64; 3]) {
    let (mut at, mut part) = ([0; 3], [0.0; 3]);
    for axis in 0..3 {
        // What is no number is at the beginning.
        let (x, last) = (if point[axis].is_nan() { 0.0 } else { point[axis] }, dims[axis].saturating_sub(2));
        at[axis] = (x as usize).min(last);
        part[axis] = (x - at[axis] as f64).clamp(0.0, 1.0);
    }
    (at, part)
}

#[inline(always)]
fn sample<V: Voxel>(voxels: &[V], [nx, ny, _]: [usize; 3], [x, y, z]: [usize; 3]) -> f64 {
    f64::from(voxels[(z * ny + y) * nx + x].to_f32())
}

fn exact<V: Voxel>(voxels: &[V], dims: [usize; 3], point: DVec3) -> DVec3 {
    let (at, [x, y, z]) = cell(dims, point);
    let corner = |i: usize| {
        let at = [0, 1, 2].map(|axis| (at[axis] + (i >> axis & 1)).min(dims[axis] - 1));
        sample(voxels, dims, at)
    };
    let v: [f64; 8] = std::array::from_fn(corner);
    let mix = |a: f64, b: f64, f: f64| a + (b - a) * f;
    DVec3::new(
        mix(mix(v[1] - v[0], v[3] - v[2], y), mix(v[5] - v[4], v[7] - v[6], y), z),
        mix(mix(v[2] - v[0], v[3] - v[1], x), mix(v[6] - v[4], v[7] - v[5], x), z),
        mix(mix(v[4] - v[0], v[5] - v[1], x), mix(v[6] - v[2], v[7] - v[3], x), y),
    )
}

fn smooth<V: Voxel>(voxels: &[V], dims: [usize; 3], point: DVec3) -> DVec3 {
    let (at, [x, y, z]) = cell(dims, point);
    let mut sum = DVec3::ZERO;
    for i in 0..8_usize {
        let at = [0, 1, 2].map(|axis| (at[axis] + (i >> axis & 1)).min(dims[axis] - 1));
        let weigh = |axis: usize, f: f64| if i >> axis & 1 == 0 { 1.0 - f } else { f };
        let weight = weigh(0, x) * weigh(1, y) * weigh(2, z);
        for axis in 0..3 {
            let (mut low, mut high) = (at, at);
            low[axis] = at[axis].saturating_sub(1);
            high[axis] = (at[axis] + 1).min(dims[axis] - 1);
            let apart = (high[axis] - low[axis]).max(1) as f64;
            sum[axis] += weight * (sample(voxels, dims, high) - sample(voxels, dims, low)) / apart;
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::volume::{Grid, GridPlace};

    #[test]
    fn the_gradient_of_a_linear_field_is_the_same_everywhere() {
        let dims = [5, 6, 7];
        let place = GridPlace { origin: DVec3::new(1.0, 2.0, 3.0), ..GridPlace::with_spacing([0.5, 2.0, 4.0]) };
        let value = |i: usize| {
            let p = place.point([i % 5, i / 5 % 6, i / 30].map(|x| x as f64));
            (3.0 * p.x - 2.0 * p.y + 0.25 * p.z) as f32
        };
        let grid = Grid::new(dims, (0..210).map(value).collect::<Vec<_>>().into(), place, [1.0, 0.0]).unwrap();
        let field = Field::new(Arc::new(grid)).unwrap();
        let points = [[1.5, 2.25, 3.75], [0.0, 0.0, 0.0], [4.0, 5.0, 6.0], [-1.0, 99.0, f64::NAN]];
        for how in [Gradient::Exact, Gradient::Smooth] {
            field.gradients(points.map(DVec3::from).into_iter(), how, |i, gradient| {
                assert!((gradient - Vec3::new(3.0, -2.0, 0.25)).length() < 1e-3, "{how:?} {i}: {gradient}");
            });
        }
    }
}
