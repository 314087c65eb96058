//! A field between its samples: interpolated along x, then y, then z, in the cells of a brick.
//!
//! Rays of a group are in few cells. So where vectors are wide, samples are not gathered, but looked up in registers: 4 x 4 samples of a
//! slice are one vector (a window of 3 x 3 cells), of which each lane takes its own ([`Token::lookup`]). Lanes in another window are
//! served after those, so what comes out does not depend on which lanes are together.
//!
//! - NaN: a point that is NaN is in the first cell, with weights that are NaN; a sample that is NaN spoils its cells only.
//! - A point outside the brick is the caller's to prevent: it gives the value of any cell, extrapolated.

use mobula_simd::{F32Lanes, I32Lanes, MaskLanes, Token};

/// Cells of a brick along each axis.
pub const CELLS: [usize; 3] = [8, 4, 4];
/// Samples of a brick along each axis: those on the far faces too, which neighbours share.
pub const SAMPLES: [usize; 3] = [CELLS[0] + 1, CELLS[1] + 1, CELLS[2] + 1];

/// Cells of a window along x; it has one sample more, and as many rows.
const WINDOW: usize = 3;
/// Windows along x, of which the last sample of one is the first of the next.
const WINDOWS: usize = CELLS[0].div_ceil(WINDOW);
const ROW: usize = WINDOW + 1;
const STRIP: usize = SAMPLES[1] * ROW;
const SLICE: usize = WINDOWS * STRIP;

/// One number for each sample of a brick, so that windows are contiguous: slices, strips of four samples along x, rows.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub struct Samples([f32; SLICE * SAMPLES[2] + 12]);

impl Samples {
    /// Zeros.
    pub const ZERO: Self = Self([0.0; SLICE * SAMPLES[2] + 12]);

    /// Writes row (j, k) of the samples.
    #[inline(always)]
    pub fn set_row(&mut self, j: usize, k: usize, row: &[f32; SAMPLES[0]]) {
        for window in 0..WINDOWS {
            let out = &mut self.0[k * SLICE + window * STRIP + j * ROW..][..ROW];
            for i in 0..ROW {
                out[i] = row[(window * WINDOW + i).min(SAMPLES[0] - 1)];
            }
        }
    }
}

/// Where points are among the samples of a brick, a lane each.
#[derive(Clone, Copy, Debug)]
pub struct Place<T: Token> {
    /// The first sample of the window that has the cell.
    strip: T::I32,
    /// Row of the cell, and place in that row.
    row: T::I32,
    column: T::I32,
    /// How far into the cell, from 0 to 1.
    part: [T::F32; 3],
    /// Which lanes count: the others are not looked up.
    active: T::Mask,
}

impl<T: Token> Place<T> {
    /// Of points in units of cells, from 0 to [`CELLS`].
    #[inline(always)]
    pub fn new(token: T, point: [T::F32; 3], active: T::Mask) -> Self {
        let (i, x) = cell::<T>(point[0], token.splat((CELLS[0] - 1) as f32));
        let (j, y) = cell::<T>(point[1], token.splat((CELLS[1] - 1) as f32));
        let (k, z) = cell::<T>(point[2], token.splat((CELLS[2] - 1) as f32));
        // A third, for numbers as small as these.
        let window = (i * token.splat_i32(11)).shr(5);
        let strip = (k * token.splat_i32(WINDOWS as i32) + window) * token.splat_i32(STRIP as i32);
        let column = i - window * token.splat_i32(WINDOW as i32);
        Self { strip, row: j, column, part: [x, y, z], active }
    }

    /// The values at the corners of the cells; x, y, z are bits 0, 1, 2 of the index.
    #[inline(always)]
    fn corners(&self, token: T, samples: &Samples) -> [T::F32; 8] {
        let mut out = [token.splat(0.0); 8];
        if T::LANES < 8 {
            let first = self.strip + self.row.shl(2) + self.column;
            for (corner, out) in out.iter_mut().enumerate() {
                *out = token.gather(&samples.0, first + token.splat_i32(offset(corner) as i32), self.active);
            }
            return out;
        }
        let (mut strips, mut left) = ([0; 16], self.active);
        self.strip.store(&mut strips, 0);
        while left.any() {
            let strip = strips[left.bits().trailing_zeros() as usize % 16];
            let here = left & self.strip.eq(token.splat_i32(strip as i32));
            // Of the four rows of cells, three are in a window: the first three, or the last three.
            let top = I32Lanes::eq(self.row, token.splat_i32(0)) & here;
            let start = usize::from(!top.any());
            let row = self.row - token.splat_i32(start as i32);
            let here = here & row.lt_unsigned(token.splat_i32(WINDOW as i32));
            let place = row.shl(2) + self.column;
            for slice in 0..2 {
                let first = strip as usize + start * ROW + slice * SLICE;
                let Some(window) = samples.0.get(first..).and_then(<[f32]>::first_chunk) else { return out };
                for corner in 0..4 {
                    let at = place + token.splat_i32(offset(corner) as i32);
                    out[4 * slice + corner] = token.lookup(window, at).select(here, out[4 * slice + corner]);
                }
            }
            left = left.and_not(here);
        }
        out
    }

    /// The value at each point.
    #[inline(always)]
    pub fn value(&self, token: T, samples: &Samples) -> T::F32 {
        let corners = self.corners(token, samples);
        let [x, y, z] = self.part;
        let (a, b) = (mix(corners[0], corners[1], x), mix(corners[2], corners[3], x));
        let (c, d) = (mix(corners[4], corners[5], x), mix(corners[6], corners[7], x));
        mix(mix(a, b, y), mix(c, d, y), z)
    }

    /// The value of the sample that is nearest to each point.
    #[inline(always)]
    pub fn nearest(&self, token: T, samples: &Samples) -> T::F32 {
        let corners = self.corners(token, samples);
        let half = token.splat(0.5);
        let [x, y, z] = [self.part[0].ge(half), self.part[1].ge(half), self.part[2].ge(half)];
        let (a, b) = (corners[1].select(x, corners[0]), corners[3].select(x, corners[2]));
        let (c, d) = (corners[5].select(x, corners[4]), corners[7].select(x, corners[6]));
        d.select(y, c).select(z, b.select(y, a))
    }
}

/// How far a corner is from the first one of its cell.
const fn offset(corner: usize) -> usize {
    (corner & 1) + (corner >> 1 & 1) * ROW + (corner >> 2) * SLICE
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
