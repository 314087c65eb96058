//! Outlines dismiss no group of rays that has one which the test of a sphere finds, and keep few groups that have none: spheres from dust to
//! suns, near and far, around the origin and touching it, rays at their rims, from one point and parallel.

use crate::common::Random;
use mobula_core::glam::Vec3;
use mobula_core::kernel::frusta::Frusta;
use mobula_core::kernel::group_bounds::{GroupBounds, MIXED};
use mobula_core::kernel::margin::Frame;
use mobula_core::leaf::{BLOCK, Block, SphereBlock};
use mobula_core::simd::{AnyToken, MaskLanes, Task, Token};
use mobula_core::{Properties, Rays};

/// Rays in a group.
const GROUP: usize = 16;

/// Pairs of a group and a sphere that were tested, that have a ray which hits, that may be hit, and that were wrongly dismissed.
#[derive(Clone, Copy, Debug, Default)]
struct Counts {
    tested: u32,
    found: u32,
    kept: u32,
    lost: u32,
}

struct Compare<'a, const N: usize, const COMMON_ORIGIN: bool> {
    rays: &'a mut Rays<N>,
    frame: &'a Frame,
    block: &'a SphereBlock,
    counts: &'a mut Counts,
}

impl<const N: usize, const COMMON_ORIGIN: bool> Task for Compare<'_, N, COMMON_ORIGIN> {
    type Output = ();

    #[inline(always)]
    fn run<T: Token>(self, token: T) {
        self.rays.shears(token);
        let rays = &*self.rays;
        let bounds = GroupBounds::new::<T, N, COMMON_ORIGIN>(token, rays, self.frame);
        let prepared = self.block.prepare::<N, COMMON_ORIGIN>(rays);
        let mut left: u32 = (1 << (N / GROUP)) - 1;
        while left != 0 {
            let first = left.trailing_zeros() as usize;
            let class = bounds.class(first);
            if class == MIXED {
                left &= left - 1;
                continue;
            }
            let groups = bounds.of_class(class);
            left &= !groups;
            let frusta = Frusta::new::<T, N, COMMON_ORIGIN>(token, &bounds, rays, class);
            let Some(shears) = frusta.shears() else { continue };
            let touched = <SphereBlock>::touched::<T, N>(token, &prepared, frusta.axis(), shears);
            for (i, touched) in touched.into_iter().enumerate() {
                let (mut found, mut at) = (0u32, 0);
                while at < N {
                    let all = token.mask(u32::MAX);
                    let (hit, _) = <SphereBlock>::test::<T, N, COMMON_ORIGIN, false>(
                        token,
                        &prepared,
                        i,
                        frusta.axis(),
                        rays,
                        at,
                        all,
                    );
                    // Lanes of 1 to 16 are of one group.
                    found |= u32::from(hit.any()) << (at / GROUP);
                    at += T::LANES;
                }
                let (found, kept) = (found & groups, touched & groups);
                self.counts.tested += groups.count_ones();
                self.counts.found += found.count_ones();
                self.counts.kept += kept.count_ones();
                self.counts.lost += (found & !kept).count_ones();
            }
        }
    }
}

/// 10 to a power between these.
fn power(random: &mut Random, least: f32, greatest: f32) -> f32 {
    10f32.powf(least + random.unit() * (greatest - least))
}

/// Of length 1, and any direction.
fn direction(random: &mut Random) -> Vec3 {
    random.point(2.0).normalize_or(Vec3::Y)
}

/// A point of the rim of a sphere that is seen along a direction, or just inside or outside of it, or anywhere on the sphere.
fn aim(random: &mut Random, [x, y, z, radius]: [f32; 4], along: Vec3) -> Vec3 {
    let rim = along.cross(direction(random)).normalize_or(Vec3::Z);
    let off = random.pick(&[1.0, 1.0 - 1e-6, 1.0 + 1e-6, 1.0 - 1e-3, 0.5, 0.0]);
    Vec3::new(x, y, z) + if random.below(8) == 0 { direction(random) } else { rim * off } * radius
}

/// Four spheres around a point, and a packet whose groups each look at the rim of one of them. Also whether rounding does not blur the
/// spheres: those that are not a thousand times smaller than they are far.
fn draw<const N: usize>(random: &mut Random, common_origin: bool) -> (Rays<N>, Frame, [[f32; 4]; BLOCK], bool) {
    let shift = random.pick(&[0.0, 1.0, 1e3, 1e6]);
    let middle = random.point(2.0 * shift);
    let (radius, distance) = (power(random, -8.0, 4.0), power(random, -4.0, 5.0));
    let ahead = direction(random);
    let eye = middle - ahead * distance;
    let spread = power(random, -2.0, 1.0) * radius;
    let spheres = [(); BLOCK].map(|()| {
        let radius = radius * power(random, -1.0, 0.0);
        let center = match random.below(12) {
            // Around the eye, touching it from either side, behind it.
            0 => eye + direction(random) * radius * 0.5,
            1 => eye + direction(random) * radius * random.pick(&[1.0 - 1e-6, 1.0, 1.0 + 1e-6]),
            2 => eye - ahead * distance,
            _ => middle + random.point(2.0 * spread),
        };
        [center.x, center.y, center.z, radius]
    });
    let mut rays = Rays::<N>::default();
    rays.reset(0..N, Properties::empty());
    let unit = random.below(2) == 0;
    let mut group = [(eye, ahead); GROUP];
    for i in 0..N {
        if i % GROUP == 0 {
            // One ray at a rim, the others beside it: the rim is at the border of the group.
            let sphere = random.pick(&spheres);
            let to = aim(random, sphere, ahead);
            let beside = random.pick(&[0.0, 1e-4, 0.1]) * radius;
            let outwards = (to - middle).normalize_or(Vec3::X) * beside;
            let first = random.below(GROUP);
            for (k, ray) in group.iter_mut().enumerate() {
                let to = if k == first { to } else { to + outwards * random.unit() };
                *ray = if common_origin { (eye, to - eye) } else { (to - ahead * distance, ahead) };
            }
        }
        let (origin, along) = group[i % GROUP];
        rays.set_ray(i, origin, if unit { along.normalize_or(Vec3::X) } else { along });
    }
    let mut known = Properties::empty();
    known.set(Properties::COMMON_ORIGIN, common_origin);
    known.set(Properties::NORMALIZED_DIRECTIONS, unit);
    rays.promise(known);
    let center = random.pick(&[Vec3::ZERO, middle, eye]).to_array();
    let frame = Frame { center, size: spread, farthest: shift + distance + spread };
    (rays, frame, spheres, radius > 1e-2 * (shift + distance))
}

fn compare<const N: usize, const COMMON_ORIGIN: bool>(token: AnyToken, seeds: u64) {
    let (mut blurred, mut clear) = (Counts::default(), Counts::default());
    for seed in 0..seeds {
        let (mut rays, frame, spheres, is_clear) = draw::<N>(&mut Random(seed ^ 0x9e37_79b9_7f4a_7c15), COMMON_ORIGIN);
        let counts = if is_clear { &mut clear } else { &mut blurred };
        let mut block = SphereBlock::EMPTY;
        for (i, sphere) in spheres.iter().enumerate() {
            block.set(i, i as u32, sphere);
        }
        let task = Compare::<N, COMMON_ORIGIN> { rays: &mut rays, frame: &frame, block: &block, counts };
        token.run(task);
        assert_eq!(counts.lost, 0, "{token:?}, seed {seed}: rays were dismissed that hit one of {spheres:?}");
    }
    assert!(blurred.found > blurred.tested / 16 && clear.found > clear.tested / 16, "{blurred:?} {clear:?}");
    // Rays at rims are off by rounding either way.
    assert!(clear.kept - clear.found < (clear.tested - clear.found) / 3, "{clear:?}");
}

#[test]
fn outlines_from_a_point_dismiss_nothing_that_is_hit() {
    for token in AnyToken::available() {
        compare::<64, true>(token, 10_000);
        compare::<256, true>(token, 3_000);
    }
}

#[test]
fn outlines_of_parallel_rays_dismiss_nothing_that_is_hit() {
    for token in AnyToken::available() {
        compare::<64, false>(token, 10_000);
        compare::<256, false>(token, 3_000);
    }
}
