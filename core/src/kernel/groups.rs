//! The rays of a packet in groups of neighbours, and folds over a value of each group.

use mobula_simd::{F32Lanes, Token};

use crate::Column;

/// Groups in a packet, at most.
pub const GROUPS: usize = 16;

/// Rays in a group: 16, or as many as make 16 groups of a wider packet.
pub(crate) const fn group_size(width: usize) -> usize {
    if width <= 16 * GROUPS { 16 } else { width.div_ceil(GROUPS).next_multiple_of(16) }
}

/// Lanes that the groups of a packet take: 4 or 16.
pub(crate) const fn group_lanes(width: usize) -> usize {
    if width <= 4 * 16 { 4 } else { GROUPS }
}

/// A value of every group.
pub(crate) type Row = Column<f32, GROUPS>;

/// The greatest of the groups of a mask.
#[inline(always)]
pub(crate) fn greatest<T: Token, const N: usize>(token: T, row: &Row, groups: u32) -> f32 {
    let minus_inf = token.splat(f32::NEG_INFINITY);
    let mut greatest = minus_inf;
    let mut at = 0;
    while at < group_lanes(N) {
        greatest = token.load(&row[..], at).select(token.mask(groups >> at), minus_inf).max(greatest);
        at += T::LANES;
    }
    greatest.reduce_max()
}

/// The least of the groups of a mask.
#[inline(always)]
pub(crate) fn least<T: Token, const N: usize>(token: T, row: &Row, groups: u32) -> f32 {
    let inf = token.splat(f32::INFINITY);
    let mut least = inf;
    let mut at = 0;
    while at < group_lanes(N) {
        least = token.load(&row[..], at).select(token.mask(groups >> at), inf).min(least);
        at += T::LANES;
    }
    least.reduce_min()
}
