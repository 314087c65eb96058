//! The cells of a brick that a surface passes through, laid out so that each ray of a vector may be in another.

use mobula_simd::{F32Lanes, MaskLanes, Token};

use super::brick::{Brick, CELLS, SIDES};

/// Cells in a brick.
const COUNT: usize = CELLS[0] * CELLS[1] * CELLS[2];

/// Which cells a surface passes through, and the values at their corners. Cell (i, j, k) has the number i + 8 j + 32 k.
#[repr(align(64))]
pub(super) struct Cells {
    /// A bit each.
    pub(super) passed: [u32; 4],
    /// x, y, z are bits 0, 1, 2 of a corner's number. Of cells that are passed through only.
    corners: [[f32; 8]; COUNT],
}

impl Cells {
    /// No cells.
    pub(super) const NONE: Self = Self { passed: [0; 4], corners: [[0.0; 8]; COUNT] };

    /// Those of a brick with so many cells along each axis that the surface of a value passes through; says whether there are any.
    #[inline(always)]
    pub(super) fn fill<T: Token>(&mut self, token: T, brick: &Brick, cells: [usize; 3], value: f32) -> bool {
        self.passed = passed(token, brick, cells, value);
        let mut any = false;
        for k in 0..CELLS[2] {
            let mut left = self.passed[k];
            any |= left != 0;
            while left != 0 {
                let at = left.trailing_zeros() as usize % 32;
                left &= left - 1;
                let (i, j) = (at % CELLS[0], at / CELLS[0]);
                let (values, out) = (brick.values(), &mut self.corners[k * 32 + at]);
                for pair in 0..4 {
                    let from = Brick::row(j + pair % 2, k + pair / 2) + i;
                    if let Some(two) = values[from..].first_chunk::<2>() {
                        out[2 * pair..2 * pair + 2].copy_from_slice(two);
                    }
                }
            }
        }
        any
    }

    /// The values at the corners of a cell in each lane, less the iso value.
    #[inline(always)]
    pub(super) fn corners<T: Token>(&self, token: T, cell: T::I32, value: T::F32) -> [T::F32; 8] {
        let mut corners = token.gather_rows(&self.corners, cell);
        for corner in &mut corners {
            *corner = *corner - value;
        }
        corners
    }
}

/// Which cells have corners on both sides, and none that is NaN.
#[inline(always)]
fn passed<T: Token>(token: T, brick: &Brick, cells: [usize; 3], value: f32) -> [u32; 4] {
    let token = token.narrow();
    let (value, zero) = (token.splat(value), token.splat(0.0));
    let values = brick.values();
    let mut passed = [0; 4];
    let mut at = 0;
    while at < CELLS[0] {
        // Of the slice of samples before: the least and the greatest of four, and a sum that is NaN where one is.
        let mut before = [[zero; 3]; CELLS[1]];
        for k in 0..SIDES[2] {
            let mut row = [zero; 3];
            for j in 0..SIDES[1] {
                let start = Brick::row(j, k) + at;
                let (a, b) = (token.load(values, start), token.load(values, start + 1));
                let here = [a.min(b), a.max(b), if brick.finite { zero } else { a.mul_add(zero, b * zero) }];
                if j > 0 {
                    let four = [row[0].min(here[0]), row[1].max(here[1]), row[2] + here[2]];
                    let old = before[j - 1];
                    let mut inside = old[0].min(four[0]).lt(value) & value.le(old[1].max(four[1]));
                    if !brick.finite {
                        let sum = old[2] + four[2];
                        inside = inside & sum.eq(sum);
                    }
                    if k > 0 {
                        passed[k - 1] |= inside.bits() << (8 * (j - 1) + at);
                    }
                    before[j - 1] = four;
                }
                row = here;
            }
        }
        at += <T::Narrow as Token>::LANES;
    }
    let row = (1 << cells[0]) - 1;
    let slice = row * (0x0101_0101 & (u32::MAX >> (32 - 8 * cells[1])));
    for (k, passed) in passed.iter_mut().enumerate() {
        *passed &= if k < cells[2] { slice } else { 0 };
    }
    passed
}
