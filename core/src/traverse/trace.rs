//! Tracing packets and rays through a tree: the level is entered once.

use glam::Vec3;
use mobula_simd::{AnyToken, Dispatch, Scalar, Task, Token};

use super::packet;
use super::paths::Paths;
use super::roots::Roots;
use super::single::TraceSingle;
use super::stack::Entry;
use crate::bvh::{STACK, Tree, WideBvh};
use crate::kernel::single::{OneRay, padded_origin};
use crate::leaf::Leaf;
use crate::sink::{AnyHit, Found, Opacity, SingleHit, Sink};
use crate::{AnyHitPacket, Properties, RayPacket, Rays};

impl<L: Leaf> WideBvh<L> {
    /// Lowers `t_max` of each active ray to its nearest hit and sets the primitive's id there; on equal distance the
    /// lower id wins, also over a hit that was there before. Enters the level once.
    pub fn intersect<const N: usize>(&self, token: AnyToken, packet: &mut RayPacket<N>) -> Paths {
        closest(self, token, packet, Roots::Tree)
    }

    /// As [`intersect`](Self::intersect), testing every primitive against every ray: what traversal is checked against.
    pub fn intersect_all<const N: usize>(&self, token: impl Dispatch, packet: &mut RayPacket<N>) -> Paths {
        closest(self, token, packet, Roots::All)
    }

    /// Sets `t_max` of each active ray that hits anything to `-inf`. Enters the level once.
    pub fn occlude<const N: usize>(&self, token: AnyToken, packet: &mut AnyHitPacket<N>) -> Paths {
        any(self, token, packet, Roots::Tree, None)
    }

    /// As [`occlude`](Self::occlude), testing every primitive against every ray.
    pub fn occlude_all<const N: usize>(&self, token: AnyToken, packet: &mut AnyHitPacket<N>) -> Paths {
        any(self, token, packet, Roots::All, None)
    }

    /// As [`occlude`](Self::occlude), through primitives that let a part of the light through: adds to each ray's
    /// [`depth`](AnyHitPacket::depth) what it meets, and sets `t_max` to `-inf` where that is [`OPAQUE`](crate::sink::OPAQUE).
    pub fn occlude_through<const N: usize>(
        &self,
        token: AnyToken,
        packet: &mut AnyHitPacket<N>,
        opacity: &dyn Opacity,
    ) -> Paths {
        any(self, token, packet, Roots::Tree, Some(opacity))
    }

    /// As [`occlude_through`](Self::occlude_through), testing every primitive against every ray.
    pub fn occlude_through_all<const N: usize>(
        &self,
        token: AnyToken,
        packet: &mut AnyHitPacket<N>,
        opacity: &dyn Opacity,
    ) -> Paths {
        any(self, token, packet, Roots::All, Some(opacity))
    }

    /// The nearest hit of one ray in the interval `(t_min, t_max]`: distance and id, the same as [`intersect`](Self::intersect)
    /// finds.
    pub fn intersect_one(
        &self,
        token: AnyToken,
        origin: Vec3,
        direction: Vec3,
        interval: [f32; 2],
    ) -> Option<(f32, u32)> {
        let found = self.one::<false>(token, origin, direction, interval);
        found.hit.then_some((found.t_max, found.id))
    }

    /// Does one ray hit anything in the interval `(t_min, t_max]`?
    pub fn occluded_one(&self, token: AnyToken, origin: Vec3, direction: Vec3, interval: [f32; 2]) -> bool {
        self.one::<true>(token, origin, direction, interval).hit
    }

    fn one<const ANY: bool>(&self, token: AnyToken, origin: Vec3, direction: Vec3, [t_min, t_max]: [f32; 2]) -> Found {
        let mut rays = Rays::<1>::default();
        rays.reset(0..1, Properties::empty());
        rays.set_ray(0, origin, direction);
        rays.set_interval(0, t_min, t_max);
        // What is derived is rounded alike at every level.
        rays.shears(Scalar::new());
        rays.inverse_directions(Scalar::new());
        let ray = OneRay::of(&rays, 0, padded_origin(&rays, self.frame.origin(origin.to_array()), 0));
        let hit = SingleHit::of(t_max);
        let stack = &mut [Entry::NONE; STACK];
        token.run(TraceSingle::<Self, ANY> { tree: self, ray, hit, child: self.root, stack, base: 0 })
    }
}

/// As [`WideBvh::intersect`], in any tree.
pub fn intersect<B: Tree, const N: usize>(tree: &B, token: AnyToken, packet: &mut RayPacket<N>) -> Paths {
    closest(tree, token, packet, Roots::Tree)
}

/// As [`WideBvh::intersect_all`], in any tree.
pub fn intersect_all<B: Tree, const N: usize>(tree: &B, token: AnyToken, packet: &mut RayPacket<N>) -> Paths {
    closest(tree, token, packet, Roots::All)
}

/// As [`WideBvh::occlude`], or with an opacity as [`WideBvh::occlude_through`], in any tree.
pub fn occlude<B: Tree, const N: usize>(
    tree: &B,
    token: AnyToken,
    packet: &mut AnyHitPacket<N>,
    opacity: Option<&dyn Opacity>,
) -> Paths {
    any(tree, token, packet, Roots::Tree, opacity)
}

/// As [`WideBvh::occlude_all`], or with an opacity as [`WideBvh::occlude_through_all`], in any tree.
pub fn occlude_all<B: Tree, const N: usize>(
    tree: &B,
    token: AnyToken,
    packet: &mut AnyHitPacket<N>,
    opacity: Option<&dyn Opacity>,
) -> Paths {
    any(tree, token, packet, Roots::All, opacity)
}

fn closest<B: Tree, const N: usize>(tree: &B, token: impl Dispatch, packet: &mut RayPacket<N>, roots: Roots) -> Paths {
    packet.check();
    let (rays, sink) = packet.split();
    token.dispatch(Traverse { tree, rays, sink, roots })
}

fn any<B: Tree, const N: usize>(
    tree: &B,
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
    token.run(Traverse { tree, rays, sink, roots })
}

/// A walk at a level that is known already; if `all`, every leaf is tested without the tree.
#[cfg(all(feature = "lab", not(test)))]
#[inline(always)]
pub(crate) fn run<T: Token, const N: usize, B: Tree, S: Sink<N>>(
    token: T,
    tree: &B,
    rays: &mut Rays<N>,
    sink: &mut S,
    all: bool,
) {
    let roots = if all { Roots::All } else { Roots::Tree };
    token.run(Traverse { tree, rays, sink, roots });
}

struct Traverse<'a, const N: usize, B, S> {
    tree: &'a B,
    rays: &'a mut Rays<N>,
    sink: &'a mut S,
    roots: Roots,
}

impl<const N: usize, B: Tree, S: Sink<N>> Task for Traverse<'_, N, B, S> {
    type Output = Paths;

    #[inline(always)]
    fn run<T: Token>(self, token: T) -> Paths {
        packet::traverse(token, self.tree, self.rays, self.sink, self.roots)
    }
}
