//! Rays of all cameras.

use glam::Vec3;
use mobula_core::Properties;
use mobula_core::simd::AnyToken;

use crate::accel::AccelerationKind;
use crate::camera::{CameraKind, Lens, View};
use crate::packet::{Packet, set_vec3, vec3};
use crate::renderer::Raytracer;
use crate::scene::build;
use crate::stack::{Context, Statistics};
use crate::tone::Tone;

const VIEW: View = View { eye: Vec3::new(1.0, 2.0, 8.0), at: Vec3::new(1.0, 2.0, 3.0), up: Vec3::Y, fov: 60.0 };
const SIZE: [u32; 2] = [64, 32];

/// Origins and directions of rays for some image coordinates, each as a sample of its own.
fn rays(kind: CameraKind, view: View, lens: Lens, image: &[[f32; 2]]) -> Vec<(Vec3, Vec3)> {
    let scene = build(&crate::builtin::scene(), AccelerationKind::Bvh).unwrap();
    let (statistics, renderer) = (Statistics::default(), Raytracer::default());
    let (token, tone) = (AnyToken::detect(), Tone::default());
    let context = Context {
        token,
        width: 256,
        scene: &scene,
        renderer: &renderer,
        statistics: &statistics,
        tone,
        eye: None,
        frame: 0,
    };
    let mut packet = Packet::new(256);
    packet.reset(image.len());
    for (i, &[x, y]) in image.iter().enumerate() {
        (packet.image[0][i], packet.image[1][i]) = (x, y);
        (packet.samples[0][i], packet.samples[1][i]) = (77, i as u32);
    }
    kind.build(view, lens).make_rays(&context, SIZE, &mut packet);
    assert!(packet.rays().properties().contains(Properties::NORMALIZED_DIRECTIONS), "{kind}");
    packet.rays().check();
    let of = |columns: [&[f32]; 3], i: usize| {
        let mut out = [[0.0]; 3];
        set_vec3(&mut out, 0, Vec3::from(columns.map(|column| column[i])));
        vec3(&out, 0)
    };
    (0..image.len()).map(|i| (of(packet.rays().origins(), i), of(packet.rays().directions(), i))).collect()
}

fn is_near(a: Vec3, b: Vec3) -> bool {
    (a - b).length() < 1e-4
}

#[test]
fn all_cameras_look_where_they_are_turned_to_and_have_unit_rays() {
    let image: Vec<[f32; 2]> = (0..200).map(|i| [(i * 7 % 64) as f32 + 0.5, (i * 5 % 32) as f32 + 0.25]).collect();
    for &kind in CameraKind::ALL {
        let lens = Lens { aperture: Some(0.0), focus: None };
        let all = rays(kind, VIEW, lens, &[&image[..], &[[32.0, 16.0], [32.0, 8.0], [48.0, 16.0]]].concat());
        assert!(all.iter().all(|(_, d)| (d.length() - 1.0).abs() < 1e-5), "{kind}");
        let [(eye, ahead), (above, higher), (beside, aside)] = all[200..] else { unreachable!() };
        assert!(is_near(eye, VIEW.eye) && is_near(ahead, Vec3::NEG_Z), "{kind}: {eye} {ahead}");
        let turned = kind != CameraKind::Orthographic;
        assert!(if turned { higher.y > 0.1 } else { above.y > eye.y + 0.1 }, "{kind}: {higher}");
        assert!(if turned { aside.x > 0.1 } else { beside.x > eye.x + 0.1 }, "{kind}: {aside}");
    }
}

#[test]
fn a_lens_has_what_is_at_its_focus_sharp() {
    let lens = Lens { aperture: Some(0.3), focus: Some(4.0) };
    let image = [[40.0, 10.0]; 200];
    let [(_, pinhole)] = rays(CameraKind::Pinhole, VIEW, lens, &image[..1])[..] else { unreachable!() };
    let sharp = VIEW.eye + pinhole * (4.0 / -pinhole.z);
    let mut spread = Vec3::ZERO;
    for (origin, direction) in rays(CameraKind::ThinLens, VIEW, lens, &image) {
        assert!((origin - VIEW.eye).length() < 0.3001 && (origin.z - 8.0).abs() < 1e-6);
        spread = spread.max((origin - VIEW.eye).abs());
        assert!(is_near(origin + direction * (4.0 / -direction.z), sharp));
    }
    assert!(spread.x > 0.25 && spread.y > 0.25, "the lens is used as far as its edge: {spread}");
}

#[test]
fn environments_go_all_around_and_fisheyes_as_far_as_they_are_told() {
    let around =
        rays(CameraKind::Environment, VIEW, Lens::default(), &[[0.0, 16.0], [16.0, 16.0], [32.0, 0.0], [5.0, 32.0]]);
    let found: Vec<Vec3> = around.into_iter().map(|(_, direction)| direction).collect();
    for (found, expected) in found.into_iter().zip([Vec3::Z, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y]) {
        assert!(is_near(found, expected), "{found} {expected}");
    }
    for (fov, expected) in [(180.0, Vec3::Y), (360.0, Vec3::Z), (90.0, Vec3::new(0.0, 1.0, -1.0) / 2.0_f32.sqrt())] {
        let [(_, top)] = rays(CameraKind::Fisheye, View { fov, ..VIEW }, Lens::default(), &[[32.0, 0.0]])[..] else {
            unreachable!()
        };
        assert!(is_near(top, expected), "{top} {expected}");
    }
}
