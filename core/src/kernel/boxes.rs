//! Eight boxes as a structure of arrays: the children of a node, as the tests see them.

use mobula_simd::{F32Lanes, MaskLanes, Token};

/// `planes[0..3]`: low x, y, z of the boxes; `planes[3..6]`: high x, y, z.
pub type Planes = [[f32; 8]; 6];

/// A row of planes by its number.
#[inline(always)]
pub fn row(planes: &Planes, row: usize) -> &[f32; 8] {
    // A comparison that is always true costs less than `% 6`.
    planes.get(row).unwrap_or(&planes[0])
}

/// Three rows of planes, of the boxes from `at`.
#[inline(always)]
pub fn rows<T: Token>(token: T, planes: &Planes, rows: [usize; 3], at: usize) -> [T::F32; 3] {
    [token.load(row(planes, rows[0]), at), token.load(row(planes, rows[1]), at), token.load(row(planes, rows[2]), at)]
}

/// Which of the boxes overlap the box between `low` and `high`, a bit each. A NaN overlaps everything: nothing is known of that bound.
#[inline(always)]
pub fn overlapping<T: Token>(token: T, planes: &Planes, [low, high]: &[[f32; 3]; 2]) -> u32 {
    let token = token.narrow();
    let mut overlapping = 0;
    let mut at = 0;
    while at < 8 {
        let mut inside = token.mask(u32::MAX);
        for k in 0..3 {
            let (box_low, box_high) = (token.load(&planes[k], at), token.load(&planes[k + 3], at));
            inside = inside.and_not(box_low.gt(token.splat(high[k]))).and_not(box_high.lt(token.splat(low[k])));
        }
        overlapping |= inside.bits() << at;
        at += <T::Narrow as Token>::LANES;
    }
    overlapping
}
