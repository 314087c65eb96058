//! The tree finds what testing everything finds, bit for bit, on every path, level and packet width.

use glam::Vec3;
use mobula_core::bvh::{Block, Bvh, Serial, SphereBlock, TriangleBlock};
use mobula_core::simd::AnyToken;
use mobula_core::{AnyHitPacket, Properties, RayPacket, glam};

/// A small deterministic generator (PCG-like), so that a failure can be repeated.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1u64 << 24) as f32
    }

    fn point(&mut self, size: f32) -> Vec3 {
        Vec3::new(self.unit() - 0.5, self.unit() - 0.5, self.unit() - 0.5) * size
    }
}

#[derive(Clone, Copy, Debug)]
enum Aim {
    Camera,
    Parallel,
    Random,
    Axes,
}

fn ray(random: &mut Random, aim: Aim, i: usize) -> (Vec3, Vec3) {
    let tile = Vec3::new((i % 8) as f32, (i / 8 % 8) as f32, 0.0);
    match aim {
        Aim::Camera => (Vec3::new(0.1, 0.2, 3.0), Vec3::new(-0.3, -0.35, -1.0) + tile * 0.08),
        Aim::Parallel => (Vec3::new(-0.5, -0.5, 4.0) + tile * 0.13, Vec3::new(0.05, 0.03, -1.0)),
        Aim::Random => (random.point(2.0), random.point(2.0)),
        Aim::Axes => {
            let axis = [Vec3::X, Vec3::Y, Vec3::Z][i % 3] * if random.unit() < 0.5 { -1.0 } else { 1.0 };
            ((random.point(2.0) * 8.0).round() / 8.0, axis)
        }
    }
}

fn check<const N: usize, B: Block>(bvh: &Bvh<B>, what: &str) {
    for aim in [Aim::Camera, Aim::Parallel, Aim::Random, Aim::Axes] {
        let mut random = Random(7);
        for round in 0..6 {
            let mut packet = RayPacket::<N>::default();
            let range = if round == 0 {
                0..N
            } else {
                (random.unit() * N as f32 * 0.3) as usize..N - (random.unit() * N as f32 * 0.3) as usize
            };
            packet.reset(range.clone());
            for i in range.clone() {
                let (origin, direction) = ray(&mut random, aim, i + round);
                packet.set_ray(i, origin, direction);
            }
            if matches!(aim, Aim::Camera) {
                packet.promise(Properties::COMMON_ORIGIN);
            }
            for token in AnyToken::available() {
                for twin in [token.twin(), token] {
                    let (mut tree, mut all) = (packet.clone(), packet.clone());
                    bvh.intersect(twin, &mut tree);
                    bvh.intersect_all(token, &mut all);
                    let mut shadow = AnyHitPacket::<N>::default();
                    shadow.reset(range.clone());
                    for i in range.clone() {
                        let (origin, direction) = packet.ray(i);
                        shadow.set_ray(i, origin, direction);
                    }
                    bvh.occlude(twin, &mut shadow);
                    for i in 0..N {
                        let context =
                            format!("{what} {aim:?} round {round} width {N} {twin:?} ray {i} {:?}", packet.ray(i));
                        assert_eq!(tree.hits.primitive[i], all.hits.primitive[i], "{context}");
                        assert_eq!(tree.t_max[i].to_bits(), all.t_max[i].to_bits(), "{context}");
                        if range.contains(&i) {
                            assert_eq!(shadow.occluded(i), all.was_hit(i), "{context}");
                        }
                    }
                }
            }
        }
    }
}

fn check_widths<B: Block>(bvh: &Bvh<B>, what: &str) {
    check::<1, B>(bvh, what);
    check::<3, B>(bvh, what);
    check::<16, B>(bvh, what);
    check::<64, B>(bvh, what);
    check::<300, B>(bvh, what);
}

#[test]
fn triangles_found_through_the_tree_are_those_found_without() {
    let mut random = Random(1);
    let scattered: Vec<[[f32; 3]; 3]> = (0..500)
        .map(|_| {
            let middle = random.point(2.0);
            [0, 1, 2].map(|_| (middle + random.point(0.4)).to_array())
        })
        .collect();
    let bvh = Bvh::<TriangleBlock>::triangles(scattered.len(), 0, &Serial, |i| scattered[i]);
    assert_eq!(bvh.primitives(), 500);
    check_widths(&bvh, "scattered");
    let snapped: Vec<[[f32; 3]; 3]> = scattered.iter().map(|t| t.map(|c| c.map(|x| (x * 4.0).round() / 4.0))).collect();
    let bvh = Bvh::<TriangleBlock>::triangles(snapped.len(), 0, &Serial, |i| snapped[i]);
    assert!(bvh.primitives() < 500, "snapping makes some triangles degenerate");
    check_widths(&bvh, "snapped");
}

#[test]
fn spheres_found_through_the_tree_are_those_found_without() {
    let mut random = Random(2);
    let spheres: Vec<[f32; 4]> = (0..500)
        .map(|_| {
            let c = random.point(2.0);
            [c.x, c.y, c.z, 0.01 + 0.1 * random.unit()]
        })
        .collect();
    let bvh = Bvh::<SphereBlock>::spheres(spheres.len(), 0, &Serial, |i| spheres[i]);
    check_widths(&bvh, "spheres");
}
