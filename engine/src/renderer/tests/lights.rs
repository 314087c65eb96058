//! Lights with extent, skies, and the ground, in pictures.

use super::*;
use crate::background::{Daylight, Panorama};
use crate::light::{Disk, Sun};
use crate::scene::Ground;
use crate::texture::{Picture, Texels};

/// A picture of one row around, of one colour.
fn around(color: f32) -> Arc<Panorama> {
    let picture = Picture::new([2, 1], Texels::Floats(vec![[color, color, color, 1.0]; 2])).unwrap();
    Arc::new(Panorama::new(&picture, 0.0, 1.0))
}

fn with_samples(count: u32) -> How {
    How { sampler: SamplerKind::of_samples(count), ..PLAIN }
}

#[test]
fn a_white_ball_in_a_white_surrounding_cannot_be_seen() {
    let mut scene = stage(vec![sphere([0.0; 3], 1.0, 0)], Flat::default());
    scene.lights.clear();
    scene.background = around(0.5);
    let (picture, _) = render(256, &scene, with_samples(1024));
    let expected = byte(0.5) as i32;
    let most = picture.iter().map(|pixel| ((pixel & 0xff) as i32 - expected).abs()).max().unwrap();
    assert!(most <= 4, "{most}");
    let mean = picture.iter().map(|pixel| (pixel & 0xff) as f32).sum::<f32>() / picture.len() as f32;
    assert!((mean - expected as f32).abs() < 0.5, "{mean} for {expected}");
}

#[test]
fn shadows_of_extended_lights_have_a_penumbra() {
    // Behind the eye: a ball, and above it a light.
    let objects = || vec![floor(0.0, 0), sphere([0.0, 7.0, 0.0], 0.6, 1)];
    let brightness = |light: Arc<dyn Light>| {
        let scene = SceneDescription { lights: vec![light], ..stage(objects(), Flat::default()) };
        let (picture, _) = render(64, &scene, with_samples(256));
        let row = (HEIGHT / 2 * WIDTH) as usize;
        picture[row + 20..row + 41].iter().map(|pixel| (pixel & 0xff) as i32).collect::<Vec<_>>()
    };
    let position = Vec3::Y * 14.0;
    let soft = [
        brightness(Arc::new(Disk { position, direction: Vec3::NEG_Y, radius: 1.0, color: Vec3::splat(200.0) })),
        brightness(Arc::new(Sun { direction: Vec3::Y, color: Vec3::ONE, angle: 6.0 })),
    ];
    for soft in soft {
        assert!(soft[0] < 8 && soft[20] > 200, "{soft:?}");
        assert!(soft.windows(2).all(|two| two[1] >= two[0] - 10), "brighter and brighter: {soft:?}");
        assert!(soft.iter().filter(|&&x| x > 8 && x < 245).count() >= 4, "{soft:?}");
    }
    let hard = brightness(Arc::new(Directional { direction: Vec3::Y, color: Vec3::ONE }));
    assert!(hard.iter().filter(|&&x| x > 8 && x < 245).count() <= 2, "{hard:?}");
}

#[test]
fn a_white_floor_under_a_high_sun_is_white() {
    let mut scene = stage(vec![floor(0.0, 0)], Flat::default());
    scene.lights.clear();
    scene.background = Arc::new(Daylight::new(60.0, 30.0, 3.0));
    let (picture, _) = render(64, &scene, with_samples(256));
    let mean = picture.iter().map(|pixel| (pixel & 0xff) as f32).sum::<f32>() / picture.len() as f32;
    assert!(mean > 240.0, "{mean}");
}

#[test]
fn the_ground_is_no_part_of_the_scene() {
    let scene = || stage(vec![sphere([0.0, 3.0, 0.0], 1.0, 0), sphere([0.0, 0.5, 2.0], 0.5, 0)], Flat::default());
    let bare = build(&SceneDescription { view: None, ..scene() }, AccelerationKind::Bvh).unwrap();
    let with = SceneDescription { view: None, ground: Some(Ground::default()), ..scene() };
    let mut with = build(&with, AccelerationKind::Bvh).unwrap();
    assert_eq!((with.bulk, with.bounds(), with.view(1.5)), (bare.bulk, bare.bounds(), bare.view(1.5)));
    assert_eq!(with.geometry.list().len(), bare.geometry.list().len());
    assert_eq!(with.geometry.census().items(), bare.geometry.census().items());
    let how = with_samples(1);
    let (picture, _) = render_scene(64, &with, how);
    assert!(picture != render_scene(64, &bare, how).0, "but it is seen");
    // It stays where the scene moves, and where the same is put there again.
    let list = |y: f32| vec![sphere([0.0, y, 0.0], 1.0, 0), sphere([0.0, 0.5, 2.0], 0.5, 0)];
    with.view = Some(with.view(1.5));
    let (picture, _) = render_scene(64, &with, how);
    with.geometry.refit(list(4.0)).unwrap();
    assert!(render_scene(64, &with, how).0 != picture);
    with.geometry.refit(list(3.0)).unwrap();
    assert!(render_scene(64, &with, how).0 == picture);
    assert_eq!(with.geometry.refit(list(3.0).split_off(1)), Err(NeedsRebuild));
}

#[test]
fn a_ground_is_under_nothing_too_and_under_what_is_odd() {
    for geometry in [vec![], vec![sphere([f32::MAX; 3], 1.0, 0)], vec![sphere([1e30; 3], 1e-30, 0)]] {
        let ground = Some(Ground { at: Some(Vec3::NAN), ..Ground::default() });
        for ground in [ground, Some(Ground::default())] {
            let scene = SceneDescription { ground, ..stage(geometry.clone(), Flat::default()) };
            render(16, &scene, PLAIN);
        }
    }
}

#[test]
fn soft_light_is_one_picture() {
    let mut scene = crate::builtin::scene();
    scene.lights.push(Arc::new(Disk { position: Vec3::Y * 6.0, ..Disk::default() }));
    scene.background = Arc::new(Daylight::default());
    scene.ground = Some(Ground::default());
    let expected = render(64, &scene, with_samples(4)).0;
    for (width, fragment) in [(1, 1000), (7, 5), (256, 9)] {
        assert!(render(width, &scene, How { fragment, ..with_samples(4) }).0 == expected, "{width}, {fragment}");
    }
}
