//! What packets hit is what the f64 oracle says, outside a guard band whose width follows from the arithmetic.
//!
//! Let u = 2^-24 and r the greatest distance from the ray's origin to a point of the primitive: margins are fractions of r.
//! - Triangle, sideways: subtracting the origin moves a corner by ur, and ur more through its depth; the shear factor has two
//!   roundings (2 ur), the shear three at most, of up to 2 ur (4 ur): 8 ur on both sheared axes, 12 ur together. The
//!   accepted weights may be off by 2^-20 of 2 r on both: 46 ur. That is 58 ur < 2^-18 r.
//! - Triangle, distance: the hit's point is as far sideways from a point of the triangle, and ten roundings of its depth move it
//!   by 10 ur more: it is within 2^-17 r of the triangle's plane and box.
//! - Sphere: the vector of closest approach is rounded twice (2 ur), and is off *along* the ray by 6 ur, which to first
//!   order leaves its length alone; its square, the radius' square and their difference are four roundings (2 ur of length):
//!   8 ur with room to spare. Its distance: 6 ur along the ray, and the root of a value that is right for a sphere moved by
//!   8 ur: 2^-20 r.
//! - Interval: the oracle's margin is also that of the interval's ends, as points.

use crate::common::{AIMS, Aim, Random, SHAPES, Shape, Triangle};
use glam::{DVec3, Vec3};
use mobula_core::bvh::{Bvh, Serial};
use mobula_core::leaf::{Block, SphereBlock, TriangleBlock};
use mobula_core::oracle::{self, ExactRay, Truth};
use mobula_core::simd::AnyToken;
use mobula_core::{Properties, RayPacket};

const GUARD: f64 = 1.0 / (1 << 18) as f64;

/// A primitive as the oracle knows it.
trait Known: Copy + core::fmt::Debug {
    fn truth(&self, ray: &ExactRay) -> Truth;

    /// Panics if the point at `t` is farther off the primitive than rounding explains.
    fn check_distance(&self, ray: &ExactRay, t: f64, context: &str);
}

fn size(ray: &ExactRay, points: &[[f32; 3]]) -> f64 {
    points.iter().map(|&p| (Vec3::from(p).as_dvec3() - DVec3::from(ray.origin)).length()).fold(0.0, f64::max)
}

impl Known for Triangle {
    fn truth(&self, ray: &ExactRay) -> Truth {
        oracle::triangle(ray, *self)
    }

    fn check_distance(&self, ray: &ExactRay, t: f64, context: &str) {
        let bound = 2.0 * GUARD * size(ray, self);
        let [a, b, c] = self.map(|corner| Vec3::from(corner).as_dvec3() - DVec3::from(ray.origin));
        let point = DVec3::from(ray.direction) * t;
        let off_plane = (b - a).cross(c - a).normalize_or_zero().dot(point - a).abs();
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        let off_box = (low - point).max(point - high).max_element();
        assert!(off_plane <= bound && off_box <= bound, "{context}: off by {off_plane:e}, {off_box:e} of {bound:e}");
    }
}

impl Known for [f32; 4] {
    fn truth(&self, ray: &ExactRay) -> Truth {
        oracle::sphere(ray, *self)
    }

    fn check_distance(&self, ray: &ExactRay, t: f64, context: &str) {
        let [x, y, z, radius] = self.map(f64::from);
        let center = DVec3::new(x, y, z) - DVec3::from(ray.origin);
        let off = ((DVec3::from(ray.direction) * t - center).length() - radius).abs();
        let bound = (center.length() + radius) / f64::from(1 << 20);
        assert!(off <= bound, "{context}: off by {off:e} of {bound:e}");
    }
}

/// Panics if the rays of `traced` found something else than the oracle says of `rays`.
fn compare<const N: usize>(traced: &RayPacket<N>, rays: &[ExactRay], primitives: &[impl Known], context: &str) {
    for (i, ray) in rays.iter().enumerate() {
        let context = format!("{context} width {N} {ray:?}");
        let truths = primitives.iter().map(|primitive| primitive.truth(ray));
        let clear = oracle::closest(truths, GUARD);
        if !traced.was_hit(i) {
            assert_eq!(clear, None, "{context}: missed {:?}", clear.map(|(id, _)| primitives[id]));
            continue;
        }
        let (id, t) = (traced.hits.primitive[i] as usize, f64::from(traced.t_max[i]));
        let truth = primitives[id].truth(ray);
        assert!(truth.t.is_some() || truth.margin <= GUARD, "{context}: hit {:?}, {truth:?}", primitives[id]);
        primitives[id].check_distance(ray, t, &format!("{context}: {:?}", primitives[id]));
        if let Some((nearer, least)) = clear.filter(|&(_, least)| least < t) {
            // Something nearer was not found: then it, or what was found, is where both distances are right.
            primitives[nearer].check_distance(ray, t, &format!("{context}: {least} is nearer than {t}"));
        }
    }
}

fn packets<B: Block>(
    token: AnyToken,
    bvh: &Bvh<B>,
    primitives: &[impl Known],
    normalized: bool,
    context: &str,
    mut ray: impl FnMut(usize) -> (Vec3, Vec3),
    common: bool,
) {
    const N: usize = 64;
    let mut packet = RayPacket::<N>::default();
    packet.reset(0..N);
    for i in 0..N {
        let (origin, direction) = ray(i);
        packet.set_ray(i, origin, if normalized { direction.normalize_or_zero() } else { direction });
    }
    let known = if normalized { Properties::NORMALIZED_DIRECTIONS } else { Properties::empty() };
    if (0..N).all(|i| packet.ray(i).1 != Vec3::ZERO) {
        packet.promise(known);
    }
    let rays: Vec<ExactRay> = (0..N).map(|i| ExactRay::of(&packet, i)).collect();
    let mut general = packet.clone();
    bvh.intersect_all(token, &mut general);
    compare(&general, &rays, primitives, &format!("general {context}"));
    if common {
        packet.promise(Properties::COMMON_ORIGIN);
        bvh.intersect_all(token, &mut packet);
        compare(&packet, &rays, primitives, &format!("common origin {context}"));
    }
    let mut alone = RayPacket::<1>::default();
    for i in (0..N).step_by(5) {
        alone.reset(0..1);
        let (origin, direction) = packet.ray(i);
        alone.set_ray(0, origin, direction);
        bvh.intersect_all(token, &mut alone);
        compare(&alone, &rays[i..=i], primitives, &format!("single {context}"));
    }
}

fn triangles_agree(token: AnyToken) {
    let places = [(1.0, Vec3::ZERO), (1.0, Vec3::new(1e4, -1e4, 2e4)), (1e-12, Vec3::ZERO), (1e12, Vec3::ZERO)];
    for shape in SHAPES {
        for (scale, offset) in places {
            let mut random = Random(11);
            let triangles: Vec<Triangle> = shape.triangles(60, scale, offset, &mut random);
            let bvh = Bvh::<TriangleBlock>::triangles(triangles.len(), 0, &Serial, |i| triangles[i]);
            for aim in AIMS {
                for round in 0..2 {
                    let context = format!("{token:?} {shape:?} * {scale} + {offset} {aim:?}");
                    let ray = |i| aim.ray(i, round, &triangles, scale, offset, &mut random);
                    packets(token, &bvh, &triangles, round == 1, &context, ray, aim.common_origin());
                }
            }
        }
    }
}

fn spheres_agree(token: AnyToken) {
    let places = [(1.0, Vec3::ZERO), (1.0, Vec3::new(1e4, -1e4, 2e4)), (1e-12, Vec3::ZERO), (1e12, Vec3::ZERO)];
    for (scale, offset) in places {
        for radius in [0.3, 1e-3] {
            let mut random = Random(13);
            let triangles: Vec<Triangle> = Shape::Snapped.triangles(60, scale, offset, &mut random);
            let spheres: Vec<[f32; 4]> =
                triangles.iter().map(|&[[x, y, z], ..]| [x, y, z, scale * radius * (0.1 + random.unit())]).collect();
            let bvh = Bvh::<SphereBlock>::spheres(spheres.len(), 0, &Serial, |i| spheres[i]);
            for aim in [Aim::Camera, Aim::Parallel, Aim::Random, Aim::Axes, Aim::AtFeatures, Aim::AtFeaturesFromOne] {
                for round in 0..4 {
                    let context = format!("{token:?} radius {radius} * {scale} + {offset} {aim:?}");
                    let ray = |i| aim.ray(i, round, &triangles, scale, offset, &mut random);
                    packets(token, &bvh, &spheres, round % 2 == 1, &context, ray, aim.common_origin());
                }
            }
        }
    }
}

crate::levels::at_every_level!(triangles_agree, spheres_agree);
