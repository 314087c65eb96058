//! The rays of a packet in groups of neighbours, and what is the same for all rays of a group.

use mobula_simd::{F32Lanes, Token};

use super::edges::Window;
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

/// Where groups of rays go that have an origin or a direction in common. From an origin they differ in their shears; parallel
/// rays in their bases, which are x and y where they pass a plane of equal depth.
#[derive(Clone, Copy, Debug)]
pub struct Groups {
    /// Around the shears or bases of all of them.
    pub window: Window,
    /// The middle of the window less that of each group, x and y.
    pub turned: [Row; 2],
    /// How far from it any ray of the group may be.
    pub radius: [Row; 2],
    /// Of parallel rays.
    pub parallel: Option<Parallel>,
}

/// What parallel rays have in common.
#[derive(Clone, Copy, Debug)]
pub struct Parallel {
    /// Their shears, x and y.
    pub shear: [f32; 2],
    /// The depth at which bases are taken.
    pub start: f32,
    /// The greatest coordinate of an origin or a primitive.
    pub scale: f32,
}

impl Default for Groups {
    fn default() -> Self {
        let zero = [Column::splat(0.0); 2];
        Self { window: Window { center: [0.0; 2], radius: 0.0 }, turned: zero, radius: zero, parallel: None }
    }
}

/// More than rounding takes from the middle and the radius of shears, which are at most 1 in size.
const ROUNDING: f32 = 4.0 * f32::EPSILON;

impl Groups {
    /// Of the least and the greatest shears or bases of each of some groups, by x and y, and of all together.
    #[inline(always)]
    pub(crate) fn new<T: Token>(
        token: T,
        ends: &[[Row; 2]; 2],
        all: [[f32; 2]; 2],
        groups: usize,
        parallel: Option<Parallel>,
    ) -> Self {
        let mut window = Window::new([all[0][0], all[1][0]], [all[0][1], all[1][1]]);
        window.radius += ROUNDING;
        let mut of = Self { window, parallel, ..Self::default() };
        let half = token.splat(0.5);
        let mut at = 0;
        while at < groups {
            for k in 0..2 {
                let (least, greatest) = (token.load(&ends[0][k][..], at), token.load(&ends[1][k][..], at));
                let turned = (least + greatest).neg_mul_add(half, token.splat(window.center[k]));
                turned.store(&mut of.turned[k][..], at);
                let radius = (greatest - least).mul_add(half, token.splat(ROUNDING));
                radius.store(&mut of.radius[k][..], at);
            }
            at += T::LANES;
        }
        of
    }
}

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
