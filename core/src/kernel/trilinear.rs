//! A field between its samples: interpolated along x, then y, then z, in the cells of a brick.
//!
//! A brick holds the eight corners of each cell next to each other. So a lane reads its cell at once, wherever those of the other lanes
//! are, and the corners of all lanes are transposed in registers ([`Token::gather_rows`]).
//!
//! - NaN: a point that is NaN is in the first cell, with weights that are NaN; a sample that is NaN spoils its cells only.
//! - A point outside the brick is the caller's to prevent: it gives the value of any cell, extrapolated.

use mobula_simd::{F32Lanes, I32Lanes, Token};

/// Cells of a brick along each axis: powers of two.
pub const CELLS: [usize; 3] = [8, 4, 4];
/// Samples of a brick along each axis: those on the far faces too, which neighbours share.
pub const SAMPLES: [usize; 3] = [CELLS[0] + 1, CELLS[1] + 1, CELLS[2] + 1];
const ALL: usize = CELLS[0] * CELLS[1] * CELLS[2];

/// One number for each sample of a brick, kept for each of its cells: the corners of a cell are a row, x, y, z are bits 0, 1, 2 of the
/// place in it.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub struct Samples([[f32; 8]; ALL]);

impl Samples {
    /// Zeros.
    pub const ZERO: Self = Self([[0.0; 8]; ALL]);

    /// The number of sample (i, j, k).
    ///
    /// # Panics
    /// If there is no such sample.
    pub fn at(&self, at: [usize; 3]) -> f32 {
        let cell = [0, 1, 2].map(|axis| at[axis].min(CELLS[axis] - 1));
        let corner = (0..3).map(|axis| (at[axis] - cell[axis]) << axis).sum::<usize>();
        self.0[(cell[2] * CELLS[1] + cell[1]) * CELLS[0] + cell[0]][corner]
    }

    /// Writes row (j, k) of the samples to the cells that have it.
    #[inline(always)]
    pub fn set_row(&mut self, j: usize, k: usize, row: &[f32; SAMPLES[0]]) {
        for corner in 0..4 {
            // The row of cells of which this is that corner.
            let (Some(j), Some(k)) = (j.checked_sub(corner & 1), k.checked_sub(corner >> 1)) else { continue };
            if j < CELLS[1] && k < CELLS[2] {
                let cells = &mut self.0[(k * CELLS[1] + j) * CELLS[0]..][..CELLS[0]];
                for i in 0..CELLS[0] {
                    (cells[i][2 * corner], cells[i][2 * corner + 1]) = (row[i], row[i + 1]);
                }
            }
        }
    }
}

/// Where points are among the samples of a brick, a lane each.
#[derive(Clone, Copy, Debug)]
pub struct Place<T: Token> {
    /// The number of the cell.
    cell: T::I32,
    /// How far into the cell, from 0 to 1.
    part: [T::F32; 3],
}

impl<T: Token> Place<T> {
    /// Of points in units of cells, from 0 to [`CELLS`].
    #[inline(always)]
    pub fn new(token: T, point: [T::F32; 3]) -> Self {
        let (i, x) = cell::<T>(point[0], token.splat((CELLS[0] - 1) as f32));
        let (j, y) = cell::<T>(point[1], token.splat((CELLS[1] - 1) as f32));
        let (k, z) = cell::<T>(point[2], token.splat((CELLS[2] - 1) as f32));
        let row = k.shl(CELLS[1].ilog2()) + j;
        Self { cell: row.shl(CELLS[0].ilog2()) + i, part: [x, y, z] }
    }

    /// The value at each point.
    #[inline(always)]
    pub fn value(&self, token: T, samples: &Samples) -> T::F32 {
        let corners = token.gather_rows(&samples.0, self.cell);
        let [x, y, z] = self.part;
        let (a, b) = (mix(corners[0], corners[1], x), mix(corners[2], corners[3], x));
        let (c, d) = (mix(corners[4], corners[5], x), mix(corners[6], corners[7], x));
        mix(mix(a, b, y), mix(c, d, y), z)
    }

    /// The value of the sample that is nearest to each point.
    #[inline(always)]
    pub fn nearest(&self, token: T, samples: &Samples) -> T::F32 {
        let corners = token.gather_rows(&samples.0, self.cell);
        let half = token.splat(0.5);
        let [x, y, z] = [self.part[0].ge(half), self.part[1].ge(half), self.part[2].ge(half)];
        let (a, b) = (corners[1].select(x, corners[0]), corners[3].select(x, corners[2]));
        let (c, d) = (corners[5].select(x, corners[4]), corners[7].select(x, corners[6]));
        d.select(y, c).select(z, b.select(y, a))
    }
}

/// The cell of a coordinate, and how far into it.
#[inline(always)]
fn cell<T: Token>(x: T::F32, last: T::F32) -> (T::I32, T::F32) {
    let cell = x.min(last).to_i32();
    (cell, x - cell.to_f32())
}

#[inline(always)]
fn mix<F: F32Lanes>(a: F, b: F, part: F) -> F {
    part.mul_add(b - a, a)
}
