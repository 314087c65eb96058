//! How rays find what they hit in a tree: packets in groups of 16 that have something in common, what is left as streams or
//! ray by ray. The hits are the same bits on all paths. Nothing is lost to rounding: see
//! [`kernel::margin`](crate::kernel::margin).

#![doc = include_str!("TRAVERSAL.md")]

mod packet;
mod single;
mod stack;
mod stream;

use mobula_simd::{AnyToken, Dispatch, Task, Token, prefetch};

use crate::bvh::{Child, WideBvh};
use crate::leaf::Leaf;
use crate::sink::{AnyHit, Opacity, Sink};
use crate::{AnyHitPacket, Properties, RayPacket, Rays};

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

impl<L: Leaf> WideBvh<L> {
    /// Lowers `t_max` of each active ray to its nearest hit and sets the primitive's id there; on equal distance the
    /// lower id wins, also over a hit that was there before. Enters the level once.
    pub fn intersect<const N: usize>(&self, token: AnyToken, packet: &mut RayPacket<N>) -> Paths {
        self.closest(token, packet, Roots::tree(self))
    }

    /// As [`intersect`](Self::intersect), testing every primitive against every ray: what traversal is checked against.
    pub fn intersect_all<const N: usize>(&self, token: impl Dispatch, packet: &mut RayPacket<N>) -> Paths {
        self.closest(token, packet, Roots::all(self))
    }

    fn closest<const N: usize>(&self, token: impl Dispatch, packet: &mut RayPacket<N>, roots: Roots) -> Paths {
        packet.check();
        packet.forget(Properties::OF_HITS);
        let (rays, sink) = packet.split();
        token.dispatch(Traverse { bvh: self, rays, sink, roots })
    }

    /// Sets `t_max` of each active ray that hits anything to `-inf`. Enters the level once.
    pub fn occlude<const N: usize>(&self, token: AnyToken, packet: &mut AnyHitPacket<N>) -> Paths {
        self.any(token, packet, Roots::tree(self), None)
    }

    /// As [`occlude`](Self::occlude), testing every primitive against every ray.
    pub fn occlude_all<const N: usize>(&self, token: AnyToken, packet: &mut AnyHitPacket<N>) -> Paths {
        self.any(token, packet, Roots::all(self), None)
    }

    /// As [`occlude`](Self::occlude), through primitives that let a part of the light through: adds to each ray's
    /// [`depth`](AnyHitPacket::depth) what it meets, and sets `t_max` to `-inf` where that is [`OPAQUE`](crate::sink::OPAQUE).
    pub fn occlude_through<const N: usize>(
        &self,
        token: AnyToken,
        packet: &mut AnyHitPacket<N>,
        opacity: &dyn Opacity,
    ) -> Paths {
        self.any(token, packet, Roots::tree(self), Some(opacity))
    }

    /// As [`occlude_through`](Self::occlude_through), testing every primitive against every ray.
    pub fn occlude_through_all<const N: usize>(
        &self,
        token: AnyToken,
        packet: &mut AnyHitPacket<N>,
        opacity: &dyn Opacity,
    ) -> Paths {
        self.any(token, packet, Roots::all(self), Some(opacity))
    }

    fn any<const N: usize>(
        &self,
        token: AnyToken,
        packet: &mut AnyHitPacket<N>,
        roots: Roots,
        opacity: Option<&dyn Opacity>,
    ) -> Paths {
        packet.check();
        let (rays, depth) = packet.split();
        let sink = &mut match opacity {
            Some(opacity) => AnyHit::transparent(opacity, &mut depth[..]),
            None => AnyHit::opaque(),
        };
        token.run(Traverse { bvh: self, rays, sink, roots })
    }

    /// Asks for what a child holds before it is visited.
    #[inline(always)]
    fn prefetch(&self, child: Child) {
        if child.is_leaf() {
            self.leaves.prefetch(child.leaf_range());
        } else if let Some(node) = self.nodes.get(child.index()) {
            prefetch(node);
        }
    }
}

/// A walk in a region that was entered before; `ALL` leaves are tested without the tree.
#[cfg(feature = "lab")]
#[inline(always)]
pub(crate) fn run<T: Token, const N: usize, L: Leaf, S: Sink<N>, const ALL: bool>(
    token: T,
    bvh: &WideBvh<L>,
    rays: &mut Rays<N>,
    sink: &mut S,
) {
    let roots = if ALL { Roots::all(bvh) } else { Roots::tree(bvh) };
    packet::traverse(token, bvh, rays, sink, roots);
}

/// Where walks start: at the tree's root, or at every leaf, as if there were no tree.
#[derive(Clone, Copy, Debug)]
struct Roots {
    root: Option<Child>,
    next: usize,
    end: usize,
}

impl Roots {
    fn tree<L>(bvh: &WideBvh<L>) -> Self {
        Self { root: Some(bvh.root), next: 0, end: 1 }
    }

    fn all<L>(bvh: &WideBvh<L>) -> Self {
        Self { root: None, next: 0, end: bvh.leaf_count }
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

struct Traverse<'a, const N: usize, L, S> {
    bvh: &'a WideBvh<L>,
    rays: &'a mut Rays<N>,
    sink: &'a mut S,
    roots: Roots,
}

impl<const N: usize, L: Leaf, S: Sink<N>> Task for Traverse<'_, N, L, S> {
    type Output = Paths;

    #[inline(always)]
    fn run<T: Token>(self, token: T) -> Paths {
        packet::traverse(token, self.bvh, self.rays, self.sink, self.roots)
    }
}
