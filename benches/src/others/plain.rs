//! `bvh`: a binary tree whose leaves are given out by the distance of their boxes; testing them is the caller's.

use bvh::aabb::{Aabb, Bounded};
use bvh::bounding_hierarchy::BHShape;
use bvh::bvh::Bvh;
use bvh::ray::Ray;
use nalgebra::Point3;

use super::{Other, store};
use crate::rays::{Found, Kind, RaySet};
use crate::scenes::Triangles;

struct Triangle {
    corners: [Point3<f32>; 3],
    id: u32,
    node: usize,
}

impl Bounded<f32, 3> for Triangle {
    fn aabb(&self) -> Aabb<f32, 3> {
        let [a, b, c] = &self.corners;
        Aabb::empty().grow(a).grow(b).grow(c)
    }
}

impl BHShape<f32, 3> for Triangle {
    fn set_bh_node_index(&mut self, node: usize) {
        self.node = node;
    }

    fn bh_node_index(&self) -> usize {
        self.node
    }
}

pub(super) struct Plain {
    tree: Bvh<f32, 3>,
    triangles: Vec<Triangle>,
}

impl Plain {
    pub(super) fn new(triangles: &Triangles) -> Self {
        let corners = |i| triangles.corners(i).map(Point3::from);
        let new = |i| Triangle { corners: corners(i), id: i as u32, node: 0 };
        let mut triangles: Vec<Triangle> = (0..triangles.indices.len()).map(new).collect();
        Self { tree: Bvh::build(&mut triangles), triangles }
    }
}

impl Other for Plain {
    fn name(&self) -> &'static str {
        "bvh 0.12"
    }

    fn trace(&self, kind: Kind, rays: &RaySet, found: &mut Found) {
        for i in 0..rays.len() {
            let ((origin, direction), t_max) = (rays.ray(i), rays.t_max[i]);
            let ray = Ray::new(origin.into(), direction.into());
            let (mut hit, mut nearest) = (None, t_max);
            for triangle in self.tree.nearest_traverse_iterator(&ray, &self.triangles) {
                // They come by the entries into their boxes.
                if ray.intersection_slice_for_aabb(&triangle.aabb()).is_some_and(|(entry, _)| entry > nearest) {
                    break;
                }
                // Its test sees one side only.
                let [a, b, c] = &triangle.corners;
                let t = ray.intersects_triangle(a, b, c).distance.min(ray.intersects_triangle(a, c, b).distance);
                if t < nearest {
                    (hit, nearest) = (Some((triangle.id, t)), t);
                    if kind.any_hit() {
                        break;
                    }
                }
            }
            store(kind, found, i, t_max, hit);
        }
    }
}
