//! The samples of a brick as floats: what rays are tested against, whatever type the samples have.

use mobula_simd::prefetch;

use super::voxel::Voxel;

// A row along x is as long as the vectors that single rays are tested with.
pub use crate::kernel::trilinear::CELLS;

/// Samples along each axis: those on the far faces too, which neighbours share.
pub(super) use crate::kernel::trilinear::SAMPLES as SIDES;
/// Rows of samples, all of them: see [`Brick::load_rows`].
pub(super) const ALL_ROWS: u32 = (1 << (SIDES[1] * SIDES[2])) - 1;
/// Samples, and room for the last row to be read in vectors.
pub(super) const ROOM: usize = SIDES[0] * SIDES[1] * SIDES[2] + 15;

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

    /// Asks for the memory of the rows of samples of a grid from sample `first` on, before they are read.
    #[inline(always)]
    pub fn prefetch<V: Voxel>(voxels: &[V], [nx, ny, nz]: [usize; 3], first: [usize; 3]) {
        for k in 0..SIDES[2] {
            for j in 0..SIDES[1] {
                let (y, z) = ((first[1] + j).min(ny - 1), (first[2] + k).min(nz - 1));
                if let Some(sample) = voxels.get((z * ny + y) * nx + first[0]) {
                    prefetch(sample);
                }
            }
        }
    }

    /// Copies the rows of samples in `rows` (bit j + 5 k is row (j, k)) of a grid from sample `first` on; beyond the last ones, these
    /// are repeated. What is not finite becomes NaN, minus zero zero.
    #[inline(always)]
    pub fn load_rows<V: Voxel>(&mut self, voxels: &[V], samples: [usize; 3], first: [usize; 3], mut rows: u32) {
        let [nx, ny, nz] = samples;
        let count = SIDES[0].min(nx - first[0]);
        while rows != 0 {
            let at = rows.trailing_zeros() as usize % 32;
            rows &= rows - 1;
            let (j, k) = (at % SIDES[1], at / SIDES[1]);
            let (y, z) = ((first[1] + j).min(ny - 1), (first[2] + k).min(nz - 1));
            let start = (z * ny + y) * nx + first[0];
            let row = &voxels[start..start + count];
            let out = &mut self.values[Self::row(j, k)..][..SIDES[0]];
            // Most rows are whole: their number of samples is known when this is compiled. Nothing else is done here, so that many
            // rows are on their way from memory at once.
            if let Ok(whole) = <&[V; SIDES[0]]>::try_from(row) {
                for i in 0..SIDES[0] {
                    out[i] = whole[i].to_f32() + 0.0;
                }
            } else {
                for i in 0..SIDES[0] {
                    out[i] = row[i.min(count - 1)].to_f32() + 0.0;
                }
            }
        }
        let mut wild = 0;
        if !V::FINITE {
            for value in &self.values {
                wild |= is_wild(*value);
            }
        }
        self.finite = wild == 0;
        if !self.finite {
            for value in &mut self.values {
                *value = if value.is_finite() { *value } else { f32::NAN };
            }
        }
    }

    /// Where a row of samples begins.
    #[inline(always)]
    pub(super) fn row(j: usize, k: usize) -> usize {
        (k * SIDES[1] + j) * SIDES[0]
    }

    /// All samples, row by row.
    #[inline(always)]
    pub(super) fn values(&self) -> &[f32; ROOM] {
        &self.values
    }

    /// All samples, and where those of corner `corner` of the cells of row (j, k) begin.
    #[inline(always)]
    pub fn corners(&self, j: usize, k: usize, corner: usize) -> (&[f32], usize) {
        (&self.values, Self::row(j + (corner >> 1 & 1), k + (corner >> 2)) + (corner & 1))
    }
}

/// 1 if it is not finite. As an integer: many are looked at together, where a sum of floats would have an order.
#[inline(always)]
fn is_wild(value: f32) -> u32 {
    const EXPONENT: u32 = 0x7f80_0000;
    u32::from(value.to_bits() & EXPONENT == EXPONENT)
}
