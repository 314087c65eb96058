//! What a leaf holds: four primitives of one kind as a structure of arrays, and how rays meet them.

use mobula_simd::Token;

use crate::Rays;
use crate::traverse::SingleRay;

/// Primitives in a block.
pub const BLOCK: usize = 4;

/// Four primitives of one kind. Unused places have the id [`NO_HIT`](crate::NO_HIT) and come last.
pub trait Block: Copy + Send + Sync + 'static {
    /// One primitive with all that is the same for every ray of a packet worked out.
    type Prepared<T: Token>: Copy;

    /// Scene-wide primitive ids.
    fn ids(&self) -> &[u32; BLOCK];

    /// Does this packet allow the hoisted path (`HOISTED` of the other methods)?
    fn can_hoist<const N: usize>(rays: &Rays<N>) -> bool;

    /// Derives in the packet what [`test`](Self::test) reads.
    fn derive<T: Token, const N: usize>(token: T, rays: &mut Rays<N>);

    /// Prepares primitive `i` for a packet.
    fn prepare<T: Token, const N: usize, const HOISTED: bool>(
        &self,
        token: T,
        i: usize,
        rays: &Rays<N>,
    ) -> Self::Prepared<T>;

    /// Tests a prepared primitive against the rays from `at`: which lanes hit within their intervals, and where.
    fn test<T: Token, const N: usize, const HOISTED: bool>(
        token: T,
        prepared: &Self::Prepared<T>,
        rays: &Rays<N>,
        at: usize,
    ) -> (T::Mask, T::F32);

    /// Tests all four against one ray: lane i is primitive i. With one lane, `i` is which; otherwise it is 0.
    fn test_single<T: Token>(&self, token: T, ray: &SingleRay<T>, i: usize) -> (T::Mask, T::F32);
}
