//! No structure: every ray tries every primitive, one by one. Slow, and dull enough to believe.
//!
//! Möller and Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", JGT 1997.

use glam::Vec3;
use mobula_core::{AnyHitPacket, RayPacket};

use crate::scene::Geometry;
use crate::stack::{AccelerationStructure, Context};

/// All primitives in a row.
#[derive(Debug)]
pub(super) struct Brute {
    triangles: Vec<(u32, [Vec3; 3])>,
    spheres: Vec<(u32, Vec3, f32)>,
    bounds: (Vec3, Vec3),
}

impl Brute {
    /// Copies all primitives that were not left out.
    pub(super) fn new(geometry: &Geometry) -> Self {
        Self {
            triangles: geometry.triangles().collect(),
            spheres: geometry.spheres().collect(),
            bounds: geometry.bounds(),
        }
    }

    /// Distance and id of every hit of a ray, in any order.
    fn hits(&self, origin: Vec3, direction: Vec3) -> impl Iterator<Item = (f32, u32)> + '_ {
        let triangles = self.triangles.iter().filter_map(move |&(id, c)| Some((triangle(c, origin, direction)?, id)));
        let spheres = self.spheres.iter().flat_map(move |&(id, center, radius)| {
            sphere(center, radius, origin, direction).into_iter().flatten().map(move |t| (t, id))
        });
        triangles.chain(spheres)
    }
}

impl<const N: usize> AccelerationStructure<N> for Brute {
    fn intersect(&self, _context: &Context<'_, N>, packet: &mut RayPacket<N>) {
        let (rays, hits) = packet.split();
        for i in rays.range() {
            let (origin, direction) = rays.ray(i);
            for (t, id) in self.hits(origin, direction) {
                let nearer = t < rays.t_max[i] || (t == rays.t_max[i] && id < hits.primitive[i]);
                if t > rays.t_min()[i] && nearer {
                    rays.t_max[i] = t;
                    hits.primitive[i] = id;
                }
            }
        }
    }

    fn occlude(&self, _context: &Context<'_, N>, packet: &mut AnyHitPacket<N>) {
        for i in packet.range() {
            let (origin, direction) = packet.ray(i);
            let (near, far) = (packet.t_min()[i], packet.t_max[i]);
            if self.hits(origin, direction).any(|(t, _)| t > near && t <= far) {
                packet.t_max[i] = f32::NEG_INFINITY;
            }
        }
    }

    fn bounds(&self) -> (Vec3, Vec3) {
        self.bounds
    }
}

fn triangle([a, b, c]: [Vec3; 3], origin: Vec3, direction: Vec3) -> Option<f32> {
    let (e1, e2) = (b - a, c - a);
    let p = direction.cross(e2);
    let determinant = e1.dot(p);
    let scale = 1.0 / determinant;
    let s = origin - a;
    let u = s.dot(p) * scale;
    let q = s.cross(e1);
    let v = direction.dot(q) * scale;
    // A NaN, also that of a zero determinant, fails.
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0).then(|| e2.dot(q) * scale)
}

fn sphere(center: Vec3, radius: f32, origin: Vec3, direction: Vec3) -> Option<[f32; 2]> {
    let [o, c, d] = [origin, center, direction].map(|v| v.to_array().map(f64::from));
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let s = [0, 1, 2].map(|i| o[i] - c[i]);
    let (a, b) = (dot(d, d), dot(d, s));
    let discriminant = b * b - a * (dot(s, s) - f64::from(radius) * f64::from(radius));
    let root = discriminant.sqrt();
    (discriminant >= 0.0 && a > 0.0).then(|| [(-b - root) / a, (-b + root) / a].map(|t| t as f32))
}
