//! The rendering stack as a whole, on small scenes.

use std::sync::Arc;

use glam::Vec3;
use mobula_core::simd::AnyToken;

use super::RendererKind;
use crate::accel::AccelerationKind;
use crate::background::Constant;
use crate::camera::{Pinhole, Up, View};
use crate::image::FrameBuffer;
use crate::light::{Directional, Hemisphere, Light, Point};
use crate::material::{Flat, Lambertian, Material, Phong};
use crate::sampler::SamplerKind;
use crate::scene::{Geometry, Mesh, NeedsRebuild, Scene, SceneDescription, Spheres, build};
use crate::stack::{Context, Fragment, Statistics};

const WIDTH: u32 = 41;
const HEIGHT: u32 = 27;

/// How a test renders.
#[derive(Clone, Copy)]
struct How {
    kind: AccelerationKind,
    renderer: RendererKind,
    sampler: SamplerKind,
    /// Sides of the fragments that the picture is cut into.
    fragment: u32,
}

const PLAIN: How = How {
    kind: AccelerationKind::Bvh,
    renderer: RendererKind::Raytracer,
    sampler: SamplerKind::Single,
    fragment: 1000,
};

/// Renders with packets of so many rays.
fn render(width: usize, description: &SceneDescription, how: How) -> (Vec<u32>, Statistics) {
    render_scene(width, &build(description, how.kind).unwrap(), how)
}

fn render_scene(width: usize, scene: &Scene, how: How) -> (Vec<u32>, Statistics) {
    let camera = Pinhole::new(scene.view(WIDTH as f32 / HEIGHT as f32));
    let picture = FrameBuffer::new(WIDTH as usize, HEIGHT as usize).unwrap();
    let statistics = Statistics::default();
    let renderer = how.renderer.build();
    let token = AnyToken::detect();
    let context = Context { token, width, scene, renderer: &*renderer, statistics: &statistics, frame: 0 };
    let sampler = how.sampler.build();
    for y0 in (0..HEIGHT).step_by(how.fragment as usize) {
        for x0 in (0..WIDTH).step_by(how.fragment as usize) {
            let (x1, y1) = ((x0 + how.fragment).min(WIDTH), (y0 + how.fragment).min(HEIGHT));
            let [x0, y0, x1, y1] = [x0, y0, x1, y1].map(|edge| edge as usize);
            let fragment = Fragment { channel: 0, x0, y0, x1, y1, step: 1 };
            sampler.render_fragment(&context, &camera, fragment, &picture);
        }
    }
    (picture.pixels().collect(), statistics)
}

fn sphere(center: [f32; 3], radius: f32, material: u32) -> Arc<dyn Geometry> {
    Arc::new(Spheres { centers: vec![center], radii: vec![radius], material, ..Spheres::default() })
}

/// A square of side 20 around the origin at height y.
fn floor(y: f32, material: u32) -> Arc<dyn Geometry> {
    let positions = vec![[-10.0, y, -10.0], [10.0, y, -10.0], [10.0, y, 10.0], [-10.0, y, 10.0]];
    Arc::new(Mesh { positions, triangles: vec![[0, 2, 1], [0, 3, 2]], material, ..Mesh::default() })
}

/// Looks straight down on a floor without ambient light, lit from straight above; black where nothing is.
fn stage(geometry: Vec<Arc<dyn Geometry>>, material: impl Material) -> SceneDescription {
    let mut scene = SceneDescription {
        geometry,
        lights: vec![Arc::new(Directional { direction: Vec3::Y, color: Vec3::ONE })],
        ambient: Arc::new(Hemisphere { above: Vec3::ZERO, below: Vec3::ZERO }),
        background: Arc::new(Constant { color: Vec3::ZERO }),
        up: Some(Up::Y),
        view: Some(View { eye: Vec3::new(0.0, 5.0, 0.0), at: Vec3::ZERO, up: Vec3::NEG_Z, fov: 40.0 }),
        ..SceneDescription::default()
    };
    scene.add_material("floor", Lambertian { diffuse: Vec3::ONE });
    scene.add_material("other", material);
    scene
}

fn middle(picture: &[u32]) -> u32 {
    picture[(HEIGHT / 2 * WIDTH + WIDTH / 2) as usize] & 0xff
}

#[test]
fn one_picture_at_every_packet_width_fragment_and_structure() {
    let scene = crate::builtin::scene();
    for sampler in [SamplerKind::Single, SamplerKind::Jittered { side: 3 }] {
        let how = How { sampler, ..PLAIN };
        let (picture, statistics) = render(64, &scene, how);
        let counts = |s: &Statistics| [s.primary.get(), s.shadow.get(), s.secondary.get()];
        let check = |name: &str, (other, more): (Vec<u32>, Statistics)| {
            let differ = picture.iter().zip(&other).filter(|(a, b)| a != b).count();
            assert_eq!(differ, 0, "{differ} pixels differ: {name}, {sampler}");
            assert_eq!(counts(&statistics), counts(&more), "{name}, {sampler}");
        };
        check("1 ray", render(1, &scene, how));
        check("4 rays", render(4, &scene, how));
        check("7 rays", render(7, &scene, how));
        check("16 rays", render(16, &scene, how));
        check("256 rays", render(256, &scene, how));
        check("fragments of 5", render(16, &scene, How { fragment: 5, ..how }));
    }
    let (picture, _) = render(64, &scene, PLAIN);
    assert!(picture == render(64, &scene, How { kind: AccelerationKind::Brute, ..PLAIN }).0, "bvh and brute differ");
}

#[test]
fn a_point_in_shadow_is_dark() {
    let other = Flat { color: Vec3::ZERO };
    // Behind the eye, in the way of the light.
    let objects = || -> Vec<Arc<dyn Geometry>> { vec![floor(0.0, 0), sphere([0.0, 9.0, 0.0], 0.5, 1)] };
    let lights: [Arc<dyn Light>; 3] = [
        Arc::new(Directional { direction: Vec3::Y * 3.0, color: Vec3::ONE }),
        Arc::new(Point { position: Vec3::Y * 20.0, color: Vec3::ONE, falloff: false }),
        Arc::new(Point { position: Vec3::Y * 2e6, color: Vec3::ONE, falloff: false }),
    ];
    for light in lights {
        let scene = SceneDescription { lights: vec![light.clone()], ..stage(objects(), other) };
        let (picture, statistics) = render(16, &scene, PLAIN);
        assert_eq!(middle(&picture), 0, "{light:?}");
        assert!(picture[0] & 0xff > 200, "{light:?}");
        assert_eq!(statistics.primary.get(), u64::from(WIDTH * HEIGHT));
        assert_eq!(statistics.shadow.get(), u64::from(WIDTH * HEIGHT));
        assert_eq!(statistics.secondary.get(), 0);
    }
}

#[test]
fn a_surface_does_not_shadow_itself() {
    // A floor whose corners are far away in no round direction, and a sphere, lit at grazing angles.
    for scale in [1e-4_f32, 1.0, 3e3] {
        let p = |x: f32, z: f32| [x * scale, (0.31 * x - 0.17 * z) * scale, z * scale];
        let positions = vec![p(-71.0, -50.0), p(93.0, -61.0), p(3.0, 117.0)];
        let triangle = Mesh { positions, triangles: vec![[0, 1, 2]], material: 0, ..Mesh::default() };
        let lights: [Arc<dyn Light>; 2] = [
            Arc::new(Directional { direction: Vec3::new(1.0, 0.4, 0.0), color: Vec3::ONE }),
            Arc::new(Point { position: Vec3::new(90.0, 30.0, 5.0) * scale, color: Vec3::ONE, falloff: false }),
        ];
        for light in lights {
            let mut scene = stage(vec![Arc::new(triangle.clone())], Lambertian::default());
            scene.lights = vec![light.clone()];
            let view = View { eye: Vec3::new(-0.6, 4.0, 0.4) * scale, ..scene.view.unwrap() };
            scene.view = Some(view);
            let (picture, _) = render(64, &scene, PLAIN);
            let dark = picture.iter().filter(|&&p| p & 0xff == 0).count();
            assert_eq!(dark, 0, "{dark} pixels are dark: {light:?}, scale {scale}");
        }
    }
}

#[test]
fn clear_glass_casts_no_shadow() {
    let phong = Phong { transparency: 0.9, ..Phong::default() };
    let objects = vec![floor(0.0, 0), sphere([0.0, 9.0, 0.0], 0.5, 1)];
    let (picture, _) = render(16, &stage(objects, phong), PLAIN);
    assert_eq!(middle(&picture), 255);
}

#[test]
fn both_sides_of_a_surface_are_lit() {
    let mut scene = stage(vec![floor(0.0, 0)], Lambertian::default());
    scene.lights = vec![Arc::new(Directional { direction: Vec3::NEG_Y, color: Vec3::ONE })];
    assert_eq!(middle(&render(16, &scene, PLAIN).0), 0);
    scene.view = Some(View { eye: Vec3::new(0.0, -5.0, 0.0), ..scene.view.unwrap() });
    assert_eq!(middle(&render(16, &scene, PLAIN).0), 255);
}

#[test]
fn a_white_furnace_shows_nothing() {
    // White things in a white world: whatever is scattered, mirrored and let through must add up to white.
    let white = Vec3::ONE;
    for (reflection, transparency) in [(0.0, 0.0), (0.4, 0.0), (1.0, 0.0), (0.0, 0.5), (0.3, 0.7), (0.0, 1.0)] {
        let phong = Phong { diffuse: white, reflection, transparency, ..Phong::default() };
        let mut scene = stage(
            vec![floor(0.0, 1), sphere([0.0, 1.0, 0.0], 0.7, 1), sphere([0.5, 1.5, 0.2], 0.4, 1)],
            phong,
        );
        let dark = Arc::new(Directional { direction: Vec3::Y, color: Vec3::ZERO });
        scene.lights = vec![dark];
        scene.ambient = Arc::new(Hemisphere { above: white, below: white });
        scene.background = Arc::new(Constant { color: white });
        let (picture, _) = render(16, &scene, PLAIN);
        // One byte for the weights too small to trace.
        let darkest = picture.iter().map(|p| p & 0xff).min().unwrap();
        assert!(darkest >= 254, "{darkest} at reflection {reflection}, transparency {transparency}");
    }
}

#[test]
fn facing_mirrors_end() {
    let phong = Phong { reflection: 1.0, ..Phong::default() };
    let scene = stage(vec![floor(0.0, 1), floor(8.0, 1)], phong);
    let (_, statistics) = render(64, &scene, PLAIN);
    assert!(statistics.secondary.get() <= 6 * statistics.primary.get());
    assert!(statistics.secondary.get() >= 3 * statistics.primary.get());
}

#[test]
fn every_renderer_takes_empty_and_unknown_things() {
    let unknown = sphere([0.0; 3], 1.0, 17);
    let empty = SceneDescription::default();
    let missing = stage(vec![unknown], Lambertian::default());
    for &renderer in RendererKind::ALL {
        assert_eq!(renderer.name().parse(), Ok(renderer));
        for scene in [&empty, &missing] {
            let (picture, statistics) = render(16, scene, How { renderer, ..PLAIN });
            assert!(picture.iter().all(|p| p >> 24 == 255), "{renderer}");
            assert_eq!(statistics.primary.get(), u64::from(WIDTH * HEIGHT), "{renderer}");
        }
    }
    assert!("phong".parse::<RendererKind>().unwrap_err().to_string().contains("raytracer, primary"));
    assert_eq!("brute".parse(), Ok(AccelerationKind::Brute));
}

#[test]
fn a_refitted_scene_is_the_picture_of_one_built_anew() {
    let sea = |phase: f32| {
        let at = |x: u32, z: u32| z * 20 + x;
        let cells = (0..19).flat_map(|z| (0..19).map(move |x| (x, z)));
        let triangles = cells.flat_map(|(x, z)| {
            let [a, b, c, d] = [at(x, z), at(x, z + 1), at(x + 1, z + 1), at(x + 1, z)];
            [[a, b, c], [a, c, d]]
        });
        let wave = |i: u32| [(i % 20) as f32 - 10.0, (i as f32 * 0.5 + phase).sin(), (i / 20) as f32 - 10.0];
        let positions = (0..400).map(wave).collect();
        Arc::new(Mesh { positions, triangles: triangles.collect(), ..Mesh::default() }) as Arc<dyn Geometry>
    };
    let scene = |phase: f32, radius: f32| {
        let objects = vec![sea(phase), sphere([2.0 + phase, 1.0, 0.0], radius, 0), sphere([-2.0, 1.5, phase], 1.0, 1)];
        stage(
            objects,
            Phong { transparency: 0.7, ..Phong::default() },
        )
    };
    let mut refitted = build(&scene(0.0, 1.0), AccelerationKind::Bvh).unwrap();
    let before = render_scene(64, &refitted, PLAIN).0;
    // The sphere leaves when it has no radius, and comes back.
    for (phase, radius) in [(1.0, 1.0), (1.5, -1.0), (2.5, 0.5)] {
        refitted.geometry.refit(scene(phase, radius).geometry).unwrap();
        let picture = render_scene(64, &refitted, PLAIN).0;
        assert!(picture != before, "something moved");
        assert!(picture == render(64, &scene(phase, radius), PLAIN).0, "phase {phase}");
    }
    let more = stage(vec![sea(0.0), sphere([0.0; 3], 1.0, 0)], Lambertian::default());
    assert_eq!(refitted.geometry.refit(more.geometry), Err(NeedsRebuild));
    let mut without = build(&scene(0.0, -1.0), AccelerationKind::Bvh).unwrap();
    assert_eq!(without.geometry.refit(scene(0.0, 1.0).geometry), Err(NeedsRebuild), "the tree does not have it");
}
