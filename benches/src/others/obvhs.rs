//! `obvhs`: a compressed tree of eight children a node, built by its slow preset, triangles in the tree's order.

use std::time::Duration;

use glam::Vec3A;
use obvhs::BvhBuildParams;
use obvhs::cwbvh::{CwBvh, builder::build_cwbvh_from_tris};
use obvhs::ray::{Ray, RayHit};
use obvhs::rt_triangle::RtTriangle;
use obvhs::triangle::Triangle;

use super::{Other, store};
use crate::rays::{Found, Kind, RaySet};
use crate::scenes::Triangles;

pub(super) struct Obvhs {
    tree: CwBvh,
    triangles: Vec<RtTriangle>,
}

impl Obvhs {
    pub(super) fn new(triangles: &Triangles) -> Self {
        let corners = |i| triangles.corners(i).map(Vec3A::from);
        let given = (0..triangles.indices.len()).map(corners).map(|[v0, v1, v2]| Triangle { v0, v1, v2 });
        let given: Vec<Triangle> = given.collect();
        let tree = build_cwbvh_from_tris(&given, BvhBuildParams::slow_build(), &mut Duration::default());
        let triangles = tree.primitive_indices.iter().map(|&i| (&given[i as usize]).into()).collect();
        Self { tree, triangles }
    }
}

impl Other for Obvhs {
    fn name(&self) -> &'static str {
        "obvhs 0.4 (CwBvh)"
    }

    fn trace(&self, kind: Kind, rays: &RaySet, found: &mut Found) {
        for i in 0..rays.len() {
            let ((origin, direction), t_max) = (rays.ray(i), rays.t_max[i]);
            let ray = Ray::new(origin.into(), direction.into(), 0.0, t_max);
            let test = |ray: &Ray, at: usize| self.triangles[at].intersect(ray);
            let hit = if kind.any_hit() {
                (!self.tree.ray_traverse_miss(ray, test)).then_some((0, 0.0))
            } else {
                let mut hit = RayHit::none();
                let found = self.tree.ray_traverse(ray, &mut hit, test);
                found.then(|| (self.tree.primitive_indices[hit.primitive_id as usize], hit.t))
            };
            store(kind, found, i, t_max, hit);
        }
    }
}
