//! What differential tests and fuzzers once found, and what is easy to get wrong, by name. At every level of this machine.

use mobula_core::bvh::{Bvh, Serial};
use mobula_core::kernel::cell_walk::RayLanes;
use mobula_core::kernel::iso_cell::iso_cell;
use mobula_core::leaf::{Block, SphereBlock, TriangleBlock};
use mobula_core::simd::{AnyToken, F32Lanes, MaskLanes, Task, Token};
use mobula_core::vector::splat3;
use mobula_core::{Properties, RayPacket};

/// One ray against a unit cell, in every lane.
struct Cell<'a> {
    values: &'a [f32; 8],
    origin: [f32; 3],
    direction: [f32; 3],
    interval: [f32; 2],
}

impl Task for Cell<'_> {
    type Output = Option<f32>;

    #[inline(always)]
    fn run<T: Token>(self, token: T) -> Option<f32> {
        let corners = self.values.map(|value| token.splat(value));
        let [x, y, z] = self.direction;
        let inverse = splat3(token, [1.0 / x, 1.0 / y, 1.0 / z]);
        let (origin, direction) = (splat3(token, self.origin), splat3(token, self.direction));
        let [t_min, t_max] = [token.splat(self.interval[0]), token.splat(self.interval[1])];
        let (low, all) = ([token.splat(0.0); 3], token.mask(u32::MAX));
        let rays = RayLanes { origin, direction, inverse, t_min };
        let (hit, t) = iso_cell::<T, false>(token, all, &corners, low, &rays, t_max);
        assert!(hit.all() || !hit.any(), "the same ray in every lane");
        let (any, _) = iso_cell::<T, true>(token, all, &corners, low, &rays, t_max);
        assert_eq!(any.bits(), hit.bits(), "any hit, where there is a closest");
        hit.any().then(|| t.reduce_min())
    }
}

/// What every level and twin says, which must be one thing in each family.
fn hit(cell: impl Fn() -> Cell<'static>) -> Option<f32> {
    let mut all = AnyToken::available().flat_map(|token| [token.twin().run(cell()), token.run(cell())]);
    let first = all.next().unwrap();
    for other in all {
        assert_eq!(other.is_some(), first.is_some());
        assert!((other.unwrap_or(0.0) - first.unwrap_or(0.0)).abs() < 1e-6);
    }
    first
}

/// (x - 1/2)(y - 1/2) - 0.01: along x = y it is positive, negative between 0.4 and 0.6, and positive again.
const VALLEY: [f32; 8] = [0.24, -0.26, -0.26, 0.24, 0.24, -0.26, -0.26, 0.24];

fn diagonal(from: f32, interval: [f32; 2]) -> Cell<'static> {
    Cell { values: &VALLEY, origin: [from, from, 0.5], direction: [1.0, 1.0, 1e-6], interval }
}

#[test]
fn a_cell_whose_ray_crosses_twice_between_equal_signs_is_hit_where_it_crosses_first() {
    let t = hit(|| diagonal(-1.0, [0.0, f32::INFINITY])).unwrap();
    assert!((t - 1.4).abs() < 1e-5, "{t}");
}

#[test]
fn a_cell_is_hit_at_the_second_crossing_by_a_ray_that_starts_between_both() {
    let t = hit(|| diagonal(0.5, [0.0, f32::INFINITY])).unwrap();
    assert!((t - 0.1).abs() < 1e-5, "{t}");
}

#[test]
fn a_cell_is_missed_by_an_interval_that_ends_before_the_first_crossing_or_starts_after_the_last() {
    assert_eq!(hit(|| diagonal(0.0, [0.0, 0.39])), None);
    assert_eq!(hit(|| diagonal(0.0, [0.61, 2.0])), None);
    assert!(hit(|| diagonal(0.0, [0.0, 0.41])).is_some());
    assert_eq!(hit(|| diagonal(0.0, [0.0, f32::NAN])), None);
}

#[test]
fn a_cell_that_never_comes_near_zero_is_missed_and_so_is_one_that_is_zero() {
    let cell = |values| Cell { values, origin: [-1.0, 0.3, 0.4], direction: [1.0, 0.01, 0.02], interval: [0.0, 9.0] };
    assert_eq!(hit(|| cell(&[1.0; 8])), None);
    assert_eq!(hit(|| cell(&[0.0; 8])), None);
    assert_eq!(hit(|| cell(&[f32::NAN; 8])), None);
}

fn corner(i: usize, k: usize) -> [f32; 3] {
    [(i % 7) as f32 * 0.3 - 1.0 + 0.2 * k as f32, (i / 7) as f32 * 0.3 - 1.0, k as f32]
}

/// Triangles that lie over each other between 0 and 2.
fn slanted() -> Bvh<TriangleBlock> {
    Bvh::triangles(49, 0, &Serial, |i| [corner(i, 0), corner(i + 1, 2), corner(i + 7, 1)])
}

/// Boxes are tested with reciprocals that stay finite, so a short direction missed boxes whose triangles it hit. Found by
/// the fuzzer. Spheres need the square of the length.
#[test]
fn directions_too_short_or_long_for_their_reciprocals_and_squares_find_through_the_tree_what_they_find_without() {
    tree_finds_what_all_find(&slanted());
    let sphere = |i: usize| [corner(i, 0)[0], corner(i, 0)[1], corner(i, 3)[2], 0.2];
    tree_finds_what_all_find(&Bvh::<SphereBlock>::spheres(49, 0, &Serial, sphere));
}

fn tree_finds_what_all_find<B: Block>(bvh: &Bvh<B>) {
    for length in [1e25, 1e19, 1e-14, 1e-18, 1e-20, 1e-22, 1e-24, 1e-30, 1e-36, 1e-37, 7e-38, 4e-39, 1e-40, 1e-45] {
        for token in AnyToken::available() {
            let mut packet = RayPacket::<24>::default();
            packet.reset(0..24);
            for i in 0..24 {
                let direction = [(i % 5) as f32 * 0.1 - 0.2, (i / 5) as f32 * 0.1 - 0.2, 1.0].map(|x| x * length);
                packet.set_ray(i, [0.01, 0.02, -0.5].into(), direction.into());
            }
            let mut all = packet.clone();
            bvh.intersect(token, &mut packet);
            bvh.intersect_all(token, &mut all);
            assert_eq!(packet.hits.primitive.0, all.hits.primitive.0, "{length:e} {token:?}");
        }
    }
}

/// Sends 24 rays from below the [`slanted`] triangles, together, without the tree, and each alone, and panics unless they find
/// the same. `forward` is how fast they go upwards. Says how many hit.
fn together_rays_find_what_they_find_alone(forward: f32, interval: impl Fn(usize) -> [f32; 2]) -> usize {
    let bvh = slanted();
    let mut hits = 0;
    for (token, properties) in
        AnyToken::available().flat_map(|token| [Properties::empty(), Properties::COMMON_ORIGIN].map(|p| (token, p)))
    {
        let mut packet = RayPacket::<24>::default();
        packet.reset(0..24);
        for i in 0..24 {
            let [x, y] = [i % 5, i / 5].map(|at| (at as f32 * 0.2 - 0.4) * forward.signum());
            let direction = [x, y, forward];
            packet.set_ray(i, [0.01, 0.02, -0.5].into(), direction.into());
            packet.set_interval(i, interval(i)[0], interval(i)[1]);
        }
        packet.promise(properties);
        let (mut tree, mut all) = (packet.clone(), packet.clone());
        bvh.intersect(token, &mut tree);
        bvh.intersect_all(token, &mut all);
        for i in 0..24 {
            let mut alone = packet.clone();
            for other in (0..24).filter(|&other| other != i) {
                alone.set_interval(other, 0.0, f32::NEG_INFINITY);
            }
            bvh.intersect_all(token, &mut alone);
            let found = |of: &RayPacket<24>| (of.hits.primitive[i], of.t_max[i].to_bits());
            assert_eq!(found(&tree), found(&alone), "{token:?} {properties:?} ray {i}, through the tree");
            assert_eq!(found(&all), found(&alone), "{token:?} {properties:?} ray {i}, without it");
            hits += usize::from(alone.was_hit(i));
        }
    }
    hits
}

/// Its `t_max` made how far the group reaches NaN at the first hit, and the group found nothing more. Found by the fuzzer.
#[test]
fn a_ray_whose_interval_is_not_a_number_takes_nothing_from_its_neighbours() {
    let hits =
        together_rays_find_what_they_find_alone(1.0, |i| [0.0, if i % 8 == 7 { f32::NAN } else { f32::INFINITY }]);
    assert!(hits > 0);
}

/// What lies around rays that go loosely was taken from where they end and their origin.
#[test]
fn rays_that_start_behind_their_origin_hit_what_is_there() {
    assert!(together_rays_find_what_they_find_alone(-1.0, |_| [-9.0, 0.0]) > 0);
    assert!(together_rays_find_what_they_find_alone(-1.0, |_| [f32::NEG_INFINITY, -0.1]) > 0);
}

/// Its reciprocal is 0, and so was the distance of all that lies along its axis.
#[test]
fn an_infinite_direction_hits_nothing() {
    assert_eq!(together_rays_find_what_they_find_alone(f32::INFINITY, |_| [-1.0, 0.0]), 0);
}

/// Origin times reciprocal was infinite, and so all planes were, to streams and single rays.
#[test]
fn short_directions_with_a_zero_in_a_scene_of_some_size_find_through_the_tree_what_they_find_without() {
    let wide = |i, k| corner(i, k).map(|x| x * 10.0);
    let bvh = Bvh::<TriangleBlock>::triangles(49, 0, &Serial, |i| [wide(i, 0), wide(i + 1, 2), wide(i + 7, 1)]);
    for token in AnyToken::available() {
        for (length, rays) in [1e-20, 1e-27, 1e-30].into_iter().flat_map(|length| [(length, 24), (length, 2)]) {
            let mut packet = RayPacket::<24>::default();
            packet.reset(0..rays);
            for i in 0..rays {
                let x = (i % 5) as f32 * 0.2 - 0.4;
                packet.set_ray(i, [0.01 * i as f32, 5.02, -5.0].into(), [x * length, 0.0, length].into());
                packet.set_interval(i, -1.0, f32::INFINITY);
            }
            let mut all = packet.clone();
            bvh.intersect(token, &mut packet);
            bvh.intersect_all(token, &mut all);
            assert_eq!(packet.hits.primitive.0, all.hits.primitive.0, "{length:e} {token:?}");
            assert!(all.was_hit(0));
        }
    }
}

/// From so far away that sums of bounds overflow; found by fuzzing.
#[test]
fn rays_from_the_end_of_the_numbers_find_through_the_tree_what_they_find_without() {
    let walls =
        |i: usize| [[0.0, -0.2, -0.2], [0.1, 0.3, -0.2], [0.05, 0.0, 0.3]].map(|[x, y, z]| [x + i as f32, y, z]);
    let bvh = Bvh::<TriangleBlock>::triangles(20, 0, &Serial, walls);
    let mut hits = 0;
    for token in AnyToken::available() {
        let mut packet = RayPacket::<24>::default();
        packet.reset(0..24);
        for i in 0..24 {
            packet.set_ray(
                i,
                [-f32::MAX, -2.620_042_6e-16, -1.004_718_5e-33].into(),
                [8.396_917_6e33, -5.2e-25, 0.0].into(),
            );
        }
        packet.promise(Properties::COMMON_ORIGIN);
        let (mut tree, mut all) = (packet.clone(), packet);
        bvh.intersect(token, &mut tree);
        bvh.intersect_all(token, &mut all);
        for i in 0..24 {
            assert_eq!(tree.hits.primitive[i], all.hits.primitive[i], "{token:?} ray {i}");
            hits += usize::from(all.was_hit(i));
        }
    }
    assert!(hits > 0);
}

/// The first ray is infinitely fast along x, so its reciprocal is `-0`, which is not `< 0`: all rays that were tested one by one
/// against boxes took the farther planes for the nearer ones, and missed.
#[test]
fn the_sign_of_a_packet_whose_first_ray_is_infinitely_fast_is_its_bit() {
    let wall = |i: usize| {
        let y = i as f32 - 32.0;
        [[-5.0, y, -40.0], [-5.0, y + 1.0, -40.0], [-5.5, y + 0.5, 40.0]]
    };
    let bvh = Bvh::<TriangleBlock>::triangles(64, 0, &Serial, wall);
    let mut packet = RayPacket::<64>::default();
    packet.reset(0..64);
    for i in 0..64 {
        let y = (i as f32 * 7.0) % 60.0 - 30.0;
        packet.set_ray(i, [0.1 * y, y, -1.0].into(), [-1.0, -0.3 - 0.01 * i as f32, -0.2].into());
    }
    packet.set_ray(0, [0.0, 0.0, 0.0].into(), [f32::NEG_INFINITY, -0.3, -0.2].into());
    for token in AnyToken::available() {
        let (mut tree, mut all) = (packet.clone(), packet.clone());
        bvh.intersect(token, &mut tree);
        bvh.intersect_all(token, &mut all);
        assert_eq!(tree.hits.primitive[..], all.hits.primitive[..], "{token:?}");
        assert!(all.hits.primitive.iter().filter(|&&id| id != mobula_core::NO_HIT).count() > 20);
    }
}

/// Sums with the coordinates of a tree that reaches to the end of the numbers overflow: packets without a common origin were
/// bounded all the same, and missed what lay in the same box.
#[test]
fn a_tree_that_reaches_to_the_end_of_the_numbers_is_hit_by_parallel_rays() {
    let spheres = [[0.5, 0.0, 0.5, 3e17], [f32::MIN, 0.0, 0.0, 0.04], [0.0, 0.0, 1e18, 0.1], [0.0, 5.0, 0.0, 0.3]];
    let bvh = Bvh::<SphereBlock>::spheres(spheres.len(), 0, &Serial, |i| spheres[i]);
    let mut packet = RayPacket::<64>::default();
    packet.reset(0..64);
    for i in 0..64 {
        packet.set_ray(i, [-1.0, (i % 8) as f32, (i / 8) as f32].into(), [1.0, 0.0, 0.0].into());
    }
    for token in AnyToken::available() {
        let (mut tree, mut all) = (packet.clone(), packet.clone());
        bvh.intersect(token, &mut tree);
        bvh.intersect_all(token, &mut all);
        assert_eq!(tree.hits.primitive[..], all.hits.primitive[..], "{token:?}");
        assert!((0..64).all(|i| all.was_hit(i)), "{token:?}");
    }
}

/// Squares of smaller radii underflow, those of greater ones are infinite: such spheres were hit anywhere.
#[test]
fn spheres_whose_squared_radius_is_not_a_number_to_work_with_are_left_out() {
    let radii = [1e-40, 1e-20, 1e-8, 1e3, 1e18, 1e20];
    let bvh = Bvh::<SphereBlock>::spheres(radii.len(), 0, &Serial, |i| [0.0, 0.0, 0.0, radii[i]]);
    assert_eq!(bvh.primitives(), 3);
}

/// Rounding made distances such as 4e-13 of 0, at some levels and not at others: a ray hit the triangle that it starts on.
#[test]
fn a_ray_that_starts_on_a_triangle_does_not_hit_it() {
    let mut random = crate::common::Random(11);
    let mut near = 0;
    for round in 0..3000 {
        // Corners and weights of few bits: the origin is exactly on the triangle.
        let size = [1.0, 1e-3, 4096.0][round % 3];
        let corners = [0, 1, 2].map(|_| (random.point(64.0).round() / 4.0 * size).to_array());
        let [a, b, c] = corners.map(mobula_core::glam::Vec3::from);
        let (u, v) = (random.below(9) as f32 / 16.0, random.below(8) as f32 / 16.0);
        let exact = |k: usize| {
            let [a, b, c] = [a[k], b[k], c[k]].map(f64::from);
            a * f64::from(1.0 - u - v) + b * f64::from(u) + c * f64::from(v)
        };
        let origin = [0, 1, 2].map(|k| exact(k) as f32);
        if (0..3).any(|k| f64::from(origin[k]) != exact(k)) || (b - a).cross(c - a).length() == 0.0 {
            continue;
        }
        near += 1;
        let bvh = Bvh::<TriangleBlock>::triangles(1, 0, &Serial, |_| corners);
        let mut packet = RayPacket::<16>::default();
        packet.reset(0..16);
        for i in 0..16 {
            // Into all directions, some of them nearly in the triangle's plane.
            let within = (b - a) * (random.unit() - 0.5) + (c - a) * (random.unit() - 0.5);
            let direction = if i % 4 == 0 { within + random.point(1e-3 * size) } else { random.point(2.0) };
            packet.set_ray(i, origin.into(), direction);
        }
        for token in AnyToken::available() {
            for common in [Properties::empty(), Properties::COMMON_ORIGIN] {
                let mut packet = packet.clone();
                packet.promise(common);
                bvh.intersect(token, &mut packet);
                for i in 0..16 {
                    let (t, (_, direction)) = (packet.t_max[i], packet.ray(i));
                    // Nearly in the plane, or of a needle, what was rounded may be anywhere, but not at next to nothing.
                    let normal = (b - a).cross(c - a);
                    let fat = normal.length() > 0.1 * (b - a).length_squared().max((c - a).length_squared());
                    let steep = fat && normal.normalize().dot(direction.normalize()).abs() > 0.05;
                    let nothing = t * direction.abs().max_element() < 1e-7 * size;
                    let wrong = packet.was_hit(i) && (steep || nothing);
                    assert!(!wrong, "{token:?} {common:?} {corners:?} {:?}: {t:e}", packet.ray(i));
                }
            }
            for i in 0..16 {
                let (origin, direction) = packet.ray(i);
                let one = bvh.intersect_one(token, origin, direction, [0.0, f32::INFINITY]);
                let mut again = packet.clone();
                bvh.intersect(token, &mut again);
                assert_eq!(one, again.was_hit(i).then(|| (again.t_max[i], 0)), "{token:?}");
            }
        }
    }
    assert!(near > 1000, "{near}");
}

/// What is told apart from 0 is hit: a ray that starts right above a large floor.
#[test]
fn a_ray_that_starts_right_above_a_large_floor_hits_it() {
    let floor = [[-900.0, 0.0, -900.0], [900.0, 0.0, -900.0], [0.0, 0.0, 900.0]];
    let bvh = Bvh::<TriangleBlock>::triangles(1, 0, &Serial, |_| floor);
    for token in AnyToken::available() {
        for height in [1e-3f32, 1e-6, 1e-9, 1e-20, 1e-30] {
            let ray =
                |down: f32| bvh.intersect_one(token, [3.0, height, 5.0].into(), [0.3, down, 0.2].into(), [0.0, 9e9]);
            let (t, _) = ray(-1.0).unwrap_or_else(|| panic!("{token:?} {height:e}"));
            assert!((t - height).abs() <= 1e-6 * height, "{token:?} {height:e} {t:e}");
            assert_eq!(ray(1.0), None);
        }
    }
}

/// The way through the sphere, in lengths of the short direction, is more than a float holds: that was a hit at infinity, also of a
/// sphere behind the ray.
#[test]
fn a_sphere_behind_a_short_direction_is_not_hit_at_infinity() {
    let sphere = [-8.984_453e15, 5.536_204_7e16, -7.847_577e16, 1.664_158_5e18];
    let bvh = Bvh::<SphereBlock>::spheres(1, 0, &Serial, |_| sphere);
    for token in AnyToken::available() {
        let mut packet = RayPacket::<4>::default();
        packet.reset(0..4);
        for i in 0..4 {
            let origin = [-3.758_908_7e20, 3.398_099_6e10, 1.835_039e-16];
            packet.set_ray(i, origin.into(), [-0.001_474_890_5, -1.070_197_4e-10, 4.600_761_8e-23].into());
        }
        let (mut all, mut tree) = (packet.clone(), packet);
        bvh.intersect_all(token, &mut all);
        bvh.intersect(token, &mut tree);
        assert!((0..4).all(|i| !all.was_hit(i) && !tree.was_hit(i)), "{}", token.level());
    }
}
