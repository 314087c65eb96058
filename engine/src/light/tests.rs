//! What arrives from lights with extent, against what is known in closed form.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;
use mobula_core::simd::AnyToken;

use super::{Disk, Head, Light, LightKind, Point, Rectangle, Sphere, Spot, Sun};
use crate::accel::AccelerationKind;
use crate::math::hash;
use crate::packet::vec3;
use crate::renderer::RendererKind;
use crate::scene::{SceneDescription, build};
use crate::scratch::ForWidth;
use crate::stack::{Context, Illumination, Receivers, Statistics};
use crate::tone::Tone;

/// What the light is for points, one row each: the first `count` samples of pixel `seed`. Directions, radiance and distances.
fn arrives(light: &dyn Light, token: AnyToken, points: &[Vec3], seed: u32) -> Vec<(Vec3, Vec3, f32)> {
    let scene = build(&SceneDescription::default(), AccelerationKind::Bvh).unwrap();
    let (renderer, statistics) = (RendererKind::Raytracer.build(), Statistics::default());
    let (tone, eye) = (Tone::default(), Some(Vec3::Y * 7.0));
    let context = Context {
        token,
        width: 1024,
        scene: &scene,
        renderer: &*renderer,
        statistics: &statistics,
        tone,
        eye,
        frame: 0,
    };
    let mut out = Illumination::for_width(1024);
    let (seeds, numbers): (Vec<u32>, Vec<u32>) = (0..points.len() as u32).map(|i| (hash(seed), i)).unzip();
    let columns = [0, 1, 2].map(|axis| points.iter().map(|point| point[axis]).collect::<Vec<f32>>());
    let positions = columns.each_ref().map(|column| &column[..]);
    light.illuminate(&context, Receivers::with_samples(positions, [&seeds, &numbers], 1, 0), &mut out);
    (0..points.len()).map(|i| (vec3(&out.direction, i), vec3(&out.radiance, i), out.distance[i])).collect()
}

/// What a white surface at the origin that faces along `normal` scatters, by so many samples of a pixel.
fn scattered(light: &dyn Light, normal: Vec3, samples: usize, seed: u32) -> f32 {
    let rows = arrives(light, AnyToken::detect(), &vec![Vec3::ZERO; samples], seed);
    rows.iter().map(|(direction, radiance, _)| radiance.x * direction.dot(normal).max(0.0)).sum::<f32>()
        / samples as f32
}

/// The part of what a point sees, by the cosine, that is a rectangle of width `a` and height `b` at distance 1 which starts above it.
fn corner(a: f32, b: f32) -> f32 {
    let part = |a: f32, b: f32| {
        let far = (1.0 + a * a).sqrt();
        a / far * (b / far).atan()
    };
    0.5 * FRAC_1_PI * (part(a, b) + part(b, a))
}

#[test]
fn the_mean_of_samples_is_what_is_known_of_disks_spheres_and_rectangles() {
    let color = Vec3::splat(3.0);
    let down = Vec3::NEG_Y;
    let at = Vec3::Y * 2.0;
    let tilted = Vec3::new(0.6, 0.8, 0.0);
    let cases: [(&dyn Light, Vec3, f32); 7] = [
        (&Disk { position: at, direction: down, radius: 0.5, color }, Vec3::Y, 0.25 / 4.25),
        (&Disk { position: at, direction: down, radius: 3.0, color }, Vec3::Y, 9.0 / 13.0),
        (&Sphere { position: at, radius: 0.5, color }, Vec3::Y, 0.25 / 4.0),
        (&Sphere { position: at, radius: 1.99, color }, Vec3::Y, 1.99 * 1.99 / 4.0),
        // All of it above the horizon: the cosine of the middle counts.
        (&Sphere { position: at, radius: 0.5, color }, tilted, 0.8 * 0.25 / 4.0),
        (
            &Rectangle { position: at, direction: down, up: Vec3::Z, size: [2.0, 4.0], color },
            Vec3::Y,
            4.0 * corner(0.5, 1.0),
        ),
        (&Sun { direction: Vec3::Y * 2.0, color, angle: 0.53 }, tilted, 0.8),
    ];
    for (light, normal, expected) in cases {
        let expected = expected * 3.0;
        let errors = [16, 1024].map(|samples| {
            (0..8).map(|seed| (scattered(light, normal, samples, seed) / expected - 1.0).abs()).fold(0.0, f32::max)
        });
        assert!(errors[0] < 0.2 && errors[1] < 4e-3, "{light:?}: {errors:?} of {expected}");
    }
}

#[test]
fn samples_lie_on_the_light_and_two_lights_choose_differently() {
    let sphere = Sphere { position: Vec3::Y * 2.0, radius: 0.5, color: Vec3::ONE };
    for (direction, _, distance) in arrives(&sphere, AnyToken::detect(), &[Vec3::ZERO; 64], 3) {
        let point = direction * distance;
        assert!((point.distance(sphere.position) - 0.5).abs() < 1e-3 && point.y < 2.0, "{point}");
    }
    let rectangle =
        Rectangle { position: Vec3::Y, direction: Vec3::NEG_Y, up: Vec3::Z, size: [1.0, 2.0], color: Vec3::ONE };
    let mut boxes = [0; 16];
    for (direction, _, distance) in arrives(&rectangle, AnyToken::detect(), &[Vec3::ZERO; 16], 5) {
        let point = direction * distance;
        assert!((point.y - 1.0).abs() < 1e-6 && point.x.abs() <= 0.5 && point.z.abs() <= 1.0, "{point}");
        boxes[((point.x + 0.5) * 4.0) as usize + 4 * ((point.z + 1.0) * 2.0) as usize] += 1;
    }
    assert_eq!(boxes, [1; 16], "16 samples of a pixel are one in each box");
}

#[test]
fn a_spot_is_bright_inside_dark_outside_and_smooth_between() {
    let spot =
        Spot { position: Vec3::Y, direction: Vec3::NEG_Y, color: Vec3::ONE, inner: 30.0, outer: 60.0, falloff: false };
    let at = |degrees: f32| Vec3::X * degrees.to_radians().tan();
    let points: Vec<Vec3> = [0.0, 29.0, 35.0, 45.0, 55.0, 61.0].map(at).into();
    let found: Vec<f32> = arrives(&spot, AnyToken::detect(), &points, 0).iter().map(|row| row.1.x).collect();
    assert_eq!((found[0], found[1], found[5]), (1.0, 1.0, 0.0));
    assert!(found.windows(2).all(|two| two[0] >= two[1]) && found[3] > 0.2 && found[3] < 0.8, "{found:?}");
    let falloff = Spot { falloff: true, position: Vec3::Y * 2.0, ..spot };
    assert_eq!(arrives(&falloff, AnyToken::detect(), &[Vec3::ZERO], 0)[0].1, Vec3::splat(0.25));
}

#[test]
fn the_light_of_the_camera_is_at_the_eye() {
    let head = arrives(&Head::default(), AnyToken::detect(), &[Vec3::ZERO, Vec3::X], 0);
    let point = Point { position: Vec3::Y * 7.0, ..Point::KEY };
    assert_eq!(head, arrives(&point, AnyToken::detect(), &[Vec3::ZERO, Vec3::X], 0));
}

/// Whatever lights and points are: a unit direction and a finite radiance, or none; and all levels agree.
#[test]
fn odd_lights_and_points_give_light_or_none() {
    let odd = [0.0, -0.0, 1.0, -2.0, 1e-30, 1e30, f32::MAX, f32::INFINITY, f32::NAN];
    let mut lights: Vec<Box<dyn Light>> = Vec::new();
    for x in odd {
        for y in odd {
            let (position, direction, color) = (Vec3::new(x, 1.0, 0.0), Vec3::new(y, x, 0.0), Vec3::ONE);
            lights.push(Box::new(Rectangle { position, direction, up: direction, size: [x, y], color }));
            lights.push(Box::new(Disk { position, direction, radius: y, color }));
            lights.push(Box::new(Sphere { position, radius: y, color }));
            lights.push(Box::new(Sun { direction, color, angle: y }));
            lights.push(Box::new(Spot { position, direction, color, inner: y, outer: x, falloff: true }));
        }
    }
    let points: Vec<Vec3> = odd.iter().flat_map(|&x| [Vec3::splat(x), Vec3::Y * x]).collect();
    for light in &lights {
        let expected = arrives(&**light, AnyToken::detect(), &points, 0);
        for (row, point) in expected.iter().zip(&points) {
            let (direction, radiance, _) = *row;
            let length = direction.length();
            let right =
                radiance.is_finite() && radiance.min_element() >= 0.0 && ((length - 1.0).abs() < 1e-3 || length == 0.0);
            assert!(right || radiance == Vec3::ZERO, "{light:?} at {point}: {row:?}");
            assert!(length.is_finite(), "{light:?} at {point}: {row:?}");
        }
        for token in AnyToken::available() {
            let found = arrives(&**light, token, &points, 0);
            let bits = |rows: &[(Vec3, Vec3, f32)]| -> Vec<u32> {
                let each =
                    |(d, r, t): &(Vec3, Vec3, f32)| [d.x, d.y, d.z, r.x, r.y, r.z, if t.is_nan() { 0.0 } else { *t }];
                rows.iter().flat_map(each).map(f32::to_bits).collect()
            };
            assert!(bits(&found) == bits(&expected), "{light:?}: {}", token.level());
        }
    }
}

#[test]
fn every_kind_lights_what_is_below_it() {
    for kind in LightKind::ALL {
        let light = kind.build();
        let brightness = scattered(&*light, if *kind == LightKind::Point { Vec3::ZERO } else { Vec3::Y }, 64, 0);
        assert!(*kind == LightKind::Point || (0.5..1.5).contains(&brightness), "{kind}: {brightness}");
    }
}
