//! How rays find their primitives in a [`Bvh`]: packets in groups of 16 that have something in common, what is left
//! loosely or ray by ray. The hits are the same bits on all paths.
//!
//! # Nothing is lost to rounding
//! The primitive tests decide; boxes only may not hide what they would accept. Let u = 2^-24 and s the greatest size of
//! a coordinate of the ray's origin or of the tree, so that coordinates relative to the origin are at most 2 s, sheared
//! ones 4 s. The triangle test moves a corner sideways when it subtracts the origin (2 us, and as much through the
//! depth), rounds the shear factor (two roundings, 4 us), and shears (fused one rounding, 4 us; unfused two, 6 us): 14 us.
//! It accepts weights whose point is off the ray by [`OFF`](crate::kernel::triangle::OFF) of 4 s: 64 us. Weighing, dividing and
//! scaling the depth takes ten roundings of 2 us: 20 us. The slab test errs by three roundings, which move a plane by 6 us,
//! and moving the origin rounds once: 7 us. A beam, which is tested in place of a slab, rounds its base (7 us), moves it by
//! the margin (3 us), and rounds the plane's depth, product and sum (8 us): 18 us; where a group starts rounds once more (2 us). Together 118 us < 2^-17 s; so every box is
//! widened by [`PAD`] s, at no cost: the origins that are subtracted are moved instead.

#![doc = include_str!("TRAVERSAL.md")]

mod beams;
mod loose;
mod packet;
mod single;
mod stack;

use mobula_simd::{Dispatch, F32Lanes, I32Lanes, MaskLanes, Task, Token, prefetch};

pub use single::SingleRay;

use crate::bvh::{Block, Bvh, Child};
use crate::{AnyHitPacket, Hits, Properties, RayPacket, Rays};

/// Boxes are widened by this much of the greatest coordinate: see the [module](self).
pub const PAD: f32 = 1.0 / (1 << 17) as f32;

/// How many rays took which path: what `--stats` prints.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Paths {
    /// Rays that travelled in packets with a common origin.
    pub common_origin: u64,
    /// Rays that travelled in packets without one.
    pub general: u64,
    /// Rays that had nothing in common with their neighbours, or hardly any.
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
        packet.forget(Properties::OF_HITS);
        let (rays, hits) = packet.split();
        token.run(Traverse { bvh: self, rays, target: hits, roots: Roots::tree(self) })
    }

    /// As [`intersect`](Self::intersect), testing every primitive against every ray: what traversal is checked against.
    pub fn intersect_all<const N: usize>(&self, token: impl Dispatch, packet: &mut RayPacket<N>) -> Paths {
        packet.check();
        packet.forget(Properties::OF_HITS);
        let (rays, hits) = packet.split();
        token.dispatch(Traverse { bvh: self, rays, target: hits, roots: Roots::all(self) })
    }

    /// Sets `t_max` of each active ray that hits anything to `-inf`. Enters the level once.
    pub fn occlude<const N: usize>(&self, token: mobula_simd::AnyToken, packet: &mut AnyHitPacket<N>) -> Paths {
        packet.check();
        token.run(Traverse { bvh: self, rays: packet, target: &mut AnyHit, roots: Roots::tree(self) })
    }

    /// As [`occlude`](Self::occlude), testing every primitive against every ray.
    pub fn occlude_all<const N: usize>(&self, token: mobula_simd::AnyToken, packet: &mut AnyHitPacket<N>) -> Paths {
        packet.check();
        token.run(Traverse { bvh: self, rays: packet, target: &mut AnyHit, roots: Roots::all(self) })
    }
}

impl<B: Block> Bvh<B> {
    /// Asks for what a child holds before it is visited.
    #[inline(always)]
    fn prefetch(&self, child: Child) {
        if child.is_leaf() {
            if let Some(block) = self.blocks.get(child.blocks().start) {
                prefetch(block);
            }
        } else if let Some(node) = self.nodes.get(child.index()) {
            prefetch(node);
        }
    }
}

/// Where walks start: at the tree's root, or at every block, as if there were no tree.
#[derive(Clone, Copy, Debug)]
struct Roots {
    root: Option<Child>,
    next: usize,
    end: usize,
}

impl Roots {
    fn tree<B: Block>(bvh: &Bvh<B>) -> Self {
        Self { root: Some(bvh.root), next: 0, end: 1 }
    }

    fn all<B: Block>(bvh: &Bvh<B>) -> Self {
        Self { root: None, next: 0, end: bvh.blocks.len() }
    }
}

impl Iterator for Roots {
    type Item = Child;

    #[inline(always)]
    fn next(&mut self) -> Option<Child> {
        let here = self.next;
        self.next += 1;
        (here < self.end).then(|| self.root.unwrap_or_else(|| Child::leaf(here, 1)))
    }
}

struct Traverse<'a, const N: usize, B, H> {
    bvh: &'a Bvh<B>,
    rays: &'a mut Rays<N>,
    target: &'a mut H,
    roots: Roots,
}

impl<const N: usize, B: Block, H: Target<N>> Task for Traverse<'_, N, B, H> {
    type Output = Paths;

    #[inline(always)]
    fn run<T: Token>(self, token: T) -> Paths {
        packet::traverse(token, self.bvh, self.rays, self.target, self.roots)
    }
}

/// What becomes of hits: the nearest is kept, or the ray is done.
pub(crate) trait Target<const N: usize> {
    /// Is any hit enough?
    const ANY: bool;

    /// Takes the lanes `hit` of the rays from `at`; says whether anything changed.
    fn record<T: Token>(&mut self, token: T, rays: &mut Rays<N>, at: usize, hit: T::Mask, t: T::F32, id: u32) -> bool;

    /// The id of ray `i`'s hit so far.
    fn id(&self, i: usize) -> u32;

    /// Sets the hit of ray `i`.
    fn set(&mut self, rays: &mut Rays<N>, i: usize, t: f32, id: u32);
}

impl<const N: usize> Target<N> for Hits<N> {
    const ANY: bool = false;

    #[inline(always)]
    fn record<T: Token>(&mut self, token: T, rays: &mut Rays<N>, at: usize, hit: T::Mask, t: T::F32, id: u32) -> bool {
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
