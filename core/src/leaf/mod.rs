//! What is in a leaf: how packets, streams and single rays meet the primitives there. Trees know nodes only; walks over them
//! call this.
//!
//! [`Leaf`] is what a walk needs. Primitives that are stored as [`Block`]s of four have it for free: implement [`Block`], and
//! a [`Bvh`](crate::Bvh) builds over them.

mod block;
mod bounds;
mod sphere_block;
mod triangle_block;

use core::ops::Range;

use mobula_simd::Token;

pub use block::{BLOCK, Block, Blocks};
pub use bounds::Bounds;
pub(crate) use bounds::{FOUR, Four};
pub use sphere_block::{OwnIds, Places, SphereBlock, SphereIds};
pub use triangle_block::TriangleBlock;

use crate::Rays;
use crate::kernel::few::FewRays;
use crate::kernel::frusta::Frusta;
use crate::sink::{SingleHit, Sink};

/// The leaves of a tree. A leaf is a range of what they are stored as.
///
/// All tests must accept the same hits, at the same distances, bit for bit, and lose no hit that lies in the bounds that the
/// tree was built with, widened by the [margin](crate::kernel::margin). A range that is not there holds nothing.
pub trait Leaf: Send + Sync {
    /// Is there a test of a few rays together, [`few`](Self::few)?
    const TESTS_FEW: bool = false;

    /// Tests a leaf against the rays of `groups`, which travel together; `COMMON_ORIGIN` says that all start at one point.
    /// Returns the groups whose intervals changed.
    fn packet<T: Token, const N: usize, const COMMON_ORIGIN: bool, S: Sink<N>>(
        &self,
        token: T,
        leaf: Range<usize>,
        frusta: &Frusta,
        rays: &mut Rays<N>,
        sink: &mut S,
        groups: u32,
    ) -> u32;

    /// Tests a leaf against the rays `active`, which have nothing in common: bit i is ray `64 * word + i`.
    fn stream<T: Token, const N: usize, S: Sink<N>>(
        &self,
        token: T,
        leaf: Range<usize>,
        rays: &mut Rays<N>,
        sink: &mut S,
        word: usize,
        active: u64,
    );

    /// Tests a leaf against one ray, which looks for `ANY` hit or the closest. The token has at most eight lanes.
    fn single<T: Token, const ANY: bool>(
        &self,
        token: T,
        leaf: Range<usize>,
        ray: &mut FewRays<T>,
        hit: &mut SingleHit<'_>,
    );

    /// Tests a leaf against a few rays by their numbers, as many at once as [`FewRays`] has. `axis` is the dominant axis of all, if it
    /// is one. Or says `false`: there is no such test, and they are to be tested otherwise.
    #[inline(always)]
    fn few<T: Token, const N: usize, S: Sink<N>>(
        &self,
        _token: T,
        _leaf: Range<usize>,
        _rays: &mut Rays<N>,
        _sink: &mut S,
        _numbers: &[usize],
        _axis: Option<usize>,
    ) -> bool {
        false
    }

    /// Asks for the memory of a leaf before it is visited.
    fn prefetch(&self, leaf: Range<usize>);
}
