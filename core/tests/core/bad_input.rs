//! Bad rays and bad primitives: no panic, no hang, no hit that is none; the good ones beside them are still found.

use crate::common::{Aim, Random, Shape, Triangle};
use mobula_core::bvh::{Bvh, Join, Quality, Serial};
use mobula_core::glam::Vec3;
use mobula_core::leaf::{Bounds, TriangleBlock};
use mobula_core::simd::AnyToken;
use mobula_core::{NO_HIT, Properties, RayPacket};

const N: usize = 64;
const BAD: [f32; 6] = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 3e38, 1e-45, -0.0];

fn triangles(all: &[Triangle]) -> Bvh<TriangleBlock> {
    Bvh::triangles(all.len(), 0, &Serial, |i| all[i])
}

fn packet(rays: impl Fn(usize) -> (Vec3, Vec3)) -> RayPacket<N> {
    let mut packet = RayPacket::default();
    packet.reset(0..N);
    for i in 0..N {
        let (origin, direction) = rays(i);
        packet.set_ray(i, origin, direction);
    }
    packet
}

/// A camera's rays, and what they hit at every level with and without the tree, which must be the same.
fn traced(bvh: &Bvh<TriangleBlock>) -> Vec<RayPacket<N>> {
    let rays = packet(|i| Aim::Camera.ray(i, 0, &[], 1.0, Vec3::ZERO, &mut Random(0)));
    AnyToken::available()
        .map(|token| {
            let (mut tree, mut all) = (rays.clone(), rays.clone());
            bvh.intersect(token, &mut tree);
            bvh.intersect_all(token, &mut all);
            assert_eq!(tree.hits.primitive, all.hits.primitive);
            tree
        })
        .collect()
}

#[test]
fn bad_rays_hit_nothing_and_leave_their_neighbours_alone() {
    let mut random = Random(1);
    let scene = Shape::Scattered.triangles(100, 1.0, Vec3::ZERO, &mut random);
    let bvh = triangles(&scene);
    let camera = |i| Aim::Camera.ray(i, 0, &[], 1.0, Vec3::ZERO, &mut Random(0));
    let good = traced(&bvh).remove(0);
    for (which, bad) in BAD.into_iter().enumerate() {
        for axis in 0..6 {
            let spoiled = packet(|i| {
                let (mut origin, mut direction) = camera(i);
                if i % 7 == 3 {
                    if axis < 3 { origin[axis] = bad } else { direction[axis - 3] = bad }
                }
                (origin, direction)
            });
            for token in AnyToken::available() {
                let mut traced = spoiled.clone();
                bvh.intersect(token, &mut traced);
                for i in 0..N {
                    if i % 7 != 3 {
                        assert_eq!(traced.hits.primitive[i], good.hits.primitive[i], "{token:?} {bad} {axis} ray {i}");
                    } else if which == 0 {
                        assert!(!traced.was_hit(i), "{token:?}: a NaN ray hit at {}", traced.t_max[i]);
                    }
                }
            }
        }
    }
}

#[test]
fn rays_without_a_direction_or_an_interval_hit_nothing() {
    let scene = [[[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]]; 9];
    let bvh = triangles(&scene);
    let zeros = [0.0, -0.0];
    let still = packet(|i| (Vec3::ZERO, Vec3::new(zeros[i % 2], zeros[i / 2 % 2], zeros[i / 4 % 2])));
    let mut over = packet(|i| (Vec3::new(0.0, 0.0, 1.0 + i as f32), Vec3::NEG_Z));
    for i in 0..N {
        let (near, far) =
            [(5.0, 4.0), (f32::NAN, 1e9), (0.0, f32::NAN), (200.0, 300.0), (0.0, 0.5), (0.0, -1.0)][i % 6];
        over.set_interval(i, near, far);
    }
    for token in AnyToken::available() {
        for rays in [&still, &over] {
            let mut traced = rays.clone();
            bvh.intersect(token, &mut traced);
            assert_eq!(traced.hits.primitive[..], [NO_HIT; N], "{token:?}");
        }
    }
}

#[test]
fn triangles_that_are_not_finite_or_degenerate_are_left_out_and_counted() {
    let mut random = Random(2);
    let good = Shape::Scattered.triangles(100, 1.0, Vec3::ZERO, &mut random);
    let mut spoiled = good.clone();
    for (i, triangle) in spoiled.iter_mut().enumerate().filter(|(i, _)| i % 3 == 0) {
        match i % 12 {
            0 => triangle[i % 2][i % 3] = f32::NAN,
            3 => triangle[1][i % 3] = f32::INFINITY,
            6 => triangle[2] = triangle[0],
            _ => *triangle = [triangle[1]; 3],
        }
    }
    let without: Vec<Triangle> = (0..100).map(|i| if i % 3 == 0 { [[f32::NAN; 3]; 3] } else { good[i] }).collect();
    let bvh = triangles(&spoiled);
    assert_eq!(bvh.primitives(), 66);
    assert!(bvh.bounds().is_finite());
    for (a, b) in traced(&bvh).into_iter().zip(traced(&triangles(&without))) {
        assert_eq!(a.hits.primitive, b.hits.primitive);
        assert_eq!(a.t_max, b.t_max);
    }
}

#[test]
fn nothing_is_hit_where_there_is_nothing() {
    for scene in [vec![], vec![[[f32::NAN; 3]; 3]; 5]] {
        let bvh = triangles(&scene);
        assert_eq!((bvh.primitives(), bvh.nodes(), bvh.bounds()), (0, 0, Bounds::EMPTY));
        assert!(traced(&bvh).iter().all(|packet| packet.hits.primitive[..] == [NO_HIT; N]));
    }
}

#[test]
fn one_triangle_is_found() {
    let bvh = triangles(&[[[-9.0, -9.0, 0.0], [9.0, -9.0, 0.0], [0.0, 9.0, 0.0]]]);
    assert!(traced(&bvh).iter().all(|packet| packet.hits.primitive[..] == [0; N]));
}

#[test]
fn a_hundred_thousand_times_the_same_triangle_is_hit_at_the_first() {
    let bvh = Bvh::<TriangleBlock>::triangles(100_000, 0, &Serial, |_| {
        [[-9.0, -9.0, 0.0], [9.0, -9.0, 0.0], [0.0, 9.0, 0.0]]
    });
    let rays = packet(|i| Aim::Camera.ray(i, 0, &[], 1.0, Vec3::ZERO, &mut Random(0)));
    for token in AnyToken::available() {
        let mut traced = rays.clone();
        bvh.intersect(token, &mut traced);
        assert_eq!(traced.hits.primitive[..], [0; N], "{token:?}");
    }
}

#[test]
fn triangles_with_one_middle_are_told_apart() {
    // Concentric, of growing size and turning: no split plane separates their middles.
    let scene: Vec<Triangle> = (0..5000)
        .map(|i| {
            let size = 1.0 + i as f32 * 1e-3;
            let mut corners = [[-size, -size, 0.0], [size, -size, 0.0], [-size, size, 0.0]];
            corners.iter_mut().for_each(|corner| corner.rotate_right(i % 3));
            corners
        })
        .collect();
    traced(&triangles(&scene));
}

/// Sizes 1, 1/2, 1/4, ..., from the float's greatest to its least, one inside the other or one beside the other: the area
/// heuristic would peel off one at a time, and the tree be as deep as there are sizes, were its depth not bounded.
#[test]
fn deeply_nested_sizes_do_not_overflow_the_stack() {
    for beside in [0.0, 1.0] {
        let scene: Vec<Triangle> = (0..20_000)
            .map(|i| {
                let size = 0.5f32.powi(i % 250 - 126);
                let shift = size * beside + (i / 250) as f32 * f32::EPSILON * size;
                [[shift, shift, -size], [shift + size, shift, size], [shift, shift + size, size]]
            })
            .collect();
        for quality in [Quality::Fast, Quality::Good] {
            let bvh = Bvh::<TriangleBlock>::build(scene.len(), 0, quality, &Serial, |i| scene[i]);
            let grazing =
                packet(|i| (Vec3::splat(-1e-3 * (i % 8) as f32), Vec3::new(1.0, 1.0 + i as f32 * 1e-4, 1e-3)));
            for token in AnyToken::available() {
                let (mut tree, mut all) = (grazing.clone(), grazing.clone());
                bvh.intersect(token, &mut tree);
                bvh.intersect_all(token, &mut all);
                assert_eq!(tree.hits.primitive, all.hits.primitive, "{token:?} beside {beside}");
            }
        }
    }
}

/// Does the halves on threads of their own, the second first.
struct Threads;

impl Join for Threads {
    fn join<A: Send, B: Send>(&self, a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
        std::thread::scope(|scope| {
            let b = scope.spawn(b);
            let a = scope.spawn(a);
            (a.join().unwrap(), b.join().unwrap())
        })
    }
}

#[test]
fn the_tree_is_the_same_bytes_whoever_builds_it() {
    for shape in [Shape::Scattered, Shape::Coplanar, Shape::Nested] {
        // More than the builders do in one piece.
        let scene = shape.triangles(100_000, 1.0, Vec3::ZERO, &mut Random(9));
        for quality in [Quality::Fast, Quality::Good] {
            let serial = Bvh::<TriangleBlock>::build(scene.len(), 0, quality, &Serial, |i| scene[i]);
            let threads = Bvh::<TriangleBlock>::build(scene.len(), 0, quality, &Threads, |i| scene[i]);
            assert!(serial.nodes() > 1000);
            // Debug prints every float so that it reads back as the same bits.
            assert!(format!("{serial:?}") == format!("{threads:?}"), "{shape:?} {quality:?}");
        }
    }
}

#[test]
fn a_promise_survives_a_bad_ray() {
    let bvh = triangles(&[[[-9.0, -9.0, 0.0], [9.0, -9.0, 0.0], [0.0, 9.0, 0.0]]; 12]);
    let mut rays = packet(|i| (Vec3::new(0.0, 0.0, 3.0), if i == 5 { Vec3::NAN } else { Vec3::NEG_Z }));
    rays.promise(Properties::COMMON_ORIGIN | Properties::NORMALIZED_DIRECTIONS);
    for token in AnyToken::available() {
        let mut traced = rays.clone();
        bvh.intersect(token, &mut traced);
        assert!((0..N).all(|i| traced.was_hit(i) == (i != 5)), "{token:?}");
    }
}
