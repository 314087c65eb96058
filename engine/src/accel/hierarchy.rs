//! The bounding volume hierarchies of `mobula-core` as a component of the stack.

use std::ops::Range;

use glam::Vec3;
use mobula_core::bvh::{Bvh, SphereBlock, TriangleBlock};
use mobula_core::simd::AnyToken;
use mobula_core::traverse::Paths;
use mobula_core::{AnyHitPacket, RayPacket};

use super::threads::Threads;
use crate::scene::Geometry;
use crate::stack::{AccelerationStructure, Context};

/// What stops light, and what lets it through: shadow rays see the first only.
#[derive(Clone, Debug)]
pub(super) struct Hierarchy {
    opaque: Trees,
    clear: Trees,
    bounds: (Vec3, Vec3),
    /// Is every primitive tried, without the trees?
    all: bool,
}

/// Triangles and spheres, each in a tree, searched one after the other.
#[derive(Clone, Debug)]
struct Trees {
    triangles: Bvh<TriangleBlock>,
    spheres: Bvh<SphereBlock>,
}

impl Hierarchy {
    pub(super) fn new(geometry: &Geometry, casts_shadow: &(dyn Fn(u32) -> bool + Sync), all: bool) -> Self {
        Self {
            opaque: Trees::new(geometry, &|id| casts_shadow(geometry.material(id, &mut 0))),
            clear: Trees::new(geometry, &|id| !casts_shadow(geometry.material(id, &mut 0))),
            bounds: geometry.bounds(),
            all,
        }
    }
}

impl Trees {
    fn new(geometry: &Geometry, keep: &(dyn Fn(u32) -> bool + Sync)) -> Self {
        let threads = Threads::available();
        // A NaN tells the builder to leave a primitive out. Nothing at all is cheaper than to leave out everything.
        let kept = |ids: Range<u32>| if ids.clone().any(keep) { ids } else { ids.start..ids.start };
        let (triangles, spheres) = (kept(geometry.triangle_ids()), kept(geometry.sphere_ids()));
        let corners = |i: usize| {
            let id = triangles.start + i as u32;
            let corners = geometry.triangle(id).filter(|_| keep(id));
            corners.map_or([[f32::NAN; 3]; 3], |corners| corners.map(|p| p.to_array()))
        };
        let ball = |i: usize| {
            let id = spheres.start + i as u32;
            let sphere = geometry.sphere(id).filter(|_| keep(id));
            sphere.map_or([f32::NAN; 4], |(center, radius)| center.extend(radius).to_array())
        };
        Self {
            triangles: Bvh::triangles(triangles.len(), triangles.start, &threads, corners),
            spheres: Bvh::spheres(spheres.len(), spheres.start, &threads, ball),
        }
    }

    fn intersect<const N: usize>(&self, token: AnyToken, all: bool, packet: &mut RayPacket<N>) -> Paths {
        let Self { triangles, spheres } = self;
        let mut paths = Paths::default();
        if triangles.primitives() > 0 {
            paths += if all { triangles.intersect_all(token, packet) } else { triangles.intersect(token, packet) };
        }
        if spheres.primitives() > 0 {
            paths += if all { spheres.intersect_all(token, packet) } else { spheres.intersect(token, packet) };
        }
        paths
    }

    fn occlude<const N: usize>(&self, token: AnyToken, all: bool, packet: &mut AnyHitPacket<N>) -> Paths {
        let Self { triangles, spheres } = self;
        let mut paths = Paths::default();
        if triangles.primitives() > 0 {
            paths += if all { triangles.occlude_all(token, packet) } else { triangles.occlude(token, packet) };
        }
        if spheres.primitives() > 0 {
            paths += if all { spheres.occlude_all(token, packet) } else { spheres.occlude(token, packet) };
        }
        paths
    }
}

impl<const N: usize> AccelerationStructure<N> for Hierarchy {
    fn intersect(&self, context: &Context<'_, N>, packet: &mut RayPacket<N>) {
        for trees in [&self.opaque, &self.clear] {
            context.statistics.count_paths(trees.intersect(context.token, self.all, packet));
        }
    }

    fn occlude(&self, context: &Context<'_, N>, packet: &mut AnyHitPacket<N>) {
        context.statistics.count_paths(self.opaque.occlude(context.token, self.all, packet));
    }

    fn bounds(&self) -> (Vec3, Vec3) {
        self.bounds
    }
}
