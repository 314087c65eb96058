//! What a leaf holds: four primitives of one kind as a structure of arrays, and how rays meet them.

use mobula_simd::{F32Lanes, Token};

use super::Bounds;
use crate::traverse::SingleRay;
use crate::{Column, Rays};

/// Primitives in a block.
pub const BLOCK: usize = 4;

/// Four primitives of one kind. Unused places have the id [`NO_HIT`](crate::NO_HIT) and come last.
pub trait Block: Copy + Send + Sync + 'static {
    /// One primitive, as it is given.
    type Primitive: Copy;
    /// Four unused places.
    const EMPTY: Self;
    /// What no ray hits.
    const NOWHERE: Self::Primitive;
    /// Four primitives with all that is the same for every ray of a packet worked out.
    type Prepared: Copy;

    /// The bounds of a primitive; `None` if it is not finite or degenerate, and so left out.
    fn bounds(primitive: &Self::Primitive) -> Option<Bounds>;

    /// Puts a primitive at a place.
    fn set(&mut self, place: usize, id: u32, primitive: &Self::Primitive);

    /// Scene-wide primitive ids.
    fn ids(&self) -> &[u32; BLOCK];

    /// Prepares the block for a packet: with a `COMMON_ORIGIN` relative to it.
    fn prepare<const N: usize, const COMMON_ORIGIN: bool>(&self, rays: &Rays<N>) -> Self::Prepared;

    /// Which primitives may be hit by rays of which groups, for rays with a common origin and the dominant axis `axis`: bit
    /// `4 * group + i`. Never leaves out a hit; bits of unused places do not matter.
    fn touches<T: Token>(_token: T, _prepared: &Self::Prepared, _axis: usize, _spread: &Spread, _groups: u32) -> u64 {
        u64::MAX
    }

    /// Tests primitive `i` of a prepared block against the rays from `at`: which lanes hit within their intervals, and
    /// where. All directions have the dominant axis `axis`, unless the rays have their `OWN_AXES`.
    fn test<T: Token, const N: usize, const COMMON_ORIGIN: bool, const OWN_AXES: bool>(
        token: T,
        prepared: &Self::Prepared,
        i: usize,
        axis: usize,
        rays: &Rays<N>,
        at: usize,
    ) -> (T::Mask, T::F32);

    /// Tests all four against one ray: lane i is primitive i. With one lane, `i` is which; otherwise it is 0.
    fn test_single<T: Token>(&self, token: T, ray: &SingleRay<T>, i: usize) -> (T::Mask, T::F32);
}

/// The slopes (see [`Rays::shears`]) of the rays of each group, a group a lane, from the middle of all.
#[derive(Clone, Copy, Debug)]
pub struct Spread {
    /// The middle of all slopes, x and y.
    pub center: [f32; 2],
    /// The farthest that any slope is from it.
    pub reach: f32,
    /// The middle of each group's, less that of all.
    pub middle: [Column<f32, 16>; 2],
    /// How far from it any ray of the group may be.
    pub radius: [Column<f32, 16>; 2],
}

impl Default for Spread {
    fn default() -> Self {
        Self { center: [0.0; 2], reach: 0.0, middle: [Column::splat(0.0); 2], radius: [Column::splat(0.0); 2] }
    }
}

/// More than rounding takes from the middle and the radius of slopes, which are at most 1 in size.
const ROUNDING: f32 = 4.0 * f32::EPSILON;

impl Spread {
    /// Sets the least and the greatest slopes of all rays.
    #[inline(always)]
    pub(crate) fn center(&mut self, least: [f32; 2], greatest: [f32; 2]) {
        self.reach = 0.0;
        for k in 0..2 {
            self.center[k] = 0.5 * (least[k] + greatest[k]);
            let reach = 0.5 * (greatest[k] - least[k]) + ROUNDING;
            self.reach = if reach > self.reach { reach } else { self.reach };
        }
    }

    /// Sets the least and the greatest slopes of the groups from `at`, after those of all.
    #[inline(always)]
    pub(crate) fn set<T: Token>(&mut self, token: T, at: usize, [least, greatest]: [[T::F32; 2]; 2]) {
        let half = token.splat(0.5);
        for k in 0..2 {
            let middle = (least[k] + greatest[k]).mul_sub(half, token.splat(self.center[k]));
            middle.store(&mut self.middle[k][..], at);
            let radius = (greatest[k] - least[k]).mul_add(half, token.splat(ROUNDING));
            radius.store(&mut self.radius[k][..], at);
        }
    }
}
