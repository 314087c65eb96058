//! One picture, every path: the same bytes at every packet width, thread count, load balancer, acceleration structure,
//! and level of one numeric family.

use std::collections::HashSet;
use std::path::Path;
use std::sync::Arc;

use glam::DVec3;
use mobula::accel::AccelerationKind;
use mobula::app::{PacketWidth, Settings, pipeline};
use mobula::background::BackgroundKind;
use mobula::balance::BalancerKind;
use mobula::camera::CameraKind;
use mobula::geometry::{Field, KINDS, Particles, Series};
use mobula::image::Size;
use mobula::light::LightKind;
use mobula::material::{MaterialKind, NamedMaterial, Phong};
use mobula::medium::{Fog, Volume};
use mobula::scene::{Ground, SceneDescription};
use mobula::volume::{Grid, GridPlace, Preset};
use mobula_simd::AnyToken;

const THREADS: [usize; 4] = [1, 2, 3, 7];
const BALANCERS: [&str; 5] = ["by-cost", "work-queue", "work-queue:3", "cyclic", "static"];

/// These tests go through all levels themselves: that one is forced changes nothing for them.
fn is_forced() -> bool {
    let forced = std::env::var_os("MOBULA_ISA").is_some_and(|level| !level.is_empty());
    if forced {
        println!("skipped: MOBULA_ISA forces a level, and this test goes through all of them without");
    }
    forced
}

struct Case {
    description: SceneDescription,
    size: Size,
}

impl Case {
    fn new(description: SceneDescription, size: (usize, usize)) -> Self {
        Self { description, size: Size::new(size.0, size.1).unwrap() }
    }

    fn picture(&self, settings: Settings) -> Vec<u8> {
        self.picture_after(1, settings)
    }

    fn picture_after(&self, frames: u64, settings: Settings) -> Vec<u8> {
        let settings = Settings { size: self.size, ..settings };
        let mut pipeline = pipeline(&self.description, &settings).unwrap();
        pipeline.run(frames).unwrap();
        let (_, picture) = pipeline.picture(0).unwrap();
        picture.to_rgba8()
    }

    /// One picture along all paths; the two families may differ.
    fn check(&self, brute: bool) {
        if is_forced() {
            return;
        }
        for fused in [false, true] {
            let levels: Vec<_> = AnyToken::available().filter(|token| token.fused() == fused).collect();
            let Some(&first) = levels.first() else {
                println!("skipped: this machine has no fused level");
                continue;
            };
            let base = Settings { token: first, threads: 1, ..Settings::default() };
            let reference = self.picture(base.clone());
            assert!(reference.chunks(4).any(|pixel| pixel != &reference[..4]), "the picture is empty");
            let same = |what: String, settings: Settings| {
                assert!(self.picture(settings) == reference, "{what} gives another picture than {first:?}");
            };
            for (&token, packet) in levels.iter().flat_map(|t| PacketWidth::ALL.iter().map(move |&p| (t, p))) {
                same(format!("{token:?}, packets of {packet}"), Settings { token, packet, ..base.clone() });
            }
            let token = *levels.last().unwrap();
            for (threads, name) in THREADS.into_iter().flat_map(|t| BALANCERS.map(|b| (t, b))) {
                let balancer: BalancerKind = name.parse().unwrap();
                same(format!("{threads} threads, {name}"), Settings { token, threads, balancer, ..base.clone() });
            }
            let acceleration = AccelerationKind::Fast;
            same("a tree built fast".into(), Settings { token, acceleration, ..base.clone() });
            if brute {
                let acceleration: AccelerationKind = "brute".parse().unwrap();
                same("no acceleration structure".into(), Settings { token, acceleration, ..base.clone() });
            }
        }
    }
}

#[test]
fn one_picture_of_the_built_in_scene() {
    Case::new(mobula::builtin::scene(), (77, 43)).check(true);
}

#[test]
fn one_picture_in_fog() {
    let mut scene = mobula::builtin::scene();
    scene.media = vec![Arc::new(Fog::new(0.06))];
    Case::new(scene, (53, 31)).check(false);
}

#[test]
fn one_picture_through_translucent_particles() {
    let mut scene = mobula::builtin::scene();
    let glass = scene.add_material("glass", Phong { transparency: 0.3, ..Phong::default() });
    scene.add(Particles::example(glass));
    Case::new(scene.clone(), (77, 43)).check(true);
    scene.media = vec![Arc::new(Fog::new(0.06))];
    Case::new(scene, (37, 23)).check(false);
}

/// A volume around the middle of the built-in scene.
fn volume(preset: Preset, lit: bool, high: f64) -> Volume {
    let value = |i: usize| {
        let p = [i % 23, i / 23 % 17, i / 391].map(|x| x as f64 / 8.0);
        (100.0 + 60.0 * (2.1 * p[0]).sin() + 60.0 * (3.3 * p[1] + p[0]).cos() + 30.0 * (5.0 * p[2]).sin()) as u8
    };
    let voxels: Vec<u8> = (0..23 * 17 * 11).map(value).collect();
    let place = GridPlace { origin: DVec3::new(-2.0, high, -1.5), ..GridPlace::with_spacing([0.2, 0.15, 0.3]) };
    let grid = Grid::new([23, 17, 11], voxels.into(), place, [1.0, 0.0]).unwrap();
    let series = Series::new(vec![Arc::new(Field::new(Arc::new(grid)).unwrap())]);
    let mut volume = Volume::new("waves", series, Arc::new(preset.function([0.0, 255.0])));
    volume.lit = lit;
    volume
}

#[test]
fn one_picture_of_volumes_among_other_things() {
    let mut scene = mobula::builtin::scene();
    scene.media = vec![Arc::new(volume(Preset::Bone, true, 0.2))];
    Case::new(scene.clone(), (53, 31)).check(false);
    // Two that overlap, and fog around them.
    scene.media.push(Arc::new(volume(Preset::Viridis, false, 1.0)));
    scene.media.push(Arc::new(Fog::new(0.06)));
    Case::new(scene, (37, 23)).check(false);
}

/// Every kind of geometry with every material under every light, before one background after the other, seen by one camera after the
/// other, in packets of three widths each.
#[test]
fn one_picture_of_all_that_the_tables_name() {
    if is_forced() {
        return;
    }
    let backgrounds: Vec<_> = BackgroundKind::ALL.iter().map(|kind| (kind, kind.build())).collect();
    let mut seen = HashSet::new();
    let mut next_width = PacketWidth::ALL.iter().cycle();
    let (mut next_background, mut next_camera) = (backgrounds.iter().cycle(), CameraKind::ALL.iter().cycle());
    for (kind, &material) in
        KINDS.iter().flat_map(|kind| MaterialKind::ALL.iter().map(move |material| (kind, material)))
    {
        for &light in LightKind::ALL {
            let (Some((background, made)), Some(&camera)) = (next_background.next(), next_camera.next()) else {
                return;
            };
            let mut scene = SceneDescription { geometry: vec![(kind.example)(0)], ..SceneDescription::default() };
            scene.materials.push(NamedMaterial { name: material.to_string(), material: material.build() });
            scene.lights.push(light.build());
            scene.background = Arc::clone(made);
            scene.ground = (**background == BackgroundKind::Daylight).then(Ground::default);
            let case = Case::new(scene, (20, 13));
            let name = format!("{}, {material}, {light}, {background}, {camera}", kind.name);
            // Widths take turns too.
            let some_widths = [(); 3].map(|()| *next_width.next().unwrap_or(&PacketWidth::ALL[0]));
            for fused in [false, true] {
                let tokens: Vec<_> = AnyToken::available().filter(|token| token.fused() == fused).collect();
                let all = tokens.iter().flat_map(|&token| some_widths.map(|packet| (token, packet)));
                let settings = |(token, packet)| Settings { token, packet, camera, threads: 1, ..Settings::default() };
                let mut pictures = all.map(|how| case.picture(settings(how)));
                let Some(first) = pictures.next() else { continue };
                // Clear glass is not seen before white, and mirrors before black.
                if first.chunks(4).any(|pixel| pixel != &first[..4]) {
                    seen.extend([kind.name, material.name(), light.name(), background.name(), camera.name()]);
                }
                assert!(pictures.all(|other| other == first), "{name}");
            }
        }
    }
    let kinds = KINDS.iter().map(|kind| kind.name).chain(MaterialKind::NAMES.iter().copied());
    let others = [LightKind::NAMES, BackgroundKind::NAMES, CameraKind::NAMES].concat();
    let unseen: Vec<&str> = kinds.chain(others).filter(|name| !seen.contains(name)).collect();
    assert_eq!(unseen, [""; 0], "in no picture there was anything to be seen");
}

#[test]
fn one_picture_of_a_terrain() {
    Case::new(mobula::generate::generate("gen:terr20k").unwrap(), (64, 64)).check(false);
}

#[test]
fn one_picture_of_a_house() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/fzk_house.obj.gz");
    Case::new(mobula::load::load(&file).unwrap().scene, (80, 53)).check(false);
}

#[test]
fn a_progressive_picture_ends_as_the_whole_one() {
    let case = Case::new(mobula::builtin::scene(), (50, 37));
    let progressive = Settings { traverser: "progressive".parse().unwrap(), threads: 2, ..Settings::default() };
    let whole = case.picture(Settings::default());
    assert!(case.picture(progressive.clone()) != whole, "the first picture is coarse");
    assert!(case.picture_after(12, progressive) == whole, "the last one is not");
}
