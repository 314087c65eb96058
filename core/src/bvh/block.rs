//! What a leaf holds: four primitives of one kind as a structure of arrays, and how rays meet them.

use bytemuck::Zeroable;
use mobula_simd::Token;

use super::Bounds;
use crate::Rays;
use crate::kernel::groups::Groups;
use crate::traverse::SingleRay;

/// Primitives in a block.
pub const BLOCK: usize = 4;

/// Four primitives of one kind. Unused places have the id [`NO_HIT`](crate::NO_HIT) and come last. Zeros are what a builder's
/// memory starts as.
pub trait Block: Copy + Send + Sync + Zeroable + 'static {
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

    /// The bounds of all its primitives; unused places have none.
    fn whole(&self) -> Bounds;

    /// Scene-wide primitive ids.
    fn ids(&self) -> &[u32; BLOCK];

    /// Prepares the block for a packet: with a `COMMON_ORIGIN` relative to it.
    fn prepare<const N: usize, const COMMON_ORIGIN: bool>(&self, rays: &Rays<N>) -> Self::Prepared;

    /// By which groups each primitive may be hit, for rays with a common origin or direction and the dominant axis `axis`, a bit a
    /// group. Never leaves out a hit; unused places do not matter.
    fn touched<T: Token, const N: usize>(
        _token: T,
        _prepared: &Self::Prepared,
        _axis: usize,
        _groups: &Groups,
    ) -> [u32; BLOCK] {
        [u32::MAX; BLOCK]
    }

    /// Tests primitive `i` of a prepared block against the rays from `at` in the lanes `among`: which hit within their intervals,
    /// and where. All directions have the dominant axis `axis`, unless the rays have their `OWN_AXES`.
    fn test<T: Token, const N: usize, const COMMON_ORIGIN: bool, const OWN_AXES: bool>(
        token: T,
        prepared: &Self::Prepared,
        i: usize,
        axis: usize,
        rays: &Rays<N>,
        at: usize,
        among: T::Mask,
    ) -> (T::Mask, T::F32);

    /// Tests all four against one ray: lane i is primitive i. With one lane, `i` is which; otherwise it is 0.
    fn test_single<T: Token>(&self, token: T, ray: &SingleRay<T>, i: usize) -> (T::Mask, T::F32);
}
