//! The rendering stack as a whole, on small scenes.

use std::sync::Arc;

use glam::Vec3;
use mobula_core::simd::AnyToken;

use super::RendererKind;
use crate::accel::AccelerationKind;
use crate::background::Constant;
use crate::camera::{Pinhole, Up, View};
use crate::color::to_pixel;
use crate::image::FrameBuffer;
use crate::light::{Directional, Hemisphere, Light, Point};
use crate::material::{Flat, Lambertian, Material, Phong};
use crate::medium::Fog;
use crate::sampler::SamplerKind;
use crate::scene::{Geometry, Mesh, NeedsRebuild, Scene, SceneDescription, Spheres, build};
use crate::stack::{Camera as _, Context, Fragment, Occlusion, Statistics};
use crate::tone::Tone;

mod cameras;
mod furnace;
mod lights;
mod translucent;

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
    let context = Context {
        token,
        width,
        scene,
        renderer: &*renderer,
        statistics: &statistics,
        tone: Tone::default(),
        eye: camera.eye(),
        frame: 0,
    };
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
    scene.add_material("floor", Lambertian::new(Vec3::ONE));
    scene.add_material("other", material);
    scene
}

fn middle(picture: &[u32]) -> u32 {
    picture[(HEIGHT / 2 * WIDTH + WIDTH / 2) as usize] & 0xff
}

#[test]
fn one_picture_at_every_packet_width_fragment_and_structure() {
    let scene = crate::builtin::scene();
    for sampler in [SamplerKind::Single, SamplerKind::of_samples(9)] {
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
fn ambient_occlusion_is_one_picture_too() {
    let pictures = |kind, width, fragment| {
        let mut scene = build(&crate::builtin::scene(), kind).unwrap();
        scene.occlusion = Some(Occlusion { rays: 3, distance: 2.0 });
        [SamplerKind::Single, SamplerKind::of_samples(5)].map(|sampler| {
            let (picture, counts) = render_scene(width, &scene, How { sampler, fragment, ..PLAIN });
            (picture, counts.shadow.get())
        })
    };
    let expected = pictures(AccelerationKind::Bvh, 64, 1000);
    assert!(expected[0].0 != render(64, &crate::builtin::scene(), PLAIN).0, "it changes something");
    for (kind, width, fragment) in
        [(AccelerationKind::Bvh, 1, 1000), (AccelerationKind::Bvh, 256, 7), (AccelerationKind::Brute, 16, 1000)]
    {
        assert!(pictures(kind, width, fragment) == expected, "{kind}, packets of {width}, fragments of {fragment}");
    }
}

#[test]
fn what_a_ball_keeps_away_is_its_share_of_the_sky() {
    let (radius, height) = (3.9_f32, 9.0_f32);
    // Behind the eye; no light but that from everywhere.
    let ball = |material| {
        let objects = vec![floor(0.0, 0), sphere([0.0, height, 0.0], radius, 1)];
        let ambient = Arc::new(Hemisphere { above: Vec3::ONE, below: Vec3::ONE });
        let dark: Arc<dyn Light> = Arc::new(Directional { direction: Vec3::Y, color: Vec3::ZERO });
        SceneDescription { lights: vec![dark], ambient, ..stage(objects, material) }
    };
    let open = 1.0 - (radius / height) * (radius / height);
    let byte = |open: f32| (to_pixel(Vec3::splat(open)) & 0xff) as i32;
    for (distance, expected) in [(f32::INFINITY, open), (4.0, 1.0)] {
        for renderer in [RendererKind::Raytracer, RendererKind::AmbientOcclusion] {
            let mut scene = build(&ball(Phong::default()), AccelerationKind::Bvh).unwrap();
            scene.occlusion = Some(Occlusion { rays: 16, distance });
            let how = How { renderer, sampler: SamplerKind::of_samples(64), ..PLAIN };
            let found = middle(&render_scene(64, &scene, how).0) as i32;
            assert!((found - byte(expected)).abs() <= 1, "{renderer}, {distance}: {found} for {}", byte(expected));
        }
    }
    // What lets half of the light through keeps half as much away.
    let mut scene = build(&ball(Phong { transparency: 0.5, ..Phong::default() }), AccelerationKind::Bvh).unwrap();
    scene.occlusion = Some(Occlusion { rays: 16, distance: f32::INFINITY });
    let how = How { renderer: RendererKind::AmbientOcclusion, sampler: SamplerKind::of_samples(64), ..PLAIN };
    let found = middle(&render_scene(64, &scene, how).0) as i32;
    assert!((found - byte(0.5 + 0.5 * open)).abs() <= 1, "{found} for {}", byte(0.5 + 0.5 * open));
}

#[test]
fn a_point_in_shadow_is_dark() {
    let other = Flat::new(Vec3::ZERO);
    // Behind the eye, in the way of the light.
    let objects = || -> Vec<Arc<dyn Geometry>> { vec![floor(0.0, 0), sphere([0.0, 9.0, 0.0], 0.5, 1)] };
    let lights: [Arc<dyn Light>; 3] = [
        Arc::new(Directional { direction: Vec3::Y * 3.0, color: Vec3::ONE }),
        Arc::new(Point { position: Vec3::Y * 20.0, color: Vec3::ONE, falloff: false }),
        Arc::new(Point { position: Vec3::Y * 2e6, color: Vec3::ONE, falloff: false }),
    ];
    for light in lights {
        let scene = SceneDescription { lights: vec![light.clone()], ..stage(objects(), other.clone()) };
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

/// The byte of a linear brightness.
fn byte(linear: f32) -> u32 {
    crate::color::to_pixel(Vec3::splat(linear)) & 0xff
}

/// A pane across y. Its diagonal is off the middle: a ray through an edge meets both triangles, and each stops its part.
fn pane(y: f32) -> Arc<dyn Geometry> {
    let positions = vec![[-10.0, y, -13.0], [10.0, y, -13.0], [10.0, y, 10.0], [-10.0, y, 10.0]];
    Arc::new(Mesh { positions, triangles: vec![[0, 2, 1], [0, 3, 2]], material: 1, ..Mesh::default() })
}

#[test]
fn glass_casts_the_shadow_of_its_opacity() {
    for transparency in [0.0, 0.25, 0.5, 0.9, 1.0] {
        let glass = Phong { transparency, ..Phong::default() };
        // Behind the eye, in the way of the light.
        let one = stage(vec![floor(0.0, 0), pane(9.0)], glass.clone());
        let two = stage(vec![floor(0.0, 0), pane(9.0), sphere([0.0, 7.0, 0.0], 0.5, 1)], glass);
        for width in [1, 16, 64] {
            assert_eq!(middle(&render(width, &one, PLAIN).0), byte(transparency), "{transparency}");
            assert_eq!(middle(&render(width, &two, PLAIN).0), byte(transparency * transparency), "{transparency}");
        }
        // Of a light that rays start at, too.
        let light = Arc::new(Point { position: Vec3::Y * 20.0, color: Vec3::ONE, falloff: false });
        let scene = SceneDescription { lights: vec![light], ..one };
        assert_eq!(middle(&render(16, &scene, PLAIN).0), byte(transparency), "{transparency}");
    }
}

#[test]
fn shadows_of_many_panes_are_the_same_in_any_order_and_at_any_width() {
    let heights = [6.0, 9.0, 7.0, 8.5, 6.5, 11.0];
    let glass = Phong { transparency: 0.8, ..Phong::default() };
    let picture = |heights: &[f32], kind| {
        let panes = heights.iter().map(|&y| if y == 7.0 { sphere([0.3, y, 0.2], 0.4, 1) } else { pane(y) });
        let scene = stage(panes.chain([floor(0.0, 0)]).collect(), glass.clone());
        [1, 8, 16, 64, 256].map(|width| render(width, &scene, How { kind, ..PLAIN }).0)
    };
    let pictures = picture(&heights, AccelerationKind::Bvh);
    let mut turned = heights;
    turned.reverse();
    for other in [picture(&turned, AccelerationKind::Fast), picture(&heights, AccelerationKind::Brute)] {
        assert!(other.iter().all(|other| *other == pictures[0]));
    }
    assert!(pictures.iter().all(|other| *other == pictures[0]));
}

/// A floor of this brightness, seen from 5 above it through fog of this density and brightness, and through `panes`.
fn foggy(panes: Vec<Arc<dyn Geometry>>, fog: [f32; 2], flat: f32) -> SceneDescription {
    let glass = Phong {
        diffuse: Vec3::ZERO,
        transparency: 0.5,
        refractive_index: 1.0, // which mirrors nothing
        ..Phong::default()
    };
    let mut scene = stage(panes.into_iter().chain([floor(0.0, 0)]).collect(), glass);
    scene.materials[0].material = Arc::new(Flat::new(Vec3::splat(flat)));
    scene.media = vec![Arc::new(Fog { density: fog[0], color: Vec3::splat(fog[1]) })];
    scene
}

#[test]
fn fog_is_in_front_of_inside_and_behind_transparent_surfaces() {
    let [density, bright, flat] = [0.2_f32, 0.7, 0.1];
    // What is seen through so much fog, of something of this brightness.
    let through = |length: f32, behind: f32| {
        let through = (-density * length).exp();
        bright * (1.0 - through) + through * behind
    };
    let around_the_eye = || sphere([0.0, 5.0, 0.0], 2.0, 1);
    for (panes, expected) in [
        (vec![], through(5.0, flat)),
        (vec![pane(2.0)], through(3.0, 0.5 * through(2.0, flat))),
        (vec![pane(2.0), pane(1.0)], through(3.0, 0.5 * through(1.0, 0.5 * through(1.0, flat)))),
        (vec![around_the_eye()], through(2.0, 0.5 * through(3.0, flat))),
        (vec![sphere([0.0, 2.5, 0.0], 1.0, 1)], through(1.5, 0.5 * through(2.0, 0.5 * through(1.5, flat)))),
    ] {
        let got = middle(&render(16, &foggy(panes, [density, bright], flat), PLAIN).0);
        assert!(got.abs_diff(byte(expected)) <= 1, "{got} for {}", byte(expected));
    }
    // Where nothing is, there is nothing but fog.
    let got =
        middle(&render(16, &SceneDescription { geometry: vec![], ..foggy(vec![], [density, bright], flat) }, PLAIN).0);
    assert_eq!(got, byte(bright));
}

#[test]
fn fog_weakens_the_light_on_its_way_to_a_surface() {
    let [density, bright] = [0.3_f32, 0.2];
    for height in [1.0_f32, 3.0, 40.0] {
        let mut scene = stage(vec![floor(0.0, 0)], Lambertian::default());
        scene.media = vec![Arc::new(Fog { density, color: Vec3::splat(bright) })];
        scene.lights = vec![Arc::new(Point { position: Vec3::Y * height, color: Vec3::ONE, falloff: false })];
        let through = |length: f32| (-density * length).exp();
        let expected = bright * (1.0 - through(5.0)) + through(5.0) * through(height);
        let got = middle(&render(64, &scene, PLAIN).0);
        assert!(got.abs_diff(byte(expected)) <= 1, "{got} for {}", byte(expected));
    }
}

#[test]
fn fog_is_the_same_at_every_packet_width() {
    let mut scene = crate::builtin::scene();
    scene.media = vec![Arc::new(Fog::new(0.06))];
    let picture = render(64, &scene, PLAIN).0;
    assert!(picture != render(64, &crate::builtin::scene(), PLAIN).0, "there is fog");
    for width in [1, 7, 8, 16, 256] {
        assert!(picture == render(width, &scene, How { fragment: 11, ..PLAIN }).0, "{width} rays");
    }
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
        let mut scene =
            stage(vec![floor(0.0, 1), sphere([0.0, 1.0, 0.0], 0.7, 1), sphere([0.5, 1.5, 0.2], 0.4, 1)], phong);
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
    assert!("phong".parse::<RendererKind>().unwrap_err().to_string().contains("raytracer, ao, primary"));
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
        stage(objects, Phong { transparency: 0.7, ..Phong::default() })
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
