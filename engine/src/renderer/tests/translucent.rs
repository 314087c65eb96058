//! Particles that are opaque in part: what is seen behind them, and their shadows.

use super::*;
use crate::geometry::{Cloud, Coloring, Opacity, OpacityCurve, Particles};
use crate::math::{hash, unit};
use crate::particles::{Attribute, ParticleStep, Values};
use crate::volume::{ColorMap, Preset};

/// A height over the origin, a radius, and the opacity, which is an attribute.
type Ball = (f32, f32, f32);

fn cloud(centers: Vec<[f32; 3]>, radii: Vec<f32>, opacities: Vec<f32>, kind: AccelerationKind) -> Particles {
    let attributes = vec![Attribute { name: "opacity".to_owned(), values: Values::F32(opacities) }];
    let step = ParticleStep { centers, radii, attributes, ..ParticleStep::default() };
    let mut particles = Particles::new("", vec![Arc::new(Cloud::new(step, 1.0, &kind.into()).unwrap())], 1);
    particles.opacity = Opacity::By { attribute: "opacity".to_owned(), curve: OpacityCurve::rising([0.0, 1.0]) };
    particles
}

fn balls(balls: &[Ball]) -> Particles {
    let (centers, rest): (Vec<_>, Vec<_>) = balls.iter().map(|&(y, r, a)| ([0.0, y, 0.0], (r, a))).unzip();
    let (radii, opacities) = rest.into_iter().unzip();
    cloud(centers, radii, opacities, AccelerationKind::Bvh)
}

/// These particles over a floor of one brightness, themselves of another.
fn over_floor(particles: Particles, [own, below]: [f32; 2]) -> SceneDescription {
    let mut scene = stage(vec![floor(0.0, 0), Arc::new(particles)], Flat::new(Vec3::splat(own)));
    scene.materials[0].material = Arc::new(Flat::new(Vec3::splat(below)));
    scene
}

#[test]
fn what_is_behind_counts_by_what_is_left_in_front() {
    // The second and the third overlap; the fourth is not there at all, and the last one hides what is below it.
    let all = [(3.0, 0.2, 0.25), (2.0, 0.4, 0.5), (1.6, 0.3, 0.125), (1.2, 0.1, 0.0), (0.8, 0.2, 1.0), (0.4, 0.1, 0.5)];
    let map = Arc::new(ColorMap::new(&Preset::CoolWarm.function([0.0, 1.0]), [0.0, 1.0]));
    for count in 0..=all.len() {
        let mut particles = balls(&all[..count]);
        particles.coloring = Some(Coloring { attribute: "opacity".to_owned(), map: Arc::clone(&map) });
        let expected = all[..count]
            .iter()
            .rev()
            .fold(0.3, |behind, &(_, _, opacity)| opacity * 0.9 * map.color(opacity)[0] + (1.0 - opacity) * behind);
        let scene = over_floor(particles, [0.9, 0.3]);
        for width in [1, 16, 64] {
            let seen = middle(&render(width, &scene, PLAIN).0);
            assert!(seen.abs_diff(byte(expected)) <= 1, "{count} particles: {seen} is not {}", byte(expected));
        }
    }
}

#[test]
fn opacity_of_all_is_that_of_each() {
    let mut particles = balls(&[(3.0, 0.2, 1.0), (2.0, 0.4, 1.0)]);
    particles.opacity = Opacity::All(0.25);
    let seen = middle(&render(16, &over_floor(particles, [0.8, 0.1]), PLAIN).0);
    assert!(seen.abs_diff(byte(0.8 * 0.4375 + 0.1 * 0.5625)) <= 1, "{seen}");
}

#[test]
fn thousands_of_layers_are_seen_through() {
    let many: Vec<Ball> = (0..2000).map(|i| (0.01 + 0.001 * i as f32, 0.0003, 0.002)).collect();
    let left = 0.998_f32.powi(2000);
    let seen = middle(&render(16, &over_floor(balls(&many), [0.2, 1.0]), PLAIN).0);
    assert!(seen.abs_diff(byte(0.2 * (1.0 - left) + left)) <= 1, "{seen}");
}

#[test]
fn fog_is_between_the_layers() {
    let (density, bright) = (0.2_f32, 0.7);
    let through = |length: f32, behind: f32| {
        let through = (-density * length).exp();
        bright * (1.0 - through) + through * behind
    };
    let mut scene = over_floor(balls(&[(2.5, 0.5, 0.5), (0.5, 0.5, 0.25)]), [0.4, 0.1]);
    scene.media = vec![Arc::new(Fog { density, color: Vec3::splat(bright) })];
    let lower = through(2.0, 0.25 * 0.4 + 0.75 * through(1.0, 0.1));
    let expected = byte(through(2.0, 0.5 * 0.4 + 0.5 * lower));
    let seen = middle(&render(16, &scene, PLAIN).0);
    assert!(seen.abs_diff(expected) <= 1, "{seen} is not {expected}");
}

#[test]
fn shadows_are_as_deep_as_particles_and_their_material_are_opaque() {
    // Behind the eye, in the way of the light.
    for (above, material, expected) in [
        (&[(9.0, 0.5, 0.25)][..], 1.0, 0.75),
        (&[(9.0, 0.5, 0.25), (8.5, 0.5, 0.5)], 1.0, 0.375),
        (&[(9.0, 0.5, 0.0)], 1.0, 1.0),
        (&[(9.0, 0.5, 0.25), (8.5, 0.5, 1.0)], 1.0, 0.0),
        (&[(9.0, 0.5, 0.5)], 0.5, 0.75),
        (&[(9.0, 0.5, 1.0)], 0.5, 0.5),
    ] {
        let glass = Phong { transparency: 1.0 - material, ..Phong::default() };
        let scene = stage(vec![floor(0.0, 0), Arc::new(balls(above))], glass);
        for width in [1, 16, 64] {
            assert_eq!(middle(&render(width, &scene, PLAIN).0), byte(expected), "{above:?} of {material}");
        }
    }
}

#[test]
fn one_picture_through_many_particles() {
    let random = |i: u32, k: u32| unit(hash(4 * i + k));
    let picture = |kind, width, fragment| {
        let centers = (0..300).map(|i| [0, 1, 2].map(|k| 3.0 * random(i, k) - 1.5)).collect();
        let radii = (0..300).map(|i| 0.05 + 0.3 * random(i, 3)).collect();
        let opacities = (1000..1300).map(|i| random(i, 0)).collect();
        let glass = Phong { transparency: 0.25, ..Phong::default() };
        let scene = stage(vec![floor(-1.0, 0), Arc::new(cloud(centers, radii, opacities, kind)), pane(2.0)], glass);
        let (picture, statistics) = render(width, &scene, How { kind, fragment, ..PLAIN });
        (picture, [statistics.primary.get(), statistics.shadow.get(), statistics.secondary.get()])
    };
    let first = picture(AccelerationKind::Bvh, 64, 1000);
    assert!(first.1[2] > 5 * first.1[0], "rays go on: {:?}", first.1);
    for width in [1, 4, 7, 16, 256] {
        assert!(picture(AccelerationKind::Bvh, width, 1000) == first, "{width} rays");
    }
    assert!(picture(AccelerationKind::Bvh, 64, 5) == first, "fragments");
    assert!(picture(AccelerationKind::Fast, 64, 1000) == first, "another tree");
    assert!(picture(AccelerationKind::Brute, 64, 1000) == first, "no tree");
}
