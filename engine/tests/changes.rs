//! Transactions change anything of the state, and each change is in the next frame: it is the picture of an engine that was built that
//! way.

use std::sync::Arc;

use glam::{DVec3, Vec3};
use mobula::accel::AccelerationKind;
use mobula::app::{self, Settings, State};
use mobula::background::Constant;
use mobula::camera::{CameraKind, Orthographic, View};
use mobula::geometry::{
    Cloud, Coloring, Field, Geometries, Geometry, Mesh, Opacity, OpacityCurve, Particles, Series, Spheres,
};
use mobula::image::Size;
use mobula::light::{Directional, Hemisphere, Point};
use mobula::material::{Flat, Lambertian, Phong};
use mobula::medium::{Fog, Volume};
use mobula::particles::{Attribute, ParticleStep, Values};
use mobula::pipeline::Pipeline;
use mobula::renderer::RendererKind;
use mobula::sampler::SamplerKind;
use mobula::scene::{Map, SceneDescription};
use mobula::volume::{ColorMap, Grid, GridPlace, Preset};

const VIEW: View = View { eye: Vec3::new(1.0, 4.0, 6.0), at: Vec3::ZERO, up: Vec3::Y, fov: 45.0 };

/// A pane and a ball over a floor.
fn geometry(height: f32) -> Vec<Arc<dyn Geometry>> {
    let square = |side: f32, y: f32| vec![[-side, y, -side], [side, y, -side], [side, y, side], [-side, y, side]];
    let triangles = vec![[0, 2, 1], [0, 3, 2]];
    vec![
        Arc::new(Mesh { positions: square(4.0, 0.0), triangles: triangles.clone(), material: 0, ..Mesh::default() }),
        Arc::new(Mesh { positions: square(1.0, height), triangles, material: 1, ..Mesh::default() }),
        Arc::new(Spheres { centers: vec![[-1.5, 0.5, 1.0]], radii: vec![0.5], material: 2, ..Spheres::default() }),
        Arc::new(particles()),
    ]
}

/// Rows of particles, hotter from left to right; in the second step there are more of them.
fn particles() -> Particles {
    let cloud = |count: usize| {
        let at = |i: usize| i as f32 / count as f32;
        let heat = Values::F32((0..count).map(|i| 100.0 * at(i)).collect());
        let step = ParticleStep {
            centers: (0..count).map(|i| [4.0 * at(i) - 2.0, 0.3, 2.0]).collect(),
            attributes: vec![Attribute { name: "heat".to_owned(), values: heat }],
            ..ParticleStep::default()
        };
        Arc::new(Cloud::new(step, 0.12, &AccelerationKind::Bvh.into()).expect("few particles"))
    };
    let mut particles = Particles::new("row", vec![cloud(7), cloud(23)], 2);
    let map = ColorMap::new(&Preset::Viridis.function([0.0, 1.0]), [0.0, 100.0]);
    particles.coloring = Some(Coloring { attribute: "heat".to_owned(), map: Arc::new(map) });
    particles
}

/// The particles, of which the hot ones are opaque.
fn translucent() -> Particles {
    let curve = OpacityCurve::rising([0.0, 60.0]);
    let mut particles = particles();
    particles.opacity = Opacity::By { attribute: "heat".to_owned(), curve };
    particles
}

/// The geometry with other particles.
fn with_particles(particles: Particles) -> Vec<Arc<dyn Geometry>> {
    let mut all = geometry(1.5);
    *all.last_mut().expect("there are some") = Arc::new(particles);
    all
}

fn description() -> SceneDescription {
    let mut scene = SceneDescription { geometry: geometry(1.5), view: Some(VIEW), ..SceneDescription::default() };
    scene.add_material("floor", Lambertian::new(Vec3::new(0.6, 0.5, 0.4)));
    scene.add_material("pane", Phong::default());
    scene.add_material("ball", Flat::new(Vec3::X));
    scene.add_light(Directional { direction: Vec3::new(0.3, 1.0, 0.2), color: Vec3::ONE });
    scene.media.push(Arc::new(volume()));
    scene
}

/// Waves of values from 0 to 222 that move from step to step, over the floor.
fn volume() -> Volume {
    let field = |step: usize| {
        let wave = |i: usize| (i * 37 + 50 * step) % 223;
        let place = GridPlace { origin: DVec3::new(-1.0, 0.2, -1.0), ..GridPlace::with_spacing([0.25; 3]) };
        let voxels: Vec<u8> = (0..729).map(|i| wave(i / 9) as u8).collect();
        Arc::new(Field::new(Arc::new(Grid::new([9; 3], voxels.into(), place, [1.0, 0.0]).unwrap())).unwrap())
    };
    let series = Series::new((0..2).map(field).collect());
    let function = Arc::new(Preset::Bone.function(series.range()));
    let mut volume = Volume::new("waves", series, function);
    volume.lit = true;
    volume
}

fn settings() -> Settings {
    Settings { size: Size::new(60, 40).expect("a valid size"), threads: 2, ..Settings::default() }
}

fn picture(pipeline: &mut Pipeline<State>) -> Vec<u8> {
    pipeline.run(1).expect("nothing fails");
    pipeline.picture(0).expect("a picture").1.to_rgba8()
}

/// Renders a frame, sends a transaction, renders another one: its picture.
fn picture_after(
    pipeline: &mut Pipeline<State>,
    name: &'static str,
    make: impl FnOnce(&mut State) + Send + 'static,
) -> Vec<u8> {
    let (sender, tickets) = std::sync::mpsc::channel();
    let (handle, next) = (pipeline.handle(), pipeline.picture(0).map_or(0, |(frame, _)| frame + 1));
    pipeline.callbacks().at_frame("sender", next, move |_| {
        sender.send(handle.send(name, make)).expect("the test listens");
    });
    pipeline.run(2).expect("nothing fails");
    let changed = tickets.recv().expect("it was sent").wait().expect("it was carried out");
    let (frame, picture) = pipeline.picture(0).expect("a picture");
    assert_eq!((changed, frame), (next + 1, next + 1), "{name}: it is in the next frame");
    picture.to_rgba8()
}

/// A change as a transaction makes it, and an engine that was built that way.
struct Change {
    name: &'static str,
    make: fn(&mut State),
    describe: fn(&mut SceneDescription, &mut Settings),
}

const CHANGES: &[Change] = &[
    Change {
        name: "a material that becomes transparent",
        make: |state| state.stack.scene.materials.set(1, Arc::new(Phong { transparency: 0.7, ..Phong::default() })),
        describe: |scene, _| scene.materials[1].material = Arc::new(Phong { transparency: 0.7, ..Phong::default() }),
    },
    Change {
        name: "a light in place of another",
        make: |state| state.stack.scene.lights[0] = Arc::new(Point { position: Vec3::Y * 3.0, ..Point::default() }),
        describe: |scene, _| scene.lights[0] = Arc::new(Point { position: Vec3::Y * 3.0, ..Point::default() }),
    },
    Change {
        name: "one more light",
        make: |state| state.stack.scene.lights.push(Arc::new(Directional::default())),
        describe: |scene, _| scene.add_light(Directional::default()),
    },
    Change {
        name: "ambient light",
        make: |state| state.stack.scene.ambient = Arc::new(Hemisphere { above: Vec3::X, below: Vec3::Y }),
        describe: |scene, _| scene.ambient = Arc::new(Hemisphere { above: Vec3::X, below: Vec3::Y }),
    },
    Change {
        name: "another camera",
        make: |state| state.stack.set_camera(0, Arc::new(Orthographic::new(VIEW))),
        describe: |_, settings| settings.camera = CameraKind::Orthographic,
    },
    Change {
        name: "another view",
        make: |state| state.stack.set_view(0, View { eye: Vec3::new(-3.0, 5.0, 4.0), ..VIEW }),
        describe: |scene, _| scene.view = Some(View { eye: Vec3::new(-3.0, 5.0, 4.0), ..VIEW }),
    },
    Change {
        name: "geometry that moved",
        make: |state| state.stack.scene.geometry.refit(geometry(2.0)).expect("the same primitives"),
        describe: |scene, _| scene.geometry = geometry(2.0),
    },
    Change {
        name: "less geometry",
        make: |state| {
            let fewer = geometry(1.5).split_off(1);
            state.stack.scene.geometry =
                Geometries::build(fewer, &AccelerationKind::Bvh.into()).expect("few primitives");
        },
        describe: |scene, _| scene.geometry = geometry(1.5).split_off(1),
    },
    Change {
        name: "a background",
        make: |state| state.stack.scene.background = Arc::new(Constant { color: Vec3::Z }),
        describe: |scene, _| scene.background = Arc::new(Constant { color: Vec3::Z }),
    },
    Change {
        name: "a medium",
        make: |state| state.stack.scene.media = vec![Arc::new(Fog::new(0.1))],
        describe: |scene, _| scene.media = vec![Arc::new(Fog::new(0.1))],
    },
    Change {
        name: "level and width of a volume, and another step of time",
        make: |state| {
            state.set_window([120.0, 100.0]);
            state.set_step(1);
        },
        describe: |scene, _| {
            scene.media = vec![Arc::new(volume().with_window([120.0, 100.0]).at(1))];
            scene.geometry = with_particles(particles().at(1).unwrap());
        },
    },
    Change {
        name: "what is shown of particles, in a step with more of them, and back",
        make: |state| {
            state.set_step(1);
            state.set_crop("heat", [20.0, 60.0]);
            state.set_step(0);
        },
        describe: |scene, _| scene.geometry = with_particles(particles().cropped("heat", [20.0, 60.0])),
    },
    Change {
        name: "particles that become translucent",
        make: |state| state.stack.scene.geometry.refit(with_particles(translucent())).expect("the same primitives"),
        describe: |scene, _| scene.geometry = with_particles(translucent()),
    },
    Change {
        name: "other colours of particles",
        make: |state| state.color_particles("heat", Some(&Map::Preset(Preset::Turbo))),
        describe: |scene, _| {
            let (mut particles, range) = (particles(), particles().range("heat").expect("it is there"));
            let map = Arc::new(ColorMap::new(&Preset::Turbo.function([0.0, 1.0]), range));
            particles.coloring = Some(Coloring { attribute: "heat".to_owned(), map });
            scene.geometry = with_particles(particles);
        },
    },
    Change {
        name: "a transfer function",
        make: |state| state.set_transfer(|range| Preset::Viridis.function(range), false),
        describe: |scene, _| {
            let mut shown = volume().with_function(Arc::new(Preset::Viridis.function(volume().series().range())));
            shown.lit = false;
            scene.media = vec![Arc::new(shown)];
        },
    },
    Change {
        name: "no shadows",
        make: |state| state.stack.scene.shadows = false,
        describe: |_, settings| settings.shadows = false,
    },
    Change {
        name: "a renderer",
        make: |state| state.stack.renderer = RendererKind::Normal.build(),
        describe: |_, settings| settings.renderer = RendererKind::Normal,
    },
    Change {
        name: "a pixel sampler",
        make: |state| state.stack.sampler = SamplerKind::of_samples(4).build(),
        describe: |_, settings| settings.sampler = SamplerKind::of_samples(4),
    },
];

#[test]
fn every_change_is_in_the_next_frame() {
    for change in CHANGES {
        let mut changed = app::pipeline(&description(), &settings()).expect("a small scene");
        let before = picture(&mut changed);
        let after = picture_after(&mut changed, change.name, change.make);
        assert!(before != after, "{}: nothing to be seen", change.name);

        let (mut scene, mut settings) = (description(), settings());
        (change.describe)(&mut scene, &mut settings);
        let mut built = app::pipeline(&scene, &settings).expect("a small scene");
        assert!(after == picture(&mut built), "{}: not what an engine built that way shows", change.name);
    }
}

#[test]
fn a_change_of_the_packet_width_is_not_to_be_seen() {
    let mut pipeline = app::pipeline(&description(), &settings()).expect("a small scene");
    let before = picture(&mut pipeline);
    for &width in app::PacketWidth::ALL {
        let after = picture_after(&mut pipeline, "width", move |state| state.stack.width = width);
        assert!(before == after, "packets of {width}");
        assert_eq!(pipeline.state().stack.width, width);
    }
}

/// A picture with so many samples a pixel, in one frame.
fn whole(sampler: SamplerKind, occlusion: Option<f32>) -> Vec<u8> {
    let settings = Settings { sampler, occlusion, ..settings() };
    picture(&mut app::pipeline(&description(), &settings).expect("a small scene"))
}

#[test]
fn refined_pictures_are_those_of_as_many_samples() {
    for (sampler, occlusion, threads) in
        [("sobol:7", None, 2), ("sobol:5:mitchell", Some(3.0), 1), ("sobol:2", None, 3)]
    {
        let sampler: SamplerKind = sampler.parse().expect("a sampler");
        let settings = Settings { sampler, occlusion, threads, on_demand: true, ..settings() };
        let mut pipeline = app::pipeline(&description(), &settings).expect("a small scene");
        pipeline.state().refine(settings.balancer);
        let shown = pipeline.state().shown_samples().expect("it is refined").clone();
        let look = |pipeline: &mut Pipeline<State>, frames: u64| {
            pipeline.run(frames).expect("nothing fails");
            let (frame, picture) = pipeline.picture(0).expect("a picture");
            (shown.of(frame), picture.to_rgba8())
        };
        // The setup of a run counts as a change: each run begins anew.
        for frames in 1..=u64::from(sampler.samples()) + 1 {
            let (samples, picture) = look(&mut pipeline, frames);
            let taken = frames as u32 - 1;
            assert_eq!(samples, if taken >= sampler.samples().min(4) { taken } else { 1 }, "{sampler}, frame {frames}");
            let expected = whole(sampler.after(samples), occlusion);
            assert!(picture == expected, "{sampler}: {samples} samples differ from those of one frame");
        }
    }
}

#[test]
fn refined_pictures_begin_anew_after_changes_and_come_to_rest() {
    let sampler = SamplerKind::of_samples(5);
    let settings = Settings { sampler, on_demand: true, ..settings() };
    let mut pipeline = app::pipeline(&description(), &settings).expect("a small scene");
    pipeline.state().refine(settings.balancer);
    let shown = pipeline.state().shown_samples().expect("it is refined").clone();
    let handle = pipeline.handle();
    let rest = |frames: u64| {
        let start = std::time::Instant::now();
        while handle.progress().frames < frames {
            assert!(start.elapsed().as_secs() < 60, "{:?} of {frames} frames", handle.progress());
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
        std::thread::sleep(std::time::Duration::from_millis(50));
        assert_eq!(handle.progress().frames, frames, "it does not rest");
    };
    std::thread::scope(|scope| {
        let run = scope.spawn(|| pipeline.run_until_stopped().expect("nothing fails"));
        rest(6);
        handle.send("no shadows", |state| state.stack.scene.shadows = false);
        rest(12);
        assert_eq!(shown.of(11), 5);
        // Another frame without a change keeps what is there.
        handle.at_barrier("frame", |point| point.request_frame());
        rest(13);
        assert_eq!(shown.of(12), 5);
        handle.send("hold", |state| state.hold(true));
        rest(14);
        assert_eq!(shown.of(13), 1);
        handle.at_barrier("let go", |point| {
            point.state.hold(false);
            point.request_frame();
        });
        rest(19);
        handle.stop();
        run.join().expect("no panic");
    });
    let mut scene = description();
    scene.name = "without shadows".to_owned();
    let mut built =
        app::pipeline(&scene, &Settings { shadows: false, on_demand: false, ..settings }).expect("a small scene");
    let (frame, refined) = pipeline.picture(0).expect("a picture");
    assert_eq!((frame, refined.to_rgba8()), (18, picture(&mut built)));
}
