//! A refitted tree finds what a tree built anew finds, bit for bit.

use crate::common::{AIMS, Random, SHAPES, Shape, Triangle};
use mobula_core::bvh::{Bvh, Join, Quality, Serial};
use mobula_core::glam::Vec3;
use mobula_core::leaf::{Block, Bounds, SphereBlock, TriangleBlock};
use mobula_core::simd::AnyToken;
use mobula_core::{AnyHitPacket, RayPacket};
use proptest::prelude::*;

const N: usize = 64;

/// Does the halves on threads of their own.
struct Threads;

impl Join for Threads {
    fn join<A: Send, B: Send>(&self, a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
        std::thread::scope(|scope| {
            let b = scope.spawn(b);
            let a = a();
            (a, b.join().unwrap())
        })
    }
}

/// Panics at the first hit that differs between two trees.
fn agree<B: Block>(refitted: &Bvh<B>, built: &Bvh<B>, rays: impl Fn(usize) -> (Vec3, Vec3)) {
    let (mut packet, mut shadow) = (RayPacket::<N>::default(), AnyHitPacket::<N>::default());
    packet.reset(0..N);
    shadow.reset(0..N);
    for i in 0..N {
        let (origin, direction) = rays(i);
        packet.set_ray(i, origin, direction);
        shadow.set_ray(i, origin, direction);
    }
    for token in AnyToken::available() {
        let (mut ours, mut theirs) = (packet.clone(), packet.clone());
        refitted.intersect(token, &mut ours);
        built.intersect(token, &mut theirs);
        let (mut dark, mut also) = (shadow.clone(), shadow.clone());
        refitted.occlude(token, &mut dark);
        built.occlude(token, &mut also);
        for i in 0..N {
            assert_eq!(ours.hits.primitive[i], theirs.hits.primitive[i], "{token:?} ray {i} {:?}", packet.ray(i));
            assert_eq!(ours.t_max[i].to_bits(), theirs.t_max[i].to_bits(), "{token:?} ray {i}");
            assert_eq!(dark.occluded(i), also.occluded(i), "{token:?} ray {i}");
        }
    }
}

/// Spoils some, so that they have to be left out.
fn spoil(triangles: &mut [Triangle], random: &mut Random) {
    for triangle in triangles {
        match random.below(20) {
            0 => triangle[0][1] = f32::NAN,
            1 => triangle[2][2] = f32::INFINITY,
            2 => triangle[1] = triangle[0],
            _ => {}
        }
    }
}

/// All shapes, sizes and places: the tree built fast finds what the good one finds.
#[test]
fn trees_built_fast_find_the_same() {
    for (round, shape) in SHAPES.into_iter().enumerate() {
        for (scale, offset) in [(1.0, 0.0), (1e-12, 0.0), (1e12, 0.0), (1.0, 1e4)] {
            let (mut random, offset) = (Random(round as u64), Vec3::splat(offset));
            let scene = shape.triangles(700, scale, offset, &mut random);
            let [fast, good] = [Quality::Fast, Quality::Good]
                .map(|quality| Bvh::<TriangleBlock>::build(scene.len(), 3, quality, &Threads, |i| scene[i]));
            assert_eq!(fast.primitives(), good.primitives());
            for aim in AIMS {
                let seed = |i: usize| Random((round * N + i) as u64);
                agree(&fast, &good, |i| aim.ray(i, round, &scene, scale, offset, &mut seed(i)));
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 100, ..ProptestConfig::default() })]

    #[test]
    fn triangles(
        seed in any::<u64>(),
        shape in prop::sample::select(SHAPES.to_vec()),
        moved in prop::sample::select(SHAPES.to_vec()),
        aim in prop::sample::select(AIMS.to_vec()),
        count in prop::sample::select(vec![0usize, 1, 4, 5, 33, 150, 1000]),
        scale in prop::sample::select(vec![1.0f32, 1e-6, 1e6]),
    ) {
        let mut random = Random(seed);
        let before = shape.triangles(count, 1.0, Vec3::ZERO, &mut random);
        let mut after = moved.triangles(count, scale, Vec3::splat(3.0 * scale), &mut random);
        let mut bvh = Bvh::<TriangleBlock>::triangles(count, 7, &Serial, |i| before[i]);
        // What the tree left out stays out.
        for (after, before) in after.iter_mut().zip(&before).filter(|(_, before)| TriangleBlock::bounds(before).is_none()) {
            *after = *before;
        }
        let rays = after.clone();
        // Some leave, and come back.
        for spoiled in [true, false] {
            let mut now = after.clone();
            if spoiled {
                spoil(&mut now, &mut random);
            }
            bvh.refit(&Threads, |i| now[i]);
            let built = Bvh::<TriangleBlock>::triangles(count, 7, &Serial, |i| now[i]);
            prop_assert_eq!((bvh.bounds().low[..3].to_vec(), bvh.bounds().high[..3].to_vec()),
                (built.bounds().low[..3].to_vec(), built.bounds().high[..3].to_vec()));
            if count > 0 {
                let seed = Random(seed ^ 1);
                agree(&bvh, &built, |i| aim.ray(i, 1, &rays, scale, Vec3::splat(3.0 * scale), &mut Random(seed.0 + i as u64)));
            }
        }
    }

    #[test]
    fn spheres(seed in any::<u64>(), count in 1usize..300, bad in any::<bool>()) {
        let mut random = Random(seed);
        let mut sphere = || random.point(2.0).extend(0.01 + 0.3 * random.unit()).to_array();
        let before: Vec<[f32; 4]> = (0..count).map(|_| sphere()).collect();
        let mut after: Vec<[f32; 4]> = (0..count).map(|_| sphere()).collect();
        if bad {
            after.iter_mut().step_by(5).for_each(|sphere| sphere[3] = -1.0);
            after.iter_mut().skip(1).step_by(5).for_each(|sphere| sphere[0] = f32::NAN);
        }
        let mut bvh = Bvh::<SphereBlock>::spheres(count, 0, &Serial, |i| before[i]);
        bvh.refit(&Serial, |i| after[i]);
        let built = Bvh::<SphereBlock>::spheres(count, 0, &Serial, |i| after[i]);
        agree(&bvh, &built, |i| (Vec3::new(0.1, 0.2, 3.0), Vec3::new(i as f32 / 64.0 - 0.5, 0.1, -1.0)));
    }
}

#[test]
fn large_trees_are_split_among_threads_and_end_up_the_same() {
    let mut random = Random(5);
    let before = Shape::Scattered.triangles(60_000, 1.0, Vec3::ZERO, &mut random);
    let after: Vec<Triangle> =
        before.iter().map(|triangle| triangle.map(|[x, y, z]| [x + z * 0.5, y * 1.5, z - x])).collect();
    let bvh = Bvh::<TriangleBlock>::triangles(before.len(), 0, &Serial, |i| before[i]);
    let (mut alone, mut together) = (bvh.clone(), bvh);
    alone.refit(&Serial, |i| after[i]);
    together.refit(&Threads, |i| after[i]);
    assert!(format!("{alone:?}") == format!("{together:?}"));
    let built = Bvh::<TriangleBlock>::triangles(after.len(), 0, &Serial, |i| after[i]);
    for round in 0..20 {
        agree(&together, &built, |i| {
            crate::common::Aim::Random.ray(i, round, &after, 1.0, Vec3::ZERO, &mut Random((round * N + i) as u64))
        });
    }
}

#[test]
fn all_gone_and_back() {
    let triangles = Shape::Scattered.triangles(100, 1.0, Vec3::ZERO, &mut Random(3));
    let mut bvh = Bvh::<TriangleBlock>::triangles(100, 0, &Serial, |i| triangles[i]);
    bvh.refit(&Serial, |_| [[f32::NAN; 3]; 3]);
    assert_eq!(bvh.bounds().low[..3], Bounds::EMPTY.low[..3]);
    bvh.refit(&Serial, |i| triangles[i]);
    let built = Bvh::<TriangleBlock>::triangles(100, 0, &Serial, |i| triangles[i]);
    agree(&bvh, &built, |i| crate::common::Aim::Camera.ray(i, 0, &triangles, 1.0, Vec3::ZERO, &mut Random(0)));
}
