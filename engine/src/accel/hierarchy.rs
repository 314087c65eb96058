//! The bounding volume hierarchies of `mobula-core` as a component of the stack.

use std::ops::Range;

use glam::Vec3;
use mobula_core::bvh::{Bvh, Quality};
use mobula_core::leaf::{Block, SphereBlock, TriangleBlock};
use mobula_core::simd::AnyToken;
use mobula_core::traverse::Paths;
use mobula_core::{AnyHitPacket, RayPacket};

use super::threads::Pool;
use crate::scene::Geometry;
use crate::stack::{AccelerationStructure, Context, NeedsRebuild};

/// What stops light, and what lets it through: shadow rays see the first only.
#[derive(Clone, Debug)]
pub(super) struct Hierarchy {
    opaque: Trees,
    clear: Trees,
    bounds: (Vec3, Vec3),
    /// The ids of triangles and of spheres.
    ids: [Range<u32>; 2],
    /// Those that the geometry left out when the trees were built.
    left_out: Vec<u32>,
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
    pub(super) fn new(
        geometry: &Geometry,
        casts_shadow: &(dyn Fn(u32) -> bool + Sync),
        quality: Quality,
        all: bool,
    ) -> Self {
        Self {
            opaque: Trees::new(geometry, quality, &|id| casts_shadow(geometry.material(id, &mut 0))),
            clear: Trees::new(geometry, quality, &|id| !casts_shadow(geometry.material(id, &mut 0))),
            bounds: geometry.bounds(),
            ids: [geometry.triangle_ids(), geometry.sphere_ids()],
            left_out: match geometry.report().left_out() {
                0 => Vec::new(),
                _ => (0..geometry.sphere_ids().end).filter(|&id| is_left_out(geometry, id)).collect(),
            },
            all,
        }
    }
}

/// What the tree of triangles knows of triangle `id`.
fn corners(geometry: &Geometry, id: u32) -> [[f32; 3]; 3] {
    geometry.triangle(id).map_or(TriangleBlock::NOWHERE, |corners| corners.map(|p| p.to_array()))
}

/// What the tree of spheres knows of sphere `id`.
fn ball(geometry: &Geometry, id: u32) -> [f32; 4] {
    geometry.sphere(id).map_or(SphereBlock::NOWHERE, |(center, radius)| center.extend(radius).to_array())
}

fn is_left_out(geometry: &Geometry, id: u32) -> bool {
    geometry.triangle(id).is_none() && geometry.sphere(id).is_none()
}

impl Trees {
    fn new(geometry: &Geometry, quality: Quality, keep: &(dyn Fn(u32) -> bool + Sync)) -> Self {
        // A NaN tells the builder to leave a primitive out. Nothing at all is cheaper than to leave out everything.
        let kept = |ids: Range<u32>| if ids.clone().any(keep) { ids } else { ids.start..ids.start };
        let (triangles, spheres) = (kept(geometry.triangle_ids()), kept(geometry.sphere_ids()));
        let corners = |i: usize| {
            let id = triangles.start + i as u32;
            if keep(id) { corners(geometry, id) } else { TriangleBlock::NOWHERE }
        };
        let ball = |i: usize| {
            let id = spheres.start + i as u32;
            if keep(id) { ball(geometry, id) } else { SphereBlock::NOWHERE }
        };
        Pool::enter(|| Self {
            triangles: Bvh::build(triangles.len(), triangles.start, quality, &Pool, corners),
            spheres: Bvh::build(spheres.len(), spheres.start, quality, &Pool, ball),
        })
    }

    fn refit(&mut self, geometry: &Geometry) {
        let (triangles, spheres) = (geometry.triangle_ids().start, geometry.sphere_ids().start);
        Pool::enter(|| {
            self.triangles.refit(&Pool, |i| corners(geometry, triangles + i as u32));
            self.spheres.refit(&Pool, |i| ball(geometry, spheres + i as u32));
        });
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

    fn refit(&mut self, geometry: &Geometry) -> Result<(), NeedsRebuild> {
        let same_ids = self.ids == [geometry.triangle_ids(), geometry.sphere_ids()];
        if !same_ids || !self.left_out.iter().all(|&id| is_left_out(geometry, id)) {
            return Err(NeedsRebuild);
        }
        self.opaque.refit(geometry);
        self.clear.refit(geometry);
        self.bounds = geometry.bounds();
        Ok(())
    }

    fn bounds(&self) -> (Vec3, Vec3) {
        self.bounds
    }
}
