//! What is far away costs the others nothing: boxes are widened by what their own coordinates and those of the ray ask for, not by
//! the farthest thing in the scene. Counted in primitives that are tested.

use std::cell::Cell;

use bytemuck::Zeroable;
use mobula_core::bvh::{Bvh, Quality, Serial};
use mobula_core::glam::Vec3;
use mobula_core::kernel::few::FewRays;
use mobula_core::kernel::group_shears::GroupShears;
use mobula_core::leaf::{BLOCK, Block, Bounds, TriangleBlock};
use mobula_core::simd::{AnyToken, Token};
use mobula_core::{Properties, RayPacket, Rays};

use crate::common::{Random, Triangle};

thread_local!(static TESTED: Cell<usize> = const { Cell::new(0) });

/// A block of triangles that counts what is asked of it, in vectors of rays.
#[derive(Clone, Copy, Debug, Zeroable)]
struct Counting(TriangleBlock);

fn count() {
    TESTED.with(|tested| tested.set(tested.get() + 1));
}

impl Block for Counting {
    type Primitive = Triangle;
    type Prepared = <TriangleBlock as Block>::Prepared;
    const EMPTY: Self = Self(TriangleBlock::EMPTY);
    const NOWHERE: Triangle = TriangleBlock::NOWHERE;

    fn bounds(primitive: &Triangle) -> Option<Bounds> {
        TriangleBlock::bounds(primitive)
    }

    fn set(&mut self, place: usize, id: u32, primitive: &Triangle) {
        self.0.set(place, id, primitive);
    }

    fn whole(&self) -> Bounds {
        self.0.whole()
    }

    fn ids(&self, number: usize) -> [u32; BLOCK] {
        self.0.ids(number)
    }

    fn prepare<const N: usize, const COMMON_ORIGIN: bool>(&self, rays: &Rays<N>) -> Self::Prepared {
        count();
        self.0.prepare::<N, COMMON_ORIGIN>(rays)
    }

    fn touched<T: Token, const N: usize>(
        token: T,
        prepared: &Self::Prepared,
        axis: usize,
        shears: &GroupShears,
    ) -> [u32; BLOCK] {
        TriangleBlock::touched::<T, N>(token, prepared, axis, shears)
    }

    fn test<T: Token, const N: usize, const COMMON_ORIGIN: bool, const OWN_AXES: bool>(
        token: T,
        prepared: &Self::Prepared,
        i: usize,
        axis: usize,
        rays: &Rays<N>,
        at: usize,
        among: T::Mask,
    ) -> (T::Mask, T::F32) {
        count();
        TriangleBlock::test::<T, N, COMMON_ORIGIN, OWN_AXES>(token, prepared, i, axis, rays, at, among)
    }

    fn test_few<T: Token>(&self, token: T, rays: &FewRays<T>, i: usize) -> (T::Mask, T::F32) {
        count();
        self.0.test_few(token, rays, i)
    }
}

/// A ball of radius 1 around a point, of some ten thousand triangles whose corners are what they are after `round`.
fn ball(around: Vec3, round: impl Fn(Vec3) -> Vec3) -> Vec<Triangle> {
    const RINGS: usize = 72;
    let point = |ring: usize, step: usize| {
        let (a, b) = (ring as f32 / RINGS as f32, step as f32 / RINGS as f32);
        let ((y, x), (s, c)) = ((a * std::f32::consts::PI).sin_cos(), (b * std::f32::consts::TAU).sin_cos());
        round(Vec3::new(y * c, x, y * s)) + around
    };
    let quads = (0..RINGS).flat_map(|ring| (0..RINGS).map(move |step| (ring, step)));
    quads
        .flat_map(|(i, j)| {
            let [a, b, c, d] =
                [point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)].map(|p| p.to_array());
            [[a, b, c], [a, c, d]]
        })
        .collect()
}

/// How many tests rays near `around` cost of each kind: from a camera, from the sun, from the surface into all directions.
fn costs(triangles: &[Triangle], quality: Quality, around: Vec3) -> [usize; 3] {
    let bvh = Bvh::<Counting>::build(triangles.len(), 0, quality, &Serial, |i| triangles[i]);
    [0, 1, 2].map(|kind| {
        let mut random = Random(7);
        TESTED.with(|tested| tested.set(0));
        for tile in 0..64 {
            let mut packet = RayPacket::<64>::default();
            packet.reset(0..64);
            for i in 0..64 {
                let [x, y] = [tile % 8 * 8 + i % 8, tile / 8 * 8 + i / 8].map(|x| x as f32 / 32.0 - 1.0);
                let (origin, direction) = match kind {
                    0 => (Vec3::new(0.3, 0.1, 4.0), Vec3::new(x * 0.3, y * 0.3, -1.0)),
                    1 => (Vec3::new(x, 2.0, y), Vec3::new(0.1, -1.0, 0.05)),
                    _ => {
                        let direction = random.point(2.0);
                        (Vec3::new(x, y, 0.1).normalize_or_zero() * 1.01, direction)
                    }
                };
                packet.set_ray(i, origin + around, direction);
            }
            if kind == 0 {
                packet.promise(Properties::COMMON_ORIGIN);
            }
            bvh.intersect(AnyToken::detect(), &mut packet);
        }
        TESTED.with(Cell::get)
    })
}

/// Panics if any kind of rays near `around` costs more than 1.4 times as much in the other scene, or `of_fast` in one that was built
/// fast.
fn is_no_dearer(what: &str, usual: &[Triangle], other: &[Triangle], around: Vec3, of_fast: f32) {
    for quality in [Quality::Good, Quality::Fast] {
        let (usual, other) = (costs(usual, quality, Vec3::ZERO), costs(other, quality, around));
        println!("{what} {quality:?}: {usual:?} {other:?}");
        for kind in 0..3 {
            let most = if quality == Quality::Fast { of_fast } else { 1.4 };
            let dear = other[kind] as f32 > most * usual[kind] as f32;
            assert!(!dear, "{what}, {quality:?}, rays {kind}: {usual:?} {other:?}");
        }
    }
}

#[test]
fn one_vertex_far_away_costs_the_others_nothing() {
    let ball = ball(Vec3::ZERO, |p| p);
    for far in [1e3, 1e5, 1e6, 1e12, 1e30] {
        for vertex in [[0.0, 0.0, far], [-far, far, -far], [0.0, far, 0.0]] {
            let mut other = ball.clone();
            other[4321][1] = vertex;
            is_no_dearer(&format!("a vertex at {vertex:?}"), &ball, &other, Vec3::ZERO, 1.3);
        }
    }
}

#[test]
fn a_ground_far_larger_than_all_on_it_costs_the_others_nothing() {
    let ball = ball(Vec3::ZERO, |p| p);
    for far in [1e3f32, 1e5, 1e7] {
        let ground = [[-far, -1.0, -far], [far, -1.0, -far], [0.0, -1.0, far]];
        let near = [&ball[..], &[[[-2.0, -1.0, -2.0], [2.0, -1.0, -2.0], [0.0, -1.0, 2.0]]]].concat();
        is_no_dearer(&format!("a ground of {far:e}"), &near, &[&ball[..], &[ground]].concat(), Vec3::ZERO, 1.3);
    }
}

#[test]
fn what_is_far_from_the_origin_costs_no_more_than_at_it() {
    for offset in [1e2f32, 1e4, 1e5] {
        let offset = Vec3::new(offset, -0.7 * offset, 0.2 * offset);
        // The same corners, as far as numbers go there.
        let round = |p: Vec3| (p + offset) - offset;
        is_no_dearer(&format!("at {offset}"), &ball(Vec3::ZERO, round), &ball(offset, round), offset, 1.3);
    }
}

#[test]
fn one_of_two_apart_costs_no_more_than_alone() {
    let offset = Vec3::new(200.0, 0.0, 20.0);
    let round = |p: Vec3| (p + offset) - offset;
    let alone = ball(Vec3::ZERO, round);
    let both = [alone.clone(), ball(offset, round)].concat();
    for around in [Vec3::ZERO, offset] {
        // The curve has fewer cells for each. Where few rays come to a leaf they are counted by as many as share a vector with four
        // primitives, with four lanes one by one: this is what they need, a part of which whole vectors hide.
        is_no_dearer(&format!("two, at {around}"), &alone, &both, around, 2.2);
    }
}
