//! White surfaces in white light: what comes from everywhere with a radiance of 1 leaves them with 1, at every angle and roughness.

use std::sync::Arc;

use glam::Vec3;
use mobula_core::Properties;
use mobula_core::simd::AnyToken;

use super::floor;
use crate::accel::AccelerationKind;
use crate::background::Constant;
use crate::light::{Directional, Hemisphere, Light};
use crate::material::{
    Checker, Dielectric, Flat, Lambertian, Material, MaterialKind, Metal, NamedMaterial, OrenNayar, Phong, Principled,
    ThinDielectric, Wireframe,
};
use crate::packet::{Packet, set_vec3, vec3};
use crate::renderer::{Raytracer, Renderer};
use crate::scene::{Scene, SceneDescription, build};
use crate::stack::{Context, Statistics};
use crate::tone::Tone;

/// What a material returns of the light.
#[derive(Clone, Copy, PartialEq)]
enum Claim {
    /// All of it, of lights too.
    All,
    /// All of what is around, which it mirrors or lets through; lights have no part in that.
    Surroundings,
    /// Light does not change it.
    Unlit,
}

const ROUGHNESS: [f32; 6] = [0.0, 0.05, 0.3, 0.5, 0.75, 1.0];
const COSINES: [f32; 5] = [1.0, 0.8, 0.5, 0.2, 0.1];

/// White surfaces of a kind; a new kind has to be added.
fn white(kind: MaterialKind) -> Vec<(Arc<dyn Material>, Claim)> {
    let one = Vec3::ONE;
    let rough = |make: &dyn Fn(f32) -> Arc<dyn Material>| -> Vec<(Arc<dyn Material>, Claim)> {
        ROUGHNESS
            .map(|roughness| (make(roughness), if roughness < 0.2 { Claim::Surroundings } else { Claim::All }))
            .into()
    };
    match kind {
        MaterialKind::Lambertian => vec![(Arc::new(Lambertian::new(one)), Claim::All)],
        MaterialKind::Phong => {
            let matt = Phong { diffuse: one, ..Phong::default() };
            let mirror = Phong { reflection: 0.5, ..matt.clone() };
            let glass = Phong { transparency: 0.7, ..matt.clone() };
            vec![
                (Arc::new(matt), Claim::All),
                (Arc::new(mirror), Claim::Surroundings),
                (Arc::new(glass), Claim::Surroundings),
            ]
        }
        MaterialKind::Principled => {
            let of = |metallic: f32, ior: f32, opacity: f32| {
                rough(&|roughness| {
                    Arc::new(Principled {
                        base_color: one,
                        metallic,
                        roughness,
                        ior,
                        opacity,
                        emission: Vec3::ZERO,
                        ..Principled::default()
                    })
                })
            };
            let clear = of(0.3, 1.5, 0.4).into_iter().map(|(material, _)| (material, Claim::Surroundings));
            [of(0.0, 1.5, 1.0), of(0.5, 1.5, 1.0), of(1.0, 1.5, 1.0), of(0.0, 2.4, 1.0)]
                .into_iter()
                .flatten()
                .chain(clear)
                .collect()
        }
        MaterialKind::Metal => rough(&|roughness| Arc::new(Metal { color: one, roughness })),
        MaterialKind::Dielectric => {
            let of =
                |ior| (Arc::new(Dielectric { ior, ..Dielectric::default() }) as Arc<dyn Material>, Claim::Surroundings);
            [1.5, 2.4, 0.7].map(of).into()
        }
        MaterialKind::ThinDielectric => vec![(Arc::new(ThinDielectric::default()), Claim::Surroundings)],
        MaterialKind::OrenNayar => {
            let of = |roughness| (Arc::new(OrenNayar { color: one, roughness }) as Arc<dyn Material>, Claim::All);
            ROUGHNESS.map(of).into()
        }
        MaterialKind::Checker => vec![(Arc::new(Checker { colors: [one; 2], ..Checker::default() }), Claim::All)],
        MaterialKind::Wireframe => {
            vec![(Arc::new(Wireframe { line: one, color: one, ..Wireframe::default() }), Claim::All)]
        }
        MaterialKind::Flat | MaterialKind::Emissive => vec![(Arc::new(Flat::new(one)), Claim::Unlit)],
        // It shows directions, not light.
        MaterialKind::NormalColor => Vec::new(),
    }
}

fn scene(material: Arc<dyn Material>, everywhere: f32, lights: Vec<Arc<dyn Light>>) -> Scene {
    let count = lights.len();
    let even = Vec3::splat(everywhere);
    let mut description = SceneDescription {
        geometry: vec![floor(0.0, 0)],
        lights,
        ambient: Arc::new(Hemisphere { above: even, below: even }),
        background: Arc::new(Constant { color: even }),
        ..SceneDescription::default()
    };
    description.materials.push(NamedMaterial { name: "white".into(), material });
    let mut scene = build(&description, AccelerationKind::Bvh).unwrap();
    scene.shadows = false;
    // There is a usual light where a scene has none.
    scene.lights.truncate(count);
    scene
}

/// The mean of what comes from the floor at an angle, over samples.
fn seen(scene: &Scene, cosine: f32, samples: u32) -> Vec3 {
    let (statistics, renderer) = (Statistics::default(), Raytracer::default());
    let width = 16;
    let (token, tone) = (AnyToken::detect(), Tone::default());
    let context =
        Context { token, width, scene, renderer: &renderer, statistics: &statistics, tone, eye: None, frame: 0 };
    let mut packet = Packet::new(width);
    let mut sum = glam::DVec3::ZERO;
    let direction = Vec3::new((1.0 - cosine * cosine).sqrt(), -cosine, 0.0);
    let mut number = 0;
    while number < samples {
        let count = (samples - number).min(width as u32);
        packet.reset(count as usize);
        for i in 0..count {
            let place = Vec3::new(0.3, 0.0, 0.2);
            set_vec3(&mut packet.rays_mut().origins_mut(), i as usize, place - direction * 2.0);
            set_vec3(&mut packet.rays_mut().directions_mut(), i as usize, direction);
            (packet.samples[0][i as usize], packet.samples[1][i as usize]) = (12_345, number + i);
        }
        packet.rays_mut().promise(Properties::NORMALIZED_DIRECTIONS);
        renderer.trace(&context, &mut packet);
        (0..count as usize).for_each(|i| sum += vec3(&packet.color, i).as_dvec3());
        number += count;
    }
    (sum / f64::from(samples)).as_vec3()
}

fn is_white(color: Vec3) -> bool {
    (color - Vec3::ONE).abs().max_element() < 1e-3
}

#[test]
fn white_surfaces_are_as_bright_as_what_is_around_them() {
    for &kind in MaterialKind::ALL {
        for (material, _) in white(kind) {
            let scene = scene(Arc::clone(&material), 1.0, Vec::new());
            for cosine in COSINES {
                let color = seen(&scene, cosine, 4096);
                assert!(is_white(color), "{kind}, {}: {color} at {cosine}", material.describe());
            }
        }
    }
}

#[test]
fn white_surfaces_return_the_light_of_a_whole_hemisphere() {
    // So many rings, and so many lights on half of each: the other half does the same. At grazing angles what is mirrored is narrow across.
    const RINGS: u32 = 96;
    const TURNS: u32 = 768;
    let step = std::f64::consts::FRAC_PI_2 / f64::from(RINGS);
    let mut lights: Vec<Arc<dyn Light>> = Vec::new();
    for ring in 0..RINGS {
        let (sine, cosine) = (step * (f64::from(ring) + 0.5)).sin_cos();
        // The exact area of the ring, so that constant functions are integrated exactly.
        let low = (step * f64::from(ring)).cos();
        let high = (step * f64::from(ring + 1)).cos();
        for turn in 0..TURNS {
            let (y, x) = (std::f64::consts::PI * (f64::from(turn) + 0.5) / f64::from(TURNS)).sin_cos();
            // The mean cosine of the ring, and its area over pi.
            let weight = 2.0 * (low - high) / f64::from(TURNS) * (0.5 * (low + high) / cosine);
            let direction = Vec3::new((sine * x) as f32, cosine as f32, (sine * y) as f32);
            lights.push(Arc::new(Directional { direction, color: Vec3::splat(weight as f32) }));
        }
    }
    for &kind in MaterialKind::ALL {
        for (material, _) in white(kind).into_iter().filter(|(_, claim)| *claim == Claim::All) {
            let scene = scene(Arc::clone(&material), 0.0, lights.clone());
            for cosine in COSINES {
                let color = seen(&scene, cosine, 1);
                assert!(is_white(color), "{kind}, {}: {color} at {cosine}", material.describe());
            }
        }
    }
}

#[test]
fn a_ball_of_clear_glass_cannot_be_seen_where_all_is_white() {
    let ball = super::sphere([0.0, 0.0, 0.0], 1.0, 0);
    let mut scene = scene(Arc::new(Dielectric::default()), 1.0, Vec::new());
    let description = SceneDescription {
        geometry: vec![ball],
        materials: vec![NamedMaterial { name: "glass".into(), material: Arc::new(Dielectric::default()) }],
        lights: Vec::new(),
        ambient: scene.ambient.clone(),
        background: scene.background.clone(),
        ..SceneDescription::default()
    };
    scene = build(&description, AccelerationKind::Bvh).unwrap();
    scene.lights.clear();
    for cosine in [1.0, 0.8, 0.6] {
        assert!(is_white(seen(&scene, cosine, 64)), "at {cosine}");
    }
}
