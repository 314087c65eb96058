//! The surface at a hit: normals, texture coordinates, derivatives, from the primitive's id and the ray (paper 5.1.4).
//!
//! Everything is computed for one ray at a time from that ray alone, in f32, unfused: the same at every packet width and
//! level.

use std::ops::Range;

use glam::Vec3;
use mobula_core::rays::set_vec3;
use mobula_core::{Columns3, Hits, Rays, Surface};

use super::geometry::normal_f64;
use super::{Geometry, Mesh, Shape, Spheres};
use crate::math::{normalize, normalize_or};

impl<const N: usize> Surface<N> for Geometry {
    /// Of triangles: towards the side from which the corners are counter-clockwise. Of spheres: outwards.
    fn geometric_normals(&self, rays: &Rays<N>, hits: &Hits<N>, range: Range<usize>, out: &mut Columns3<N>) {
        let mut near = 0;
        for i in range {
            let (shape, k) = self.primitive(hits.primitive[i], &mut near);
            let normal = match shape {
                Shape::Mesh(mesh) => mesh.corners(k).map_or(Vec3::Y, triangle_normal),
                Shape::Spheres(spheres) => sphere_normal(spheres, k, position(rays, i)),
            };
            set_vec3(out, i, normal);
        }
    }

    fn normals(&self, rays: &Rays<N>, hits: &Hits<N>, range: Range<usize>, out: &mut Columns3<N>) {
        let mut near = 0;
        for i in range {
            let (shape, k) = self.primitive(hits.primitive[i], &mut near);
            let normal = match shape {
                Shape::Mesh(mesh) => mesh.corners(k).map_or(Vec3::Y, |corners| {
                    corner_normals(mesh, k).map_or_else(
                        || triangle_normal(corners),
                        |[a, b, c]| {
                            let [u, v, w] = barycentric(corners, rays.ray(i));
                            let n = a * u + b * v + c * w;
                            let length_squared = n.dot(n);
                            if length_squared > 1e-12 && length_squared < 1e12 {
                                normalize(n)
                            } else {
                                triangle_normal(corners)
                            }
                        },
                    )
                }),
                Shape::Spheres(spheres) => sphere_normal(spheres, k, position(rays, i)),
            };
            set_vec3(out, i, normal);
        }
    }

    /// Of triangles: interpolated, zero where there are none. Of spheres: longitude and latitude, 0..1, around y.
    fn texture_coordinates(&self, rays: &Rays<N>, hits: &Hits<N>, range: Range<usize>, out: &mut Columns3<N>) {
        let mut near = 0;
        for i in range {
            let (shape, k) = self.primitive(hits.primitive[i], &mut near);
            let at = match shape {
                Shape::Mesh(mesh) => corner_texture_coordinates(mesh, k).map_or(Vec3::ZERO, |[a, b, c]| {
                    let corners = mesh.corners(k).unwrap_or_default();
                    let [u, v, w] = barycentric(corners, rays.ray(i));
                    a * u + b * v + c * w
                }),
                Shape::Spheres(spheres) => {
                    let n = sphere_normal(spheres, k, position(rays, i));
                    let longitude = libm::atan2f(n.z, n.x) * (0.5 * core::f32::consts::FRAC_1_PI) + 0.5;
                    let latitude = libm::asinf(n.y.clamp(-1.0, 1.0)) * core::f32::consts::FRAC_1_PI + 0.5;
                    Vec3::new(longitude, latitude, 0.0)
                }
            };
            set_vec3(out, i, at);
        }
    }

    /// Of triangles: along the texture coordinates, or along two edges where there are none. Of spheres: eastwards and
    /// northwards around y.
    fn derivatives(&self, rays: &Rays<N>, hits: &Hits<N>, range: Range<usize>, out: [&mut Columns3<N>; 2]) {
        let [out_u, out_v] = out;
        let mut near = 0;
        for i in range {
            let (shape, k) = self.primitive(hits.primitive[i], &mut near);
            let [du, dv] = match shape {
                Shape::Mesh(mesh) => triangle_derivatives(mesh, k),
                Shape::Spheres(spheres) => {
                    let (center, _) = spheres.sphere(k).unwrap_or_default();
                    let r = position(rays, i) - center;
                    let around = core::f32::consts::TAU;
                    let flat = (r.x * r.x + r.z * r.z).sqrt();
                    let north = if flat > 0.0 {
                        Vec3::new(-r.x * r.y / flat, flat, -r.z * r.y / flat)
                    } else {
                        Vec3::new(-r.y, 0.0, 0.0)
                    };
                    [Vec3::new(-r.z, 0.0, r.x) * around, north * (0.5 * around)]
                }
            };
            set_vec3(out_u, i, du);
            set_vec3(out_v, i, dv);
        }
    }
}

impl Geometry {
    /// What primitive `id` is, and which of its part.
    #[inline(always)]
    fn primitive(&self, id: u32, near: &mut usize) -> (&Shape, usize) {
        let part = self.part(id, near);
        (&part.shape, (id - part.first) as usize)
    }
}

#[inline(always)]
fn position<const N: usize>(rays: &Rays<N>, i: usize) -> Vec3 {
    let (origin, direction) = rays.ray(i);
    origin + direction * rays.t_max[i]
}

/// Unit normal of a triangle that has an area.
#[inline(always)]
fn triangle_normal(corners: [Vec3; 3]) -> Vec3 {
    let [a, b, c] = corners;
    let n = (b - a).cross(c - a);
    let length_squared = n.dot(n);
    // Far from where squares lose bits to under- or overflow.
    if length_squared > 1e-24 && length_squared < 1e30 { normalize(n) } else { tiny_normal(corners) }
}

#[cold]
fn tiny_normal(corners: [Vec3; 3]) -> Vec3 {
    normalize_or(normal_f64(corners), Vec3::Y)
}

#[inline(always)]
fn sphere_normal(spheres: &Spheres, k: usize, position: Vec3) -> Vec3 {
    let (center, _) = spheres.sphere(k).unwrap_or_default();
    let r = position - center;
    let length_squared = r.dot(r);
    if length_squared > 1e-24 && length_squared < 1e30 {
        normalize(r)
    } else {
        normalize_or(r.to_array().map(f64::from), Vec3::Y)
    }
}

/// Barycentric coordinates of where a ray hits a triangle, each in 0..=1, of sum 1 up to rounding. As ratios of the
/// volumes that the ray and each edge span (Pluecker coordinates): as the edges are taken about their middles, no
/// precision is lost where the triangle is small and far away.
#[inline(always)]
fn barycentric([a, b, c]: [Vec3; 3], (origin, direction): (Vec3, Vec3)) -> [f32; 3] {
    let (a, b, c) = (a - origin, b - origin, c - origin);
    let volume = |p: Vec3, q: Vec3| direction.dot((q - p).cross(q + p));
    let (u, v, w) = (volume(b, c), volume(c, a), volume(a, b));
    let sum = u + v + w;
    let scale = 1.0 / sum;
    if sum == 0.0 || !scale.is_finite() {
        return [1.0 / 3.0; 3];
    }
    // A ray on an edge may be on the wrong side of it by rounding.
    let (u, v) = ((u * scale).clamp(0.0, 1.0), (v * scale).clamp(0.0, 1.0));
    let v = v.min(1.0 - u);
    [u, v, 1.0 - u - v]
}

/// The three corner normals of triangle `k`, if it has them all.
#[inline(always)]
fn corner_normals(mesh: &Mesh, k: usize) -> Option<[Vec3; 3]> {
    let [a, b, c] = *mesh.triangle_normals.get(k)?;
    let at = |index: u32| mesh.normals.get(index as usize).map(|&n| Vec3::from(n));
    Some([at(a)?, at(b)?, at(c)?])
}

/// The three corners' texture coordinates of triangle `k`, if it has them all.
#[inline(always)]
fn corner_texture_coordinates(mesh: &Mesh, k: usize) -> Option<[Vec3; 3]> {
    let [a, b, c] = *mesh.triangle_texture_coordinates.get(k)?;
    let at = |index: u32| mesh.texture_coordinates.get(index as usize).map(|&[u, v]| Vec3::new(u, v, 0.0));
    Some([at(a)?, at(b)?, at(c)?])
}

fn triangle_derivatives(mesh: &Mesh, k: usize) -> [Vec3; 2] {
    let [a, b, c] = mesh.corners(k).unwrap_or_default();
    let (e1, e2) = (b - a, c - a);
    let Some([ta, tb, tc]) = corner_texture_coordinates(mesh, k) else {
        return [e1, e2];
    };
    let (d1, d2) = (tb - ta, tc - ta);
    let determinant = d1.x * d2.y - d1.y * d2.x;
    let scale = 1.0 / determinant;
    if !scale.is_finite() {
        return [e1, e2];
    }
    [(e1 * d2.y - e2 * d1.y) * scale, (e2 * d1.x - e1 * d2.x) * scale]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Object;
    use mobula_core::rays::vec3 as at;
    use proptest::prelude::*;
    use std::sync::Arc;

    fn mesh() -> Mesh {
        Mesh {
            positions: vec![[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 2.0, 0.0]],
            normals: vec![[0.0, 0.0, 1.0], [2.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            texture_coordinates: vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
            triangles: vec![[0, 1, 2]],
            triangle_normals: vec![[0, 1, 2]],
            triangle_texture_coordinates: vec![[0, 1, 2]],
            ..Mesh::default()
        }
    }

    /// A packet of one ray that hit primitive 0 of `object` at distance `t`.
    fn hit(object: Object, origin: Vec3, direction: Vec3, t: f32) -> (Geometry, mobula_core::RayPacket<1>) {
        let mut packet = mobula_core::RayPacket::<1>::default();
        packet.reset(0..1);
        packet.set_ray(0, origin, direction);
        packet.t_max[0] = t;
        packet.hits.primitive[0] = 0;
        (Geometry::new(&[object]).unwrap(), packet)
    }

    #[test]
    fn triangles_interpolate_what_their_corners_have() {
        let (geometry, mut packet) = hit(Object::Mesh(Arc::new(mesh())), Vec3::new(1.0, 1.0, 5.0), Vec3::NEG_Z, 5.0);
        let mut hits = packet.sub_packet(0..1);
        assert_eq!(at(hits.geometric_normals(&geometry), 0), Vec3::Z);
        // Weights 1/4, 1/4, 1/2.
        assert!((at(hits.texture_coordinates(&geometry), 0) - Vec3::new(0.25, 0.5, 0.0)).length() < 1e-6);
        assert!((at(hits.normals(&geometry), 0) - Vec3::new(2.0, 2.0, 1.0) / 3.0).length() < 1e-6);
        let [du, dv] = hits.derivatives(&geometry);
        assert_eq!((at(du, 0), at(dv, 0)), (Vec3::X * 4.0, Vec3::Y * 2.0));
    }

    #[test]
    fn spheres_have_normals_and_longitudes() {
        let spheres = Spheres { centers: vec![[1.0, 0.0, 0.0]], radii: vec![2.0], ..Spheres::default() };
        let (geometry, mut packet) = hit(Object::Spheres(Arc::new(spheres)), Vec3::X * 10.0, Vec3::NEG_X, 7.0);
        let mut hits = packet.sub_packet(0..1);
        assert_eq!(at(hits.normals(&geometry), 0), Vec3::X);
        assert_eq!(at(hits.texture_coordinates(&geometry), 0), Vec3::new(0.5, 0.5, 0.0));
        let [du, dv] = hits.derivatives(&geometry);
        assert!(at(du, 0).normalize().dot(Vec3::Z) > 0.999 && at(dv, 0).normalize().dot(Vec3::Y) > 0.999);
    }

    proptest! {
        #[test]
        fn barycentric_coordinates_find_the_point_again(
            corners in prop::array::uniform3(prop::array::uniform3(-1.0_f32..1.0)),
            weights in prop::array::uniform3(0.0_f32..1.0),
            far in 0.5_f32..100.0,
        ) {
            let corners = corners.map(Vec3::from);
            let [a, b, c] = corners;
            let area = (b - a).cross(c - a).length();
            prop_assume!(area > 0.1 && weights.iter().sum::<f32>() > 0.1);
            let sum: f32 = weights.iter().sum();
            let point = (a * weights[0] + b * weights[1] + c * weights[2]) / sum;
            let normal = triangle_normal(corners);
            let origin = point + (normal + Vec3::new(0.1, 0.2, -0.1)) * far;
            let [u, v, w] = barycentric(corners, (origin, (point - origin).normalize()));
            prop_assert!([u, v, w].iter().all(|x| (0.0..=1.0).contains(x)));
            prop_assert!((a * u + b * v + c * w - point).length() < 1e-5 * (1.0 + far) / area);
        }

        #[test]
        fn normals_have_length_1_at_any_size(
            corners in prop::array::uniform3(prop::array::uniform3(-1.0_f32..1.0)),
            scale in prop_oneof![Just(1e-30_f32), Just(1e-12), Just(1.0), Just(1e12), Just(1e30)],
        ) {
            let normal = triangle_normal(corners.map(|c| Vec3::from(c) * scale));
            prop_assert!((normal.length() - 1.0).abs() < 1e-5);
        }
    }
}
