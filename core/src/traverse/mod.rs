//! How rays find their primitives in a [`Bvh`].
//!
//! Two paths. Groups of up to 16 rays whose directions have constant signs travel together as a *packet*
//! ([`packet`]): a node's eight children are tested at once against the intervals of the packet's origins and
//! reciprocal directions. What is left goes ray by ray ([`single`]), one ray against eight boxes and four primitives.
//! The hits are the same bits on both.
//!
//! # Nothing is lost to rounding
//! The primitive tests decide; boxes only may not hide what they would accept. Let u = 2^-24 and s the greatest size of
//! a coordinate of the ray's origin or of the tree. The triangle test moves a corner by at most 4 u s when it subtracts
//! the origin and shears (one rounding for the difference, one for the shear factor's division, one for its reciprocal, one for the fused or
//! two for the unfused product and sum: each at most u times a relative coordinate of at most 2 s). The slab test errs by
//! three roundings, which move a plane by at most 3 u times its distance of at most 2 s. Together less than 16 u s =
//! 2^-20 s; so every box is widened by [`PAD`] s, at no cost: the origins that are subtracted are moved instead.

mod beams;
mod packet;
mod single;

use mobula_simd::{F32Lanes, I32Lanes, MaskLanes, Task, Token};

pub use single::SingleRay;

use crate::bvh::{Block, Bvh};
use crate::{AnyHitPacket, Hits, RayPacket, Rays};

/// Boxes are widened by this much of the greatest coordinate: see the [module](self).
pub const PAD: f32 = 1.0 / (1 << 20) as f32;

/// How many rays took which path: what `--stats` prints.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Paths {
    /// Rays that travelled in packets with a common origin.
    pub common_origin: u64,
    /// Rays that travelled in packets without one.
    pub general: u64,
    /// Rays that travelled alone.
    pub single: u64,
}

impl core::ops::AddAssign for Paths {
    fn add_assign(&mut self, other: Self) {
        self.common_origin += other.common_origin;
        self.general += other.general;
        self.single += other.single;
    }
}

impl<B: Block> Bvh<B> {
    /// Lowers `t_max` of each active ray to its nearest hit and sets the primitive's id there; on equal distance the
    /// lower id wins, also over a hit that was there before. Enters the level once.
    pub fn intersect<const N: usize>(&self, token: mobula_simd::AnyToken, packet: &mut RayPacket<N>) -> Paths {
        packet.check();
        let (rays, hits) = packet.split();
        token.run(Traverse { bvh: self, rays, target: hits, all: false })
    }

    /// As [`intersect`](Self::intersect), testing every primitive against every ray: what traversal is checked against.
    pub fn intersect_all<const N: usize>(&self, token: mobula_simd::AnyToken, packet: &mut RayPacket<N>) -> Paths {
        packet.check();
        let (rays, hits) = packet.split();
        token.run(Traverse { bvh: self, rays, target: hits, all: true })
    }

    /// Sets `t_max` of each active ray that hits anything to `-inf`. Enters the level once.
    pub fn occlude<const N: usize>(&self, token: mobula_simd::AnyToken, packet: &mut AnyHitPacket<N>) -> Paths {
        packet.check();
        token.run(Traverse { bvh: self, rays: packet, target: &mut AnyHit, all: false })
    }

    /// As [`occlude`](Self::occlude), testing every primitive against every ray.
    pub fn occlude_all<const N: usize>(&self, token: mobula_simd::AnyToken, packet: &mut AnyHitPacket<N>) -> Paths {
        packet.check();
        token.run(Traverse { bvh: self, rays: packet, target: &mut AnyHit, all: true })
    }
}

struct Traverse<'a, const N: usize, B, H> {
    bvh: &'a Bvh<B>,
    rays: &'a mut Rays<N>,
    target: &'a mut H,
    /// Without the tree?
    all: bool,
}

impl<const N: usize, B: Block, H: Target<N>> Task for Traverse<'_, N, B, H> {
    type Output = Paths;

    #[inline(always)]
    fn run<T: Token>(self, token: T) -> Paths {
        packet::traverse(token, self.bvh, self.rays, self.target, self.all)
    }
}

/// What becomes of hits: the nearest is kept, or the ray is done.
pub(crate) trait Target<const N: usize> {
    /// Is any hit enough?
    const ANY: bool;

    /// Takes the lanes `hit` of the rays from `at`; says whether anything changed.
    fn record<T: Token>(
        &mut self,
        token: T,
        rays: &mut Rays<N>,
        at: usize,
        hit: T::Mask,
        t: T::F32,
        id: u32,
    ) -> bool;

    /// The id of ray `i`'s hit so far.
    fn id(&self, i: usize) -> u32;

    /// Sets the hit of ray `i`.
    fn set(&mut self, rays: &mut Rays<N>, i: usize, t: f32, id: u32);
}

impl<const N: usize> Target<N> for Hits<N> {
    const ANY: bool = false;

    #[inline(always)]
    fn record<T: Token>(
        &mut self,
        token: T,
        rays: &mut Rays<N>,
        at: usize,
        hit: T::Mask,
        t: T::F32,
        id: u32,
    ) -> bool {
        let id = token.splat_i32(id as i32);
        let nearest = token.load(&rays.t_max[..], at);
        let lower = id.lt_unsigned(token.load_u32(&self.primitive[..], at));
        let better = hit & rays.active(token, at) & (t.lt(nearest) | (t.eq(nearest) & lower));
        t.store_masked(&mut rays.t_max[..], at, better);
        id.store_masked(&mut self.primitive[..], at, better);
        better.any()
    }

    #[inline(always)]
    fn id(&self, i: usize) -> u32 {
        self.primitive[i]
    }

    #[inline(always)]
    fn set(&mut self, rays: &mut Rays<N>, i: usize, t: f32, id: u32) {
        rays.t_max[i] = t;
        self.primitive[i] = id;
    }
}

/// The target of any-hit packets.
struct AnyHit;

impl<const N: usize> Target<N> for AnyHit {
    const ANY: bool = true;

    #[inline(always)]
    fn record<T: Token>(
        &mut self,
        token: T,
        rays: &mut Rays<N>,
        at: usize,
        hit: T::Mask,
        _t: T::F32,
        _id: u32,
    ) -> bool {
        let hit = hit & rays.active(token, at);
        token.splat(f32::NEG_INFINITY).store_masked(&mut rays.t_max[..], at, hit);
        hit.any()
    }

    #[inline(always)]
    fn id(&self, _i: usize) -> u32 {
        crate::NO_HIT
    }

    #[inline(always)]
    fn set(&mut self, rays: &mut Rays<N>, i: usize, _t: f32, _id: u32) {
        rays.t_max[i] = f32::NEG_INFINITY;
    }
}
