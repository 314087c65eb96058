//! The bounding volume hierarchies of `mobula-core`, one for triangles and one for spheres, as a component of the stack.

use glam::Vec3;
use mobula_core::bvh::{Bvh, SphereBlock, TriangleBlock};
use mobula_core::{AnyHitPacket, RayPacket};

use super::threads::Threads;
use crate::scene::Geometry;
use crate::stack::{AccelerationStructure, Context};

/// Triangles and spheres, each in a tree, searched one after the other.
#[derive(Clone, Debug)]
pub(super) struct Hierarchy {
    triangles: Bvh<TriangleBlock>,
    spheres: Bvh<SphereBlock>,
    bounds: (Vec3, Vec3),
    /// Is every primitive tried, without the trees?
    all: bool,
}

impl Hierarchy {
    pub(super) fn new(geometry: &Geometry, all: bool) -> Self {
        let threads = Threads::available();
        let (triangles, spheres) = (geometry.triangle_ids(), geometry.sphere_ids());
        // A NaN tells the builder to leave a primitive out.
        let corners = |i: usize| {
            let corners = geometry.triangle(triangles.start + i as u32);
            corners.map_or([[f32::NAN; 3]; 3], |corners| corners.map(|p| p.to_array()))
        };
        let ball = |i: usize| {
            let sphere = geometry.sphere(spheres.start + i as u32);
            sphere.map_or([f32::NAN; 4], |(center, radius)| center.extend(radius).to_array())
        };
        Self {
            triangles: Bvh::triangles(triangles.len(), triangles.start, &threads, corners),
            spheres: Bvh::spheres(spheres.len(), spheres.start, &threads, ball),
            bounds: geometry.bounds(),
            all,
        }
    }
}

impl<const N: usize> AccelerationStructure<N> for Hierarchy {
    fn intersect(&self, context: &Context<'_, N>, packet: &mut RayPacket<N>) {
        let Self { triangles, spheres, all, .. } = self;
        if triangles.primitives() > 0 {
            let token = context.token;
            let paths = if *all { triangles.intersect_all(token, packet) } else { triangles.intersect(token, packet) };
            context.statistics.count_paths(paths);
        }
        if spheres.primitives() > 0 {
            let token = context.token;
            let paths = if *all { spheres.intersect_all(token, packet) } else { spheres.intersect(token, packet) };
            context.statistics.count_paths(paths);
        }
    }

    fn occlude(&self, context: &Context<'_, N>, packet: &mut AnyHitPacket<N>) {
        let Self { triangles, spheres, all, .. } = self;
        if triangles.primitives() > 0 {
            let token = context.token;
            let paths = if *all { triangles.occlude_all(token, packet) } else { triangles.occlude(token, packet) };
            context.statistics.count_paths(paths);
        }
        if spheres.primitives() > 0 {
            let token = context.token;
            let paths = if *all { spheres.occlude_all(token, packet) } else { spheres.occlude(token, packet) };
            context.statistics.count_paths(paths);
        }
    }

    fn bounds(&self) -> (Vec3, Vec3) {
        self.bounds
    }
}
