//! On equal distance the lower primitive id wins, whatever the path, the order, and the object it is in.

use crate::common::{Random, Shape, Triangle};
use mobula_core::bvh::{Bvh, Serial};
use mobula_core::glam::Vec3;
use mobula_core::leaf::{SphereBlock, TriangleBlock};
use mobula_core::simd::AnyToken;
use mobula_core::{NO_HIT, Properties, RayPacket};

#[derive(Clone, Copy, Debug, PartialEq)]
enum Path {
    CommonOrigin,
    General,
    Single,
}

/// Rays at points of the triangles, from one point or from several, with signs that travel together or alone.
fn rays<const N: usize>(triangles: &[Triangle], path: Path, random: &mut Random) -> RayPacket<N> {
    let mut packet = RayPacket::<N>::default();
    packet.reset(0..N);
    for i in 0..N {
        let [a, b, c] = triangles[random.below(triangles.len())].map(Vec3::from);
        let target = (a + b + c) / 3.0 + (a - b) * (random.unit() * 0.2);
        let origin = match path {
            Path::CommonOrigin => Vec3::new(-7.0, -8.0, -9.0),
            Path::General => Vec3::new(-7.0, -8.0, -9.0) + random.point(0.5),
            Path::Single => random.point(9.0),
        };
        packet.set_ray(i, origin, target - origin);
    }
    if path == Path::CommonOrigin {
        packet.promise(Properties::COMMON_ORIGIN);
    }
    packet
}

fn check<const N: usize>(token: AnyToken, triangles: &[Triangle], copies: usize) {
    let count = triangles.len();
    let doubled = Bvh::<TriangleBlock>::triangles(count * copies, 0, &Serial, |i| triangles[i % count]);
    // The same triangles as objects of their own, with ids above and below.
    let above = Bvh::<TriangleBlock>::triangles(count, 1000, &Serial, |i| triangles[i]);
    let below = Bvh::<TriangleBlock>::triangles(count, 100, &Serial, |i| triangles[i]);
    for path in [Path::CommonOrigin, Path::General, Path::Single] {
        let mut random = Random(17);
        for _ in 0..10 {
            let packet = rays::<N>(triangles, path, &mut random);
            let context = format!("{token:?} width {N} {path:?}");
            let mut once = packet.clone();
            below.intersect(token, &mut once);
            assert!((0..N).any(|i| once.was_hit(i)), "{context}: nothing was hit");
            let mut both = packet.clone();
            doubled.intersect(token, &mut both);
            let mut up = packet.clone();
            below.intersect(token, &mut up);
            above.intersect(token, &mut up);
            let mut down = packet.clone();
            above.intersect(token, &mut down);
            below.intersect(token, &mut down);
            for i in 0..N {
                let id = once.hits.primitive[i];
                let expected = if id == NO_HIT { NO_HIT } else { id - 100 };
                assert_eq!(both.hits.primitive[i], expected, "{context}: copies in one tree, ray {i}");
                assert_eq!(up.hits.primitive[i], id, "{context}: the lower first, ray {i}");
                assert_eq!(down.hits.primitive[i], id, "{context}: the higher first, ray {i}");
                assert_eq!(up.t_max[i].to_bits(), down.t_max[i].to_bits(), "{context}");
            }
        }
    }
}

fn the_lower_of_coincident_triangles_is_hit(token: AnyToken) {
    let mut random = Random(5);
    let triangles = Shape::Scattered.triangles(30, 4.0, Vec3::ZERO, &mut random);
    check::<1>(token, &triangles, 7);
    check::<16>(token, &triangles, 2);
    check::<100>(token, &triangles, 7);
}

fn a_fan_around_a_vertex_is_hit_at_its_lowest_id(token: AnyToken) {
    // Rays at the middle hit all of them at the same depth: they are all in one plane, across the rays.
    let rim = |i: usize| {
        let angle = i as f32 * core::f32::consts::TAU / 12.0;
        [angle.cos(), angle.sin(), 2.0]
    };
    let fan = Bvh::<TriangleBlock>::triangles(12, 0, &Serial, |i| [[0.0, 0.0, 2.0], rim(11 - i), rim(12 - i)]);
    let mut packet = RayPacket::<64>::default();
    packet.reset(0..64);
    packet.directions_mut()[2].fill(1.0);
    packet.set_common_origin(Vec3::ZERO);
    fan.intersect(token, &mut packet);
    assert_eq!(packet.hits.primitive[..], [0; 64]);
    assert_eq!(packet.t_max[..], [2.0; 64]);
}

fn the_lower_of_coincident_spheres_is_hit(token: AnyToken) {
    let at = |i: usize| [(i % 10) as f32, 0.0, 5.0, 0.4];
    let bvh = Bvh::<SphereBlock>::spheres(50, 0, &Serial, at);
    let mut packet = RayPacket::<64>::default();
    packet.reset(0..64);
    for i in 0..64 {
        packet.set_ray(i, Vec3::ZERO, Vec3::new((i % 10) as f32, 0.01 * i as f32 - 0.3, 5.0));
    }
    bvh.intersect(token, &mut packet);
    for i in 0..64 {
        assert!(packet.hits.primitive[i] < 10, "ray {i} hit {}", packet.hits.primitive[i]);
    }
}

crate::levels::at_every_level!(
    the_lower_of_coincident_triangles_is_hit,
    a_fan_around_a_vertex_is_hit_at_its_lowest_id,
    the_lower_of_coincident_spheres_is_hit,
);
