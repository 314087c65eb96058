//! Clouds: what is cropped is not there, whoever asks; what is left is hit as if it were alone.

use mobula_core::bvh::{Quality, Serial};
use mobula_core::cloud::{Cloud, Crop, Values};
use mobula_core::glam::Vec3;
use mobula_core::simd::AnyToken;
use mobula_core::traverse::{intersect, intersect_all, occlude};
use mobula_core::{AnyHitPacket, NO_HIT, RayPacket};

const N: usize = 64;

fn noise(i: u32) -> f32 {
    let x = i.wrapping_mul(0x9e37_79b9) ^ 0x5bd1_e995;
    let x = (x ^ x >> 15).wrapping_mul(0x85eb_ca6b);
    let x = (x ^ x >> 13).wrapping_mul(0xc2b2_ae35);
    ((x ^ x >> 16) >> 8) as f32 / (1 << 24) as f32
}

fn sphere(i: usize) -> [f32; 4] {
    let i = 4 * i as u32;
    [noise(i), noise(i + 1), noise(i + 2), 0.005 + 0.03 * noise(i + 3)]
}

/// A speed, some of them no numbers or infinite, that goes with the place; and a kind.
fn values(count: usize) -> (Vec<f32>, Vec<u8>) {
    let speed = (0..count).map(|i| match i % 41 {
        0 => f32::NAN,
        1 => f32::INFINITY,
        _ => sphere(i)[0] * 8.0 + noise(7 * i as u32),
    });
    (speed.collect(), (0..count).map(|i| (i % 5) as u8).collect())
}

fn cloud(count: usize, quality: Quality) -> Cloud {
    let (speed, kind) = values(count);
    Cloud::build(count, quality, &Serial, sphere, vec![Values::F32(speed), Values::U8(kind)])
}

fn rays(seed: u32, common: bool) -> Box<RayPacket<N>> {
    let mut packet = Box::<RayPacket<N>>::default();
    packet.reset(0..N);
    for i in 0..N {
        let at = |k: u32| noise(seed + 6 * i as u32 + k);
        let origin = if common { Vec3::new(-1.0, 0.4, 0.6) } else { Vec3::new(at(0) - 1.0, at(1), 2.0 * at(2)) };
        packet.set_ray(i, origin, Vec3::new(at(3), at(4), at(5)) - origin);
        packet.set_interval(i, 0.0, f32::INFINITY);
    }
    packet
}

/// Whether a sphere of a speed and a kind is shown.
type Shows = fn(f32, u8) -> bool;

/// The crops of the tests, and what they show.
fn crops() -> Vec<(Vec<Crop>, Shows)> {
    let speed = |ranges: &[[f32; 2]]| Crop { attribute: 0, ranges: ranges.to_vec() };
    let kind = |ranges: &[[f32; 2]]| Crop { attribute: 1, ranges: ranges.to_vec() };
    vec![
        (vec![], |_, _| true),
        (vec![speed(&[[2.0, 2.5]])], |speed, _| (2.0..=2.5).contains(&speed)),
        (vec![speed(&[[f32::NEG_INFINITY, f32::INFINITY]])], |speed, _| !speed.is_nan()),
        (vec![speed(&[[8.9, f32::INFINITY], [f32::NEG_INFINITY, 0.5]])], |speed, _| speed >= 8.9 || speed <= 0.5),
        (vec![kind(&[[3.0, 3.0]])], |_, kind| kind == 3),
        (vec![kind(&[[0.0, 0.5], [1.5, 255.0]]), speed(&[[1.0, 7.0]])], |speed, kind| {
            kind != 1 && (1.0..=7.0).contains(&speed)
        }),
        (vec![speed(&[[100.0, 200.0]])], |speed, _| (100.0..=200.0).contains(&speed)),
        (vec![speed(&[[3.0, 2.0]])], |_, _| false),
        (vec![speed(&[[f32::NAN, 2.0]])], |_, _| false),
        (vec![speed(&[])], |_, _| false),
        (vec![Crop { attribute: 2, ranges: vec![[f32::MIN, f32::MAX]] }], |_, _| false),
    ]
}

#[test]
fn what_is_cropped_is_not_there() {
    for (count, quality) in
        [(3000, Quality::Good), (3001, Quality::Fast), (9, Quality::Good), (3, Quality::Good), (0, Quality::Good)]
    {
        let cloud = cloud(count, quality);
        assert_eq!(cloud.len(), count);
        let speed = |place: usize| cloud.value(0, place);
        for (crops, shows) in crops() {
            // The same spheres alone, in the order of their places.
            let places: Vec<usize> = (0..cloud.places())
                .filter(|&place| cloud.sphere(place).is_some() && shows(speed(place), cloud.value(1, place) as u8))
                .collect();
            let alone = Cloud::build(places.len(), quality, &Serial, |i| cloud.sphere(places[i]).unwrap(), vec![]);
            let (ready, none) = (cloud.crops(&crops), alone.crops(&[]));
            for token in AnyToken::available() {
                for seed in 0..6 {
                    let rays = rays(seed * 1000, seed % 2 == 0);
                    let mut found = rays.clone();
                    intersect(&cloud.shown(&ready), token, &mut found);
                    let mut all = rays.clone();
                    intersect_all(&cloud.shown(&ready), token, &mut all);
                    let mut expected = rays.clone();
                    intersect(&alone.shown(&none), token, &mut expected);
                    let mut any = Box::<AnyHitPacket<N>>::default();
                    any.reset(0..N);
                    for i in 0..N {
                        let row =
                            |columns: &mobula_core::Columns3<N>| Vec3::new(columns[0][i], columns[1][i], columns[2][i]);
                        any.set_ray(i, row(rays.origins()), row(rays.directions()));
                        any.set_interval(i, 0.0, f32::INFINITY);
                    }
                    occlude(&cloud.shown(&ready), token, &mut any, None);
                    for i in 0..N {
                        let bits = |packet: &RayPacket<N>| (packet.t_max[i].to_bits(), packet.hits.primitive[i]);
                        assert_eq!(bits(&found), bits(&all), "with and without the tree");
                        assert_eq!(found.t_max[i].to_bits(), expected.t_max[i].to_bits());
                        let (id, other) = (found.hits.primitive[i], expected.hits.primitive[i]);
                        assert_eq!(id == NO_HIT, other == NO_HIT);
                        if id != NO_HIT {
                            assert_eq!(cloud.sphere(id as usize), alone.sphere(other as usize));
                            assert!(places.contains(&(id as usize)));
                        }
                        assert_eq!(any.occluded(i), id != NO_HIT);
                    }
                }
            }
        }
    }
}

#[test]
fn values_go_with_their_spheres() {
    let (count, (speed, kind)) = (2000, values(2000));
    for quality in [Quality::Good, Quality::Fast] {
        let cloud = cloud(count, quality);
        let mut met = vec![false; count];
        for place in 0..cloud.places() {
            let Some(found) = cloud.sphere(place) else { continue };
            let number = (0..count).find(|&i| sphere(i) == found).unwrap();
            assert!(!std::mem::replace(&mut met[number], true), "twice");
            assert_eq!(cloud.value(0, place).to_bits(), speed[number].to_bits());
            assert_eq!(cloud.value(1, place), f32::from(kind[number]));
        }
        assert!(met.into_iter().all(|met| met));
        let finite = || speed.iter().copied().filter(|speed| speed.is_finite());
        let ends = [finite().fold(f32::INFINITY, f32::min), finite().fold(f32::NEG_INFINITY, f32::max)];
        assert_eq!((cloud.range(0), cloud.range(1), cloud.range(2)), (Some(ends), Some([0.0, 4.0]), None));
    }
}

#[test]
fn clouds_are_small_and_bad_spheres_are_left_out() {
    let count = 40_000;
    let speeds = || Values::F32((0..count).map(|i| noise(i as u32)).collect());
    for (quality, most) in [(Quality::Good, 34.0), (Quality::Fast, 36.0)] {
        let cloud = Cloud::build(count, quality, &Serial, sphere, vec![speeds()]);
        let each = cloud.bytes() as f64 / count as f64;
        assert!(each < most, "{quality:?}: {each} bytes a sphere");
        assert!(cloud.places() < count + 4, "blocks are full");
    }
    let bad = |i: usize| match i % 10 {
        0 => [f32::NAN, 0.0, 0.0, 1.0],
        1 => [0.0, 0.0, 0.0, -1.0],
        _ => sphere(i),
    };
    let cloud = Cloud::build(1000, Quality::Good, &Serial, bad, vec![Values::U8(vec![7; 1000])]);
    assert_eq!((cloud.len(), cloud.places()), (800, 800));
    assert_eq!(cloud.range(0), Some([7.0; 2]));
}
