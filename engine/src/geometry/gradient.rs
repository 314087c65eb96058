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
                out(i, (back * gradient.as_dvec3()).as_vec3());
            }
        });
    }
}

/// A cell of a grid, and a point in it.
struct Cell {
    /// Its low corner among the samples.
    base: usize,
    /// From the low corner to the sample before it along each axis, to the next one, and from there to the one behind; 0 where there
    /// is none.
    before: [usize; 3],
    next: [usize; 3],
    behind: [usize; 3],
    /// Where the point is, from 0 to 1.
    part: [f32; 3],
}

impl Cell {
    /// The cell that a point is in, the nearest if it is in none.
    #[inline(always)]
    fn of(dims: [usize; 3], point: DVec3) -> Self {
        let strides = [1, dims[0], dims[0] * dims[1]];
        let mut cell = Self { base: 0, before: [0; 3], next: [0; 3], behind: [0; 3], part: [0.0; 3] };
        for axis in 0..3 {
            // What is no number is at the beginning.
            let (x, last) = (if point[axis].is_nan() { 0.0 } else { point[axis] }, dims[axis].saturating_sub(2));
            let at = (x as usize).min(last);
            let stride = |there: bool| if there { strides[axis] } else { 0 };
            cell.base += at * strides[axis];
            cell.before[axis] = stride(at > 0);
            cell.next[axis] = stride(at + 1 < dims[axis]);
            cell.behind[axis] = stride(at + 2 < dims[axis]);
            cell.part[axis] = (x - at as f64).clamp(0.0, 1.0) as f32;
        }
        cell
    }

    /// For each axis, `along` of the four edges of the cell that go along it, interpolated between them. It gets the low end of an edge.
    #[inline(always)]
    fn between_edges(&self, along: impl Fn(usize, usize) -> f32) -> Vec3 {
        let mix = |a: f32, b: f32, part: f32| a + (b - a) * part;
        let mut out = [0.0; 3];
        for (axis, out) in out.iter_mut().enumerate() {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            let at = |i: usize, j: usize| along(axis, self.base + i * self.next[u] + j * self.next[v]);
            *out = mix(mix(at(0, 0), at(1, 0), self.part[u]), mix(at(0, 1), at(1, 1), self.part[u]), self.part[v]);
        }
        Vec3::from(out)
    }
}

#[inline(always)]
fn exact<V: Voxel>(voxels: &[V], dims: [usize; 3], point: DVec3) -> Vec3 {
    let cell = Cell::of(dims, point);
    cell.between_edges(|axis, low| voxels[low + cell.next[axis]].to_f32() - voxels[low].to_f32())
}

#[inline(always)]
fn smooth<V: Voxel>(voxels: &[V], dims: [usize; 3], point: DVec3) -> Vec3 {
    let cell = Cell::of(dims, point);
    cell.between_edges(|axis, low| {
        let Cell { before, next, behind, part, .. } = &cell;
        let (before, next, behind, part) = (before[axis], next[axis], behind[axis], part[axis]);
        let value = |at: usize| voxels[at].to_f32();
        // Over two steps, or at the ends over one.
        let per = |there: usize| if there > 0 { 0.5 } else { 1.0 };
        let first = (value(low + next) - value(low - before)) * per(before);
        let second = (value(low + next + behind) - value(low)) * per(behind);
        first + (second - first) * part
    })
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
