//! The samples of a brick as floats: what rays are tested against, whatever type the samples have.

use super::voxel::Voxel;

// A row along x is as long as the vectors that single rays are tested with.
pub use crate::kernel::trilinear::CELLS;

/// Samples along each axis: those on the far faces too, which neighbours share.
const SIDES: [usize; 3] = [CELLS[0] + 1, CELLS[1] + 1, CELLS[2] + 1];
/// Samples, and room for the last row to be read in vectors.
const ROOM: usize = SIDES[0] * SIDES[1] * SIDES[2] + 15;

/// The samples at the corners of the cells of a brick.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub struct Brick {
    values: [f32; ROOM],
    /// Are all of them finite?
    pub finite: bool,
}

impl Brick {
    /// Zeros.
    pub const EMPTY: Self = Self { values: [0.0; ROOM], finite: true };

    /// Copies the samples of a grid from sample `first` on; beyond the last ones, these are repeated. What is not finite becomes NaN,
    /// minus zero zero.
    #[inline(always)]
    pub fn load<V: Voxel>(&mut self, voxels: &[V], samples: [usize; 3], first: [usize; 3]) {
        let [nx, ny, nz] = samples;
        let count = SIDES[0].min(nx - first[0]);
        let mut sum = 0.0;
        for k in 0..SIDES[2] {
            for j in 0..SIDES[1] {
                let (y, z) = ((first[1] + j).min(ny - 1), (first[2] + k).min(nz - 1));
                let start = (z * ny + y) * nx + first[0];
                let row = &voxels[start..start + count];
                let out = &mut self.values[Self::row(j, k)..][..SIDES[0]];
                // Most rows are whole: their number of samples is known when this is compiled.
                if let Ok(whole) = <&[V; SIDES[0]]>::try_from(row) {
                    for i in 0..SIDES[0] {
                        out[i] = whole[i].to_f32() + 0.0;
                        // NaN if one is not finite.
                        sum += if V::FINITE { 0.0 } else { out[i] * 0.0 };
                    }
                } else {
                    for i in 0..SIDES[0] {
                        out[i] = row[i.min(count - 1)].to_f32() + 0.0;
                        sum += out[i] * 0.0;
                    }
                }
            }
        }
        self.finite = sum == 0.0;
        if !self.finite {
            for value in &mut self.values {
                *value = if value.is_finite() { *value } else { f32::NAN };
            }
        }
    }

    /// Where a row of samples begins.
    #[inline(always)]
    fn row(j: usize, k: usize) -> usize {
        (k * SIDES[1] + j) * SIDES[0]
    }

    /// All samples, and where those of corner `corner` of the cells of row (j, k) begin.
    #[inline(always)]
    pub fn corners(&self, j: usize, k: usize, corner: usize) -> (&[f32], usize) {
        (&self.values, Self::row(j + (corner >> 1 & 1), k + (corner >> 2)) + (corner & 1))
    }
}
