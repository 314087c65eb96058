//! Storms of changes in everything that is rendered: no frame sees half of one, and the last picture is that of the state
//! that the storm leads to.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};

use glam::Vec3;
use mobula::accel::AccelerationKind;
use mobula::app::{Components, PacketWidth};
use mobula::balance::BalancerKind;
use mobula::camera::View;
use mobula::image::{FrameBuffer, Size};
use mobula::packet::{Packet, SubPacket, vec3};
use mobula::pipeline::{Config, Frame, Handle, Pipeline};
use mobula::renderer::RendererKind;
use mobula::scene::{SceneDescription, Spheres, build};
use mobula::stack::{Context, Fragment, Lit, Material, Renderer, Statistics};
use mobula::traverse::{RenderStage, TileSize, TraverserKind};
use mobula_simd::AnyToken;
use proptest::prelude::*;

/// Packets that were looked at.
static LOOKED: AtomicU64 = AtomicU64::new(0);

/// What is rendered. The version is in the camera, in the material and in the renderer; the number of spheres is in the
/// scene and here.
struct World {
    version: u16,
    spheres: usize,
    parts: Components,
}

/// A colour that says which version it is of.
#[derive(Debug)]
struct Paint(u16);

impl Material for Paint {
    fn shade(&self, _: &Context<'_>, hits: &mut SubPacket<'_>, _: Lit<'_>) {
        hits.fill_color(self.base_color());
    }

    fn describe(&self) -> String {
        format!("paint of version {}", self.0)
    }

    fn base_color(&self) -> Vec3 {
        Vec3::new(f32::from(self.0) / 1024.0, 0.5, 0.25)
    }
}

/// Renders as primary rays do, and checks that camera, material and renderer are of one version.
struct Watch(u16);

impl Renderer for Watch {
    fn trace(&self, context: &Context<'_>, packet: &mut Packet) {
        static PRIMARY: OnceLock<Arc<dyn Renderer>> = OnceLock::new();
        let eye = vec3(&packet.rays().origins(), 0);
        assert_eq!(eye, view(self.0).eye, "the camera is of another version than the renderer");
        assert_eq!(
            context.scene.materials.get(0).base_color(),
            Paint(self.0).base_color(),
            "the material is of another version"
        );
        LOOKED.fetch_add(1, Ordering::Relaxed);
        PRIMARY.get_or_init(|| RendererKind::Primary.build()).trace(context, packet);
    }
}

fn view(version: u16) -> View {
    View { eye: Vec3::new(f32::from(version) / 64.0, 2.0, 9.0), at: Vec3::new(1.0, 0.0, 0.0), up: Vec3::Y, fov: 50.0 }
}

fn scene(spheres: usize) -> SceneDescription {
    let at = |i: usize| Vec3::new(i as f32 - 2.0, (i % 3) as f32 * 0.5, -(i as f32)).to_array();
    let all = Spheres { centers: (0..spheres).map(at).collect(), radii: vec![0.7; spheres], ..Spheres::default() };
    SceneDescription { geometry: vec![Arc::new(all)], ..SceneDescription::default() }
}

impl World {
    fn new(version: u16, spheres: usize, kind: AccelerationKind) -> Self {
        let scene = build(&scene(spheres), kind).expect("few spheres");
        let mut parts = Components::new(AnyToken::detect(), scene, 1.5);
        parts.width = PacketWidth::W16;
        let mut world = Self { version, spheres, parts };
        world.set_material(version);
        world.set_camera(version);
        world.set_renderer(version);
        world
    }

    fn set_camera(&mut self, version: u16) {
        self.parts.set_view(0, view(version));
    }

    fn set_material(&mut self, version: u16) {
        self.parts.scene.materials.set(0, Arc::new(Paint(version)));
    }

    fn set_renderer(&mut self, version: u16) {
        self.version = version;
        self.parts.renderer = Arc::new(Watch(version));
    }

    /// Another scene, or another structure over it.
    fn rebuild(&mut self, spheres: usize, kind: AccelerationKind) {
        self.parts.scene = build(&scene(spheres), kind).expect("few spheres");
        self.spheres = spheres;
        self.set_material(self.version);
    }
}

fn pipeline(world: World, size: Size, threads: usize) -> Pipeline<World> {
    let mut pipeline = Pipeline::new(world, Config::with_threads(threads)).expect("a valid count");
    pipeline.add_channel("main", size);
    let traverser = TraverserKind::Tiled.build(TileSize { width: 8, height: 8 }, BalancerKind::ByCost);
    let render = |frame: &Frame<'_, World>, fragment: &Fragment, out: &FrameBuffer| {
        let World { spheres, parts, .. } = frame.state;
        assert_eq!(parts.scene.geometry.list()[0].primitives(), *spheres, "half of a scene");
        parts.render(*fragment, out, &Statistics::default());
    };
    pipeline.add_stage(RenderStage::new(traverser, render));
    pipeline
}

#[derive(Clone, Copy, Debug)]
enum Change {
    /// Camera, material and renderer, in one batch of three.
    Version(u16),
    Scene(usize, AccelerationKind),
    /// The same spheres, by a refit.
    Refit,
    Threads(usize),
    Size(usize, usize),
}

fn change() -> impl Strategy<Value = Change> {
    let kind = prop::sample::select(AccelerationKind::ALL);
    prop_oneof![
        4 => (0..200_u16).prop_map(Change::Version),
        2 => (1..9_usize, kind).prop_map(|(spheres, kind)| Change::Scene(spheres, kind)),
        1 => Just(Change::Refit),
        1 => (1..9_usize).prop_map(Change::Threads),
        1 => (1..40_usize, 1..40_usize).prop_map(|(width, height)| Change::Size(width, height)),
    ]
}

fn send(handle: &Handle<World>, change: Change) {
    match change {
        Change::Version(version) => {
            let batch = handle.batch().add("camera", move |world: &mut World| world.set_camera(version));
            let batch = batch.add("material", move |world: &mut World| world.set_material(version));
            batch.add("renderer", move |world: &mut World| world.set_renderer(version)).send()
        }
        Change::Scene(spheres, kind) => handle.send("scene", move |world| world.rebuild(spheres, kind)),
        Change::Refit => handle.send("refit", |world| {
            world.parts.scene.geometry.refit(scene(world.spheres).geometry).expect("the same spheres");
        }),
        Change::Threads(threads) => handle.set_threads(threads).expect("a valid count"),
        Change::Size(width, height) => handle.resize(0, Size::new(width, height).expect("a valid size")),
    };
}

/// The last of some changes that `pick` picks.
fn last<T>(storm: &[Change], first: T, pick: impl Fn(Change) -> Option<T>) -> T {
    storm.iter().rev().find_map(|&change| pick(change)).unwrap_or(first)
}

fn picture(pipeline: &mut Pipeline<World>) -> Vec<u32> {
    pipeline.picture(0).expect("a picture").1.pixels().collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]

    #[test]
    fn no_frame_sees_half_of_a_change(storm in prop::collection::vec(change(), 1..60), threads in 1..5_usize) {
        let first = Size::new(24, 16).expect("a valid size");
        let mut storming = pipeline(World::new(0, 3, AccelerationKind::Bvh), first, threads);
        let looked = LOOKED.load(Ordering::Relaxed);
        let handle = storming.handle();
        std::thread::scope(|scope| {
            // Versions from one thread, all else from another, while frames are rendered.
            let (versions, others): (Vec<Change>, Vec<Change>) =
                storm.iter().partition(|change| matches!(change, Change::Version(_)));
            let senders = [versions, others].map(|changes| {
                let handle = handle.clone();
                scope.spawn(move || {
                    for change in changes {
                        send(&handle, change);
                        std::thread::sleep(std::time::Duration::from_micros(150));
                    }
                })
            });
            let run = scope.spawn(|| storming.run_until_stopped());
            senders.into_iter().for_each(|sender| sender.join().expect("senders do not panic"));
            // One frame of the final state.
            let done = handle.send("done", |_| ()).wait();
            while done.as_ref().is_ok_and(|&frame| handle.progress().frames <= frame) && !handle.is_stopped() {
                std::thread::yield_now();
            }
            handle.stop();
            run.join().expect("runs do not panic").map(|_| ())
        }).map_err(|fault| TestCaseError::fail(fault.to_string()))?;
        prop_assert!(LOOKED.load(Ordering::Relaxed) > looked);

        let version = last(&storm, 0, |change| if let Change::Version(version) = change { Some(version) } else { None });
        let spheres = last(&storm, 3, |change| if let Change::Scene(spheres, _) = change { Some(spheres) } else { None });
        let size = last(&storm, first, |change| match change {
            Change::Size(width, height) => Size::new(width, height).ok(),
            _ => None,
        });
        let mut calm = pipeline(World::new(version, spheres, AccelerationKind::Bvh), size, 1);
        calm.run(1).map_err(|fault| TestCaseError::fail(fault.to_string()))?;
        prop_assert!(picture(&mut storming) == picture(&mut calm), "another picture than that of the final state");
    }
}
