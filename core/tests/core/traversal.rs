//! The tree finds what testing everything finds, bit for bit, on every path, level and packet width.

use crate::common::{AIMS, Aim, Random, SHAPES, Shape, Triangle};
use mobula_core::bvh::{Bvh, Serial};
use mobula_core::glam::Vec3;
use mobula_core::leaf::{Block, SphereBlock, TriangleBlock};
use mobula_core::simd::AnyToken;
use mobula_core::{AnyHitPacket, NO_HIT, Properties, RayPacket};
use proptest::prelude::*;

/// Panics unless any-hit traversal at all levels finds a hit where closest-hit traversal does.
fn agree_any<const N: usize, B: Block>(bvh: &Bvh<B>, packet: &RayPacket<N>, context: &str) {
    let mut shadow = AnyHitPacket::<N>::default();
    shadow.reset(packet.range());
    for i in packet.range() {
        let (origin, direction) = packet.ray(i);
        shadow.set_ray(i, origin, direction);
        shadow.set_interval(i, packet.t_min()[i], packet.t_max[i]);
    }
    shadow.promise(packet.properties() & (Properties::COMMON_ORIGIN | Properties::NORMALIZED_DIRECTIONS));
    for token in AnyToken::available() {
        let (mut closest, mut any) = (packet.clone(), shadow.clone());
        bvh.intersect(token, &mut closest);
        bvh.occlude(token, &mut any);
        for i in packet.range() {
            assert_eq!(any.occluded(i), closest.was_hit(i), "{context} {token:?} ray {i} {:?}", packet.ray(i));
        }
    }
}

/// Traces a packet through the tree and without it, at all levels, and panics at the first bit that differs.
fn agree<const N: usize, B: Block>(bvh: &Bvh<B>, packet: &RayPacket<N>, context: &str) {
    let mut first_of_family = [None, None];
    for token in AnyToken::available() {
        let mut tree = packet.clone();
        bvh.intersect(token, &mut tree);
        let mut again = packet.clone();
        let all = first_of_family[usize::from(token.fused())].get_or_insert_with(|| {
            let mut all = packet.clone();
            bvh.intersect_all(token.twin(), &mut all);
            all
        });
        // A ray that ends exactly where it hits still hits, and there.
        for i in packet.range() {
            again.set_interval(i, packet.t_min()[i], all.t_max[i]);
        }
        bvh.intersect(token, &mut again);
        for i in 0..N {
            let context = format!("{context} width {N} {token:?} ray {i} {:?}", packet.ray(i));
            assert_eq!(tree.hits.primitive[i], all.hits.primitive[i], "{context}");
            assert_eq!(tree.t_max[i].to_bits(), all.t_max[i].to_bits(), "{context}");
            if packet.range().contains(&i) {
                assert_eq!(again.hits.primitive[i], all.hits.primitive[i], "{context}, ending at its hit");
            } else {
                assert_eq!(tree.hits.primitive[i], NO_HIT, "{context}: not an active ray");
            }
        }
    }
}

/// Packets of `ray` over a part of their width, with what is promised of them.
fn packet<const N: usize>(
    random: &mut Random,
    common_origin: bool,
    mut ray: impl FnMut(usize, &mut Random) -> (Vec3, Vec3),
) -> RayPacket<N> {
    let mut packet = RayPacket::<N>::default();
    let cut = |random: &mut Random| if random.below(2) == 0 { 0 } else { random.below(N / 3 + 1) };
    let range = cut(random)..N - cut(random);
    packet.reset(range.clone());
    let normalized = random.below(2) == 0;
    // The square of a tiny direction's length would underflow, and the promise be false.
    let unit = |d: Vec3| (d / d.abs().max_element()).normalize_or(Vec3::X);
    for i in range.clone() {
        let (origin, direction) = ray(i, random);
        packet.set_ray(i, origin, if normalized { unit(direction) } else { direction });
        if random.below(4) == 0 {
            packet.set_interval(i, random.pick(&[-1.0, 0.0, 0.5]), random.pick(&[0.7, 1.0, 3.0, f32::INFINITY]));
        }
    }
    if normalized {
        packet.promise(Properties::NORMALIZED_DIRECTIONS);
    }
    if common_origin {
        packet.promise(Properties::COMMON_ORIGIN);
    }
    packet
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 150, ..ProptestConfig::default() })]

    #[test]
    fn triangles_found_through_the_tree_are_those_found_without(
        seed in any::<u64>(),
        shape in prop::sample::select(SHAPES.to_vec()),
        aim in prop::sample::select(AIMS.to_vec()),
        count in prop::sample::select(vec![1usize, 2, 4, 5, 9, 33, 150]),
        scale in prop::sample::select(vec![1.0f32, 1.0, 1e-6, 1e6, 1e-12, 1e12, 1e-30, 1e-38, 1e-43]),
        offset in prop::sample::select(vec![Vec3::ZERO, Vec3::ZERO, Vec3::new(30.0, -10.0, 20.0), Vec3::splat(1e4), Vec3::new(1e6, 0.0, -1e5)]),
        far in prop::sample::select(vec![0.0f32, 0.0, 1e3, 1e6, 1e20]),
    ) {
        let mut random = Random(seed);
        let offset = offset * scale;
        let mut triangles = shape.triangles(count, scale, offset, &mut random);
        if far > 0.0 {
            triangles[0][random.below(3)][random.below(3)] += far * scale;
        }
        let bvh = Bvh::<TriangleBlock>::triangles(count, 0, &Serial, |i| triangles[i]);
        let context = format!("{shape:?} {aim:?} {count} {far}");
        let ray = |i, random: &mut Random| aim.ray(i, 1, &triangles, scale, offset, random);
        let common = aim.common_origin();
        agree(&bvh, &packet::<1>(&mut random, common, ray), &context);
        agree(&bvh, &packet::<16>(&mut random, common, ray), &context);
        let usual = packet::<64>(&mut random, common, ray);
        agree(&bvh, &usual, &context);
        agree_any(&bvh, &usual, &context);
        agree(&bvh, &packet::<300>(&mut random, common, ray), &context);
    }

    #[test]
    fn spheres_found_through_the_tree_are_those_found_without(
        seed in any::<u64>(),
        aim in prop::sample::select(vec![Aim::Camera, Aim::Parallel, Aim::Random, Aim::Axes, Aim::AtFeatures]),
        count in prop::sample::select(vec![1usize, 5, 33, 150]),
        radius in prop::sample::select(vec![1.0f32, 0.1, 1e-3, 1e-6]),
        scale in prop::sample::select(vec![1.0f32, 1.0, 1e-6, 1e6, 1e-12, 1e12]),
        offset in prop::sample::select(vec![Vec3::ZERO, Vec3::ZERO, Vec3::new(30.0, -10.0, 20.0), Vec3::splat(1e4)]),
    ) {
        let mut random = Random(seed);
        let offset = offset * scale;
        let triangles = Shape::Snapped.triangles(count, scale, offset, &mut random);
        let spheres: Vec<[f32; 4]> =
            triangles.iter().map(|&[[x, y, z], ..]| [x, y, z, radius * scale * random.unit()]).collect();
        let bvh = Bvh::<SphereBlock>::spheres(count, 0, &Serial, |i| spheres[i]);
        let context = format!("spheres {aim:?} {count}");
        let ray = |i, random: &mut Random| aim.ray(i, 1, &triangles, scale, offset, random);
        let common = aim.common_origin();
        agree(&bvh, &packet::<3>(&mut random, common, ray), &context);
        let usual = packet::<64>(&mut random, common, ray);
        agree(&bvh, &usual, &context);
        agree_any(&bvh, &usual, &context);
    }
}

/// A ray of a tile, 16 rays wide, at a model of which a few pixels are to be seen: from one point or parallel.
fn far_ray(i: usize, parallel: bool, pixels: f32, scale: f32, offset: Vec3) -> (Vec3, Vec3) {
    let target = Vec3::new((i % 16) as f32 - 7.4, (i / 16) as f32 - 7.4, 0.0) * (2.0 / pixels);
    let eye = Vec3::new(5.0, 9.0, 40.0) + if parallel { target } else { Vec3::ZERO };
    (eye * scale + offset, (target - eye) * scale)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, ..ProptestConfig::default() })]

    #[test]
    fn what_is_smaller_than_the_distance_of_rays_is_found_through_the_tree_as_without(
        seed in any::<u64>(),
        shape in prop::sample::select(SHAPES.to_vec()),
        count in prop::sample::select(vec![1usize, 5, 33, 400]),
        parallel in any::<bool>(),
        pixels in prop::sample::select(vec![0.3f32, 1.0, 4.0, 12.0, 50.0]),
        scale in prop::sample::select(vec![1.0f32, 1.0, 1e-6, 1e6]),
        offset in prop::sample::select(vec![Vec3::ZERO, Vec3::ZERO, Vec3::new(30.0, -10.0, 20.0), Vec3::splat(1e4)]),
    ) {
        let mut random = Random(seed);
        let offset = offset * scale;
        let triangles = shape.triangles(count, scale, offset, &mut random);
        let bvh = Bvh::<TriangleBlock>::triangles(count, 0, &Serial, |i| triangles[i]);
        let context = format!("far {shape:?} {count} {pixels} pixels, parallel: {parallel}");
        let ray = |i, _: &mut Random| far_ray(i, parallel, pixels, scale, offset);
        agree(&bvh, &packet::<7>(&mut random, !parallel, ray), &context);
        agree(&bvh, &packet::<16>(&mut random, !parallel, ray), &context);
        let usual = packet::<64>(&mut random, !parallel, ray);
        agree(&bvh, &usual, &context);
        agree_any(&bvh, &usual, &context);
        let wide = packet::<300>(&mut random, !parallel, ray);
        agree(&bvh, &wide, &context);
        agree_any(&bvh, &wide, &context);
        let spheres: Vec<[f32; 4]> =
            triangles.iter().map(|&[[x, y, z], ..]| [x, y, z, 0.1 * scale * random.unit()]).collect();
        let bvh = Bvh::<SphereBlock>::spheres(count, 0, &Serial, |i| spheres[i]);
        agree(&bvh, &usual, &context);
        agree_any(&bvh, &usual, &context);
    }
}

/// One triangle among others, so that there are boxes to be lost behind.
fn with_neighbours(triangle: Triangle) -> Bvh<TriangleBlock> {
    let mut random = Random(3);
    let mut triangles = Shape::Scattered.triangles(40, 0.2, Vec3::splat(5.0), &mut random);
    triangles[17] = triangle;
    Bvh::triangles(triangles.len(), 0, &Serial, |i| triangles[i])
}

fn trace(bvh: &Bvh<TriangleBlock>, origin: Vec3, direction: Vec3) {
    let mut packet = RayPacket::<16>::default();
    packet.reset(0..16);
    for i in 0..16 {
        packet.set_ray(i, origin, direction);
    }
    agree(bvh, &packet, "named");
    for token in AnyToken::available() {
        bvh.intersect_all(token, &mut packet);
        assert_ne!(packet.hits.primitive[0], 17, "{token:?} hit what it should miss at {}", packet.t_max[0]);
    }
}

#[test]
fn a_triangle_whose_corners_are_on_one_line_is_missed_by_rays_that_pass_it() {
    let bvh = with_neighbours([[0.75, 0.25, -0.5], [0.25, 0.0, -0.25], [-0.25, -0.25, 0.0]]);
    let mut random = Random(1);
    for _ in 0..200 {
        let origin = random.point(2.0);
        trace(&bvh, origin, random.point(2.0));
    }
}

#[test]
fn a_triangle_of_a_few_ulp_is_missed_by_rays_that_pass_it() {
    let mut random = Random(2);
    let [a, b, c] = [0.3, 0.3 + f32::EPSILON, 0.3 - f32::EPSILON];
    let bvh = with_neighbours([[a, a, a], [b, a, a], [a, b, c]]);
    for _ in 0..200 {
        let origin = random.point(2.0);
        trace(&bvh, origin, random.point(2.0));
    }
}
