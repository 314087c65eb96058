//! Every component of the rendering stack is made to panic in some frame and on some thread: each time an error that
//! names it, within a second, and another engine of the process renders what it always does.

use std::error::Error;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

use glam::Vec3;
use mobula::accel::AccelerationKind;
use mobula::app::{self, Components, Settings};
use mobula::camera::View;
use mobula::image::{FrameBuffer, Size};
use mobula::packet::{Packet, SubPacket};
use mobula::pipeline::{Config, Display, DisplayStage, Fault, Picture, Shown};
use mobula::scene::build;
use mobula::stack::{
    Background, Camera, Context, Fragment, Illumination, Light, Lit, Material, PixelSampler, Receivers, Renderer,
};
use mobula_simd::AnyToken;
use proptest::prelude::*;
use proptest::test_runner::TestRunner;

/// Panics when it has been called so often, and notes when. Calls come from all threads, so any of them may be struck.
#[derive(Clone, Debug)]
struct Bomb(Arc<AtomicU64>, Arc<OnceLock<Instant>>);

impl Bomb {
    fn new(calls: u64) -> Self {
        Self(Arc::new(AtomicU64::new(calls)), Arc::default())
    }

    fn tick(&self) {
        if self.0.fetch_sub(1, Ordering::Relaxed) == 0 {
            let _ = self.1.set(Instant::now());
            panic!("boom");
        }
    }
}

/// A component that works until its bomb goes off.
#[derive(Debug)]
struct Frail<T: ?Sized>(Bomb, Arc<T>);

impl Camera for Frail<dyn Camera> {
    fn make_rays(&self, context: &Context<'_>, size: [u32; 2], packet: &mut Packet) {
        self.0.tick();
        self.1.make_rays(context, size, packet);
    }
}

impl PixelSampler for Frail<dyn PixelSampler> {
    fn render_fragment(&self, context: &Context<'_>, camera: &dyn Camera, fragment: Fragment, out: &FrameBuffer) {
        self.0.tick();
        self.1.render_fragment(context, camera, fragment, out);
    }
}

impl Renderer for Frail<dyn Renderer> {
    fn trace(&self, context: &Context<'_>, packet: &mut Packet) {
        self.0.tick();
        self.1.trace(context, packet);
    }
}

impl Background for Frail<dyn Background> {
    fn shade(&self, context: &Context<'_>, misses: &mut SubPacket<'_>) {
        self.0.tick();
        self.1.shade(context, misses);
    }
}

impl Light for Frail<dyn Light> {
    fn illuminate(&self, context: &Context<'_>, points: Receivers<'_>, out: &mut Illumination) {
        self.0.tick();
        self.1.illuminate(context, points, out);
    }

    fn position(&self, context: &Context<'_>) -> Option<Vec3> {
        self.1.position(context)
    }
}

/// A material that is one colour.
#[derive(Debug)]
struct Plain(Bomb);

impl Material for Plain {
    fn shade(&self, _: &Context<'_>, hits: &mut SubPacket<'_>, _: Lit<'_>) {
        self.0.tick();
        hits.fill_color(Vec3::ONE);
    }

    fn describe(&self) -> String {
        "plain".to_owned()
    }

    fn base_color(&self) -> Vec3 {
        Vec3::ONE
    }
}

struct FrailDisplay(Bomb);

impl Display for FrailDisplay {
    fn name(&self) -> &str {
        "frail display"
    }

    fn show(&mut self, _: &Picture<'_>) -> Result<Shown, Box<dyn Error + Send + Sync>> {
        self.0.tick();
        Ok(Shown::Continue)
    }
}

/// Puts a bomb into the component of a name, and returns what becomes of the run and how long after the bomb.
fn strike(component: &str, calls: u64, threads: usize) -> (Fault, Duration) {
    let bomb = Bomb::new(calls);
    let exploded = Arc::clone(&bomb.1);
    let scene = mobula::generate::generate("gen:terr20k").expect("a known scene");
    let scene = build(&scene, AccelerationKind::Bvh).expect("few triangles");
    let mut parts = Components::new(AnyToken::detect(), scene, 1.5);
    let never = Bomb::new(u64::MAX);
    let mut display = never.clone();
    match component {
        "camera" => parts.cameras[0] = Arc::new(Frail(bomb, Arc::clone(&parts.cameras[0]))),
        "pixel sampler" => parts.sampler = Arc::new(Frail(bomb, Arc::clone(&parts.sampler))),
        "renderer" => parts.renderer = Arc::new(Frail(bomb, Arc::clone(&parts.renderer))),
        "background" => {
            parts.scene.background = Arc::new(Frail(bomb, Arc::clone(&parts.scene.background)));
            let view = parts.scene.view(1.5);
            parts.set_view(0, View { at: view.eye * 2.0 - view.at, ..view }); // away from all else
        }
        "light" => parts.scene.lights[0] = Arc::new(Frail(bomb, Arc::clone(&parts.scene.lights[0]))),
        "frail display" => display = bomb,
        _ => {
            for index in 0..16 {
                parts.scene.materials.set(index, Arc::new(Plain(bomb.clone())));
            }
        }
    }
    let size = Size::new(96, 64).expect("a valid size");
    let mut pipeline = parts.pipeline(size, Config::with_threads(threads)).expect("a valid thread count");
    pipeline.add_stage(DisplayStage::new().with(0, FrailDisplay(display)));
    let fault = pipeline.run(1000).expect_err("the bomb goes off");
    let after = exploded.get().expect("the bomb noted it").elapsed();
    assert_eq!(pipeline.run(1).expect_err("it is finished"), fault);
    assert_eq!(pipeline.into_state().token, AnyToken::detect(), "the state survives");
    (fault, after)
}

#[test]
fn every_component_in_any_frame_on_any_thread() {
    // Another engine of the process, before, meanwhile and after.
    let scene = mobula::builtin::scene();
    let settings = Settings { size: Size::new(48, 32).expect("a valid size"), threads: 2, ..Settings::default() };
    let mut bystander = app::pipeline(&scene, &settings).expect("a small scene");
    bystander.run(1).expect("nothing fails");
    let before: Vec<u32> = bystander.picture(0).expect("a picture").1.pixels().collect();

    const COMPONENTS: [&str; 7] =
        ["camera", "pixel sampler", "renderer", "material", "light", "background", "frail display"];
    let places = (prop::sample::select(&COMPONENTS[..]), 0..200_u64, prop::sample::select(vec![1_usize, 2, 8]));
    let mut runner = TestRunner::new(ProptestConfig::with_cases(40));
    let result = runner.run(&places, |(component, calls, threads)| {
        // A machine that is busy with something else may take its time once or twice: one of three is enough.
        let strikes = std::iter::repeat_with(|| strike(component, calls, threads)).take(3);
        let soon = strikes.filter(|(_, after)| *after < Duration::from_secs(1)).map(|(fault, _)| fault).next();
        let fault = soon.expect("a fault is told within a second");
        // A material is named as the scene names it.
        let expected = if component == "material" { "material ground" } else { component };
        prop_assert_eq!(&fault.component, expected, "{}", fault);
        prop_assert_eq!(&fault.message, "boom", "{}", fault);
        prop_assert!(fault.thread < threads && fault.location.is_some(), "{}", fault);
        Ok(())
    });
    result.unwrap();

    bystander.run(1).expect("nothing fails");
    assert!(before.iter().copied().eq(bystander.picture(0).expect("a picture").1.pixels()));
}
