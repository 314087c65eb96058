//! Volumes among other things: surfaces, fog, each other.

use std::sync::Arc;

use glam::Vec3;
use mobula_core::simd::AnyToken;

use super::{Fog, Medium, Volume};
use crate::accel::AccelerationKind;
use crate::background::Constant;
use crate::camera::{Camera, Pinhole, Up, View};
use crate::geometry::{Field, Mesh, Series};
use crate::light::{Directional, Hemisphere};
use crate::material::{Flat, Lambertian, Material, Phong};
use crate::packet::{Packet, vec3};
use crate::renderer::RendererKind;
use crate::scene::{SceneDescription, build};
use crate::stack::{Context, Statistics};
use crate::tone::Tone;
use crate::volume::{Grid, GridPlace, Scale, TransferFunction, TransferPoint};

/// A box with the same everywhere in it: from -1 to 1 in x and z, and so high.
fn slab([low, high]: [f64; 2], color: [f32; 3], extinction: f64) -> Arc<dyn Medium> {
    let dims = [9, 17, 9];
    let spacing = [0.25, (high - low) / 16.0, 0.25];
    let place = GridPlace { origin: glam::DVec3::new(-1.0, low, -1.0), ..GridPlace::with_spacing(spacing) };
    let grid = Grid::new(dims, vec![100_u8; 9 * 17 * 9].into(), place, [1.0, 0.0]).unwrap();
    let series = Series::new(vec![Arc::new(Field::new(Arc::new(grid)).unwrap())]);
    let point = TransferPoint { value: 100.0, color, extinction };
    let function = TransferFunction::new("even", vec![point], Scale::Absolute, Scale::Absolute).unwrap();
    Arc::new(Volume::new("slab", series, Arc::new(function)))
}

/// A square across y.
fn pane(y: f32, material: u32) -> Mesh {
    let positions = vec![[-9.0, y, -9.0], [9.0, y, -9.0], [9.0, y, 9.0], [-9.0, y, 9.0]];
    Mesh { positions, triangles: vec![[0, 2, 1], [0, 3, 2]], material, ..Mesh::default() }
}

/// What is seen from a height of 5 straight down, by packets of so many rays.
fn seen(scene: &SceneDescription, token: AnyToken, width: usize) -> Vec<Vec3> {
    let scene = build(scene, AccelerationKind::Bvh).unwrap();
    let (renderer, statistics) = (RendererKind::Raytracer.build(), Statistics::default());
    let context = Context {
        token,
        width,
        scene: &scene,
        renderer: &*renderer,
        statistics: &statistics,
        tone: Tone::default(),
        eye: None,
        frame: 0,
    };
    let view = View { eye: Vec3::Y * 5.0, at: Vec3::ZERO, up: Vec3::Z, fov: 5.0 };
    let camera: &dyn Camera = &Pinhole::new(view);
    let mut out = Vec::new();
    for first in (0..16).step_by(width) {
        let mut packet = Packet::new(width);
        packet.reset(width.min(16 - first));
        for i in 0..packet.len() {
            (packet.image[0][i], packet.image[1][i]) = (0.5 + ((first + i) % 4) as f32, 0.5 + ((first + i) / 4) as f32);
        }
        camera.make_rays(&context, [4, 4], &mut packet);
        renderer.trace(&context, &mut packet);
        out.extend((0..packet.len()).map(|i| vec3(&packet.color, i)));
    }
    out
}

fn scene(media: Vec<Arc<dyn Medium>>, surfaces: Vec<Mesh>, material: impl Material) -> SceneDescription {
    let mut scene = SceneDescription {
        media,
        lights: vec![Arc::new(Directional { direction: Vec3::Y, color: Vec3::ONE })],
        ambient: Arc::new(Hemisphere { above: Vec3::ZERO, below: Vec3::ZERO }),
        background: Arc::new(Constant { color: Vec3::splat(0.5) }),
        up: Some(Up::Y),
        ..SceneDescription::default()
    };
    scene.add_material("material", material);
    surfaces.into_iter().for_each(|surface| scene.add(surface));
    scene
}

/// Holds what is seen against layers, from above: color, extinction, height.
fn is_layers(scene: &SceneDescription, layers: &[([f32; 3], f32, f32)], behind: Vec3, within: f32) {
    let expected = layers.iter().rev().fold(behind, |behind, &(color, extinction, height)| {
        let through = (-extinction * height).exp();
        Vec3::from(color) * (1.0 - through) + behind * through
    });
    for token in AnyToken::available() {
        for width in [8, 64] {
            for color in seen(scene, token, width) {
                let off = (color - expected).abs().max_element();
                assert!(off < within, "{}, {width}: {color} for {expected}", token.level());
            }
        }
    }
}

const RED: [f32; 3] = [0.9, 0.1, 0.2];
const BLUE: [f32; 3] = [0.1, 0.3, 0.8];

#[test]
fn volumes_end_at_surfaces_and_go_on_behind_transparent_ones() {
    let volume = || slab([-1.0, 3.0], RED, 0.4);
    is_layers(&scene(vec![volume()], vec![], Flat::default()), &[(RED, 0.4, 4.0)], Vec3::splat(0.5), 2e-3);
    let flat = Flat::new(Vec3::new(0.0, 1.0, 0.0));
    is_layers(&scene(vec![volume()], vec![pane(1.0, 0)], flat.clone()), &[(RED, 0.4, 2.0)], Vec3::Y, 2e-3);
    is_layers(&scene(vec![volume()], vec![pane(4.0, 0)], flat), &[], Vec3::Y, 1e-6);
    // Glass that only takes half of the light.
    let glass = Phong { diffuse: Vec3::ZERO, transparency: 0.5, refractive_index: 1.0, ..Phong::default() };
    let half = ([0.0; 3], std::f32::consts::LN_2, 1.0);
    let layers = [(RED, 0.4, 1.0), half, (RED, 0.4, 3.0)];
    is_layers(&scene(vec![volume()], vec![pane(2.0, 0)], glass), &layers, Vec3::splat(0.5), 2e-3);
}

#[test]
fn media_that_overlap_are_mixed() {
    let mixed = |a: ([f32; 3], f32), b: ([f32; 3], f32), height: f32| {
        let sum = a.1 + b.1;
        let color = [0, 1, 2].map(|k| (a.0[k] * a.1 + b.0[k] * b.1) / sum);
        (color, sum, height)
    };
    // Behind one another, in either order in the list.
    let (upper, lower) = (slab([1.0, 3.0], RED, 0.5), slab([-2.0, 0.0], BLUE, 0.3));
    let layers = [(RED, 0.5, 2.0), (BLUE, 0.3, 2.0)];
    is_layers(&scene(vec![upper.clone(), lower.clone()], vec![], Flat::default()), &layers, Vec3::splat(0.5), 2e-3);
    is_layers(&scene(vec![lower, upper], vec![], Flat::default()), &layers, Vec3::splat(0.5), 2e-3);
    // One in part within the other.
    let (a, b) = (slab([-1.0, 3.0], RED, 0.5), slab([0.0, 4.0], BLUE, 0.3));
    let layers = [(BLUE, 0.3, 1.0), mixed((RED, 0.5), (BLUE, 0.3), 3.0), (RED, 0.5, 1.0)];
    is_layers(&scene(vec![a, b], vec![], Flat::default()), &layers, Vec3::splat(0.5), 3e-3);
    // In fog, which is everywhere; behind a surface there is no more of either.
    let fog = Fog { color: Vec3::from(BLUE), density: 0.2 };
    let layers = [(BLUE, 0.2, 2.0), mixed((RED, 0.5), (BLUE, 0.2), 2.0)];
    let media: Vec<Arc<dyn Medium>> = vec![slab([-1.0, 3.0], RED, 0.5), Arc::new(fog)];
    let flat = Flat::new(Vec3::ONE);
    is_layers(&scene(media.clone(), vec![pane(1.0, 0)], flat.clone()), &layers, Vec3::ONE, 3e-3);
    let endless = [layers[0], mixed((RED, 0.5), (BLUE, 0.2), 4.0), (BLUE, 0.2, 1e9)];
    is_layers(&scene(media, vec![], flat), &endless, Vec3::ZERO, 3e-3);
}

#[test]
fn volumes_throw_shadows_on_surfaces() {
    let volume = slab([2.0, 3.0], [0.0; 3], 0.7);
    let matt = Lambertian::new(Vec3::ONE);
    // Through the volume to the eye, and from the light through it.
    let through = (-0.7_f32).exp();
    is_layers(&scene(vec![volume], vec![pane(0.0, 0)], matt), &[([0.0; 3], 0.7, 1.0)], Vec3::splat(through), 2e-3);
}

#[test]
fn a_lit_volume_is_as_bright_as_a_surface_across_its_gradient() {
    // Values fall upwards, and change within little.
    let dims = [9, 33, 9];
    let value = |i: usize| if i / 9 % 33 < 16 { 200_u8 } else { 0 };
    let place =
        GridPlace { origin: glam::DVec3::new(-1.0, -2.0, -1.0), ..GridPlace::with_spacing([0.25, 0.125, 0.25]) };
    let voxels: Vec<u8> = (0..9 * 33 * 9).map(value).collect();
    let grid = Grid::new(dims, voxels.into(), place, [1.0, 0.0]).unwrap();
    let series = Series::new(vec![Arc::new(Field::new(Arc::new(grid)).unwrap())]);
    let point = |value, extinction| TransferPoint { value, color: [0.5, 0.25, 1.0], extinction };
    let points = vec![point(20.0, 0.0), point(40.0, 400.0)];
    let function = TransferFunction::new("solid", points, Scale::Absolute, Scale::Absolute).unwrap();
    let mut volume = Volume::new("solid", series, Arc::new(function));
    volume.lit = true;
    for angle in [0.0_f32, 0.6, 1.2] {
        let mut scene = scene(vec![Arc::new(volume.clone())], vec![], Flat::default());
        let direction = Vec3::new(angle.sin(), angle.cos(), 0.0);
        scene.lights = vec![Arc::new(Directional { direction, color: Vec3::splat(0.8) })];
        scene.ambient = Arc::new(Hemisphere { above: Vec3::splat(0.1), below: Vec3::ZERO });
        let expected = Vec3::new(0.5, 0.25, 1.0) * (0.8 * angle.cos() + 0.1);
        for token in AnyToken::available() {
            for color in seen(&scene, token, 16) {
                assert!((color - expected).abs().max_element() < 0.03, "{angle}: {color} for {expected}");
            }
        }
    }
}
