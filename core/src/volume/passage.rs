//! The ways of rays through a grid.

use super::layout::Layout;
use crate::{Column, Columns3};

/// Rays that are marched together at most.
pub const WIDTH: usize = 256;

/// Parts of rays, one row each: `origin + t * direction` for t from `t0` to `t1`.
#[derive(Clone, Copy, Debug)]
pub struct Segments<'a> {
    /// Where the rays start.
    pub origins: [&'a [f32]; 3],
    /// Where they go.
    pub directions: [&'a [f32]; 3],
    /// Where the segments begin, in lengths of the directions.
    pub t0: &'a [f32],
    /// Where they end.
    pub t1: &'a [f32],
}

/// Parts of rays that are within a grid, moved into its cells: sample (i, j, k) is at (i, j, k).
#[derive(Clone, Debug)]
pub struct Passages {
    pub(super) origin: Columns3<WIDTH>,
    pub(super) direction: Columns3<WIDTH>,
    pub(super) inverse: Columns3<WIDTH>,
    /// Where they enter the grid, and where they leave it: empty where the first is not less.
    pub t0: Column<f32, WIDTH>,
    /// Where they leave it.
    pub t1: Column<f32, WIDTH>,
    /// 1 / (t1 - t0).
    pub(super) per_length: Column<f32, WIDTH>,
    /// Lengths of the directions in space and in cells.
    pub(super) space: Column<f32, WIDTH>,
    pub(super) cells: Column<f32, WIDTH>,
    /// Which components of the direction are negative, a bit each.
    pub(super) octant: Column<u32, WIDTH>,
    pub(super) count: usize,
}

impl Default for Passages {
    fn default() -> Self {
        let zero = Column::splat(0.0);
        Self {
            origin: [zero; 3],
            direction: [zero; 3],
            inverse: [zero; 3],
            t0: zero,
            t1: zero,
            per_length: zero,
            space: zero,
            cells: zero,
            octant: Column::splat(0),
            count: 0,
        }
    }
}

impl Passages {
    /// Those of segments. A point (x, y, z) is at the products of `to_cells` with (x, y, z, 1). Says whether any ray meets the grid.
    ///
    /// # Panics
    /// If there are more than [`WIDTH`].
    pub fn enter(&mut self, segments: &Segments<'_>, to_cells: &[[f64; 4]; 3], layout: &Layout) -> bool {
        let count = segments.t0.len();
        assert!(count <= WIDTH, "rays that are marched together");
        self.count = count;
        let most = [0, 1, 2].map(|axis| layout.cells(axis) as f32);
        let mut any = false;
        for i in 0..count {
            let origin = [0, 1, 2].map(|axis| f64::from(segments.origins[axis][i]));
            let direction = [0, 1, 2].map(|axis| segments.directions[axis][i]);
            let (mut near, mut far) = (segments.t0[i], segments.t1[i]);
            let (mut octant, mut square) = (0, 0.0);
            for axis in 0..3 {
                let [a, b, c, d] = to_cells[axis];
                let [x, y, z] = direction.map(f64::from);
                let mut at = (a * origin[0] + b * origin[1] + c * origin[2] + d) as f32;
                let along = (a * x + b * y + c * z) as f32;
                let inverse = 1.0 / along;
                // A ray in a face between bricks is in the lower one. In the first face of all it is above it.
                if at == 0.0 && inverse.is_infinite() {
                    at = f32::MIN_POSITIVE;
                }
                (self.origin[axis][i], self.direction[axis][i], self.inverse[axis][i]) = (at, along, inverse);
                let (low, high) = ((0.0 - at) * inverse, (most[axis] - at) * inverse);
                // What is NaN, of a ray along a face, does not count.
                near = near.max(low.min(high));
                far = far.min(low.max(high));
                octant |= u32::from(along < 0.0) << axis;
                square += along * along;
            }
            let meets = near < far && near.is_finite() && far.is_finite() && square > 0.0;
            any |= meets;
            (self.t0[i], self.t1[i]) = if meets { (near, far) } else { (1.0, 0.0) };
            self.per_length[i] = 1.0 / (far - near);
            let [x, y, z] = direction;
            self.space[i] = libm::sqrtf(x * x + y * y + z * z);
            self.cells[i] = libm::sqrtf(square);
            self.octant[i] = octant;
        }
        any
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.count
    }

    /// Are there none?
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }
}
