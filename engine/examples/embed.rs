//! Mobula inside a program: a renderer and a display of its own, and changes from another thread.

use std::error::Error;
use std::sync::{Arc, Mutex};

use mobula::accel::AccelerationKind;
use mobula::app::{Components, Stack};
use mobula::balance::BalancerKind;
use mobula::image::{FrameBuffer, Size};
use mobula::pipeline::{Config, Display, DisplayStage, Frame, Picture, Pipeline, Shown};
use mobula::scene::Scene;
use mobula::stack::{Context, Fragment, Renderer, Statistics};
use mobula::traverse::{RenderStage, TileSize, TraverserKind};
use mobula_core::{RayPacket, rays::set_vec3};
use mobula_simd::AnyToken;

/// Rays in a packet.
const N: usize = 64;

/// A renderer: things fade with the distance, by this much a unit.
struct Fog(f32);

impl Renderer<N> for Fog {
    fn trace(&self, context: &Context<'_, N>, packet: &mut RayPacket<N>) {
        packet.reset_hits();
        context.scene.intersect(context, packet);
        for i in packet.range() {
            let light = if packet.was_hit(i) { (-self.0 * packet.t_max[i]).exp() } else { 0.0 };
            set_vec3(&mut packet.color, i, glam::Vec3::splat(light));
        }
    }
}

/// A display: how bright each frame is.
struct Brightness(Arc<Mutex<Vec<u32>>>);

impl Display for Brightness {
    fn name(&self) -> &str {
        "brightness"
    }

    fn show(&mut self, picture: &Picture<'_>) -> Result<Shown, Box<dyn Error + Send + Sync>> {
        let sum = picture.buffer.pixels().map(|pixel| pixel & 0xff).sum();
        self.0.lock().map_err(|_| "a reader failed")?.push(sum);
        Ok(Shown::Continue)
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let scene = Scene::<N>::build(&mobula::builtin::scene(), AccelerationKind::Bvh)?;
    let components = Components::new(AnyToken::detect(), scene, 4.0 / 3.0);
    let mut pipeline =
        Pipeline::new(Components { renderer: Arc::new(Fog(0.01)), ..components }, Config::with_threads(2))?;
    pipeline.add_channel("main", Size::new(160, 120)?);
    let traverser = TraverserKind::Tiled.build(TileSize::default(), BalancerKind::default());
    let render = |frame: &Frame<'_, Components<N>>, fragment: &Fragment, out: &FrameBuffer| {
        frame.state.render(*fragment, out, &Statistics::default());
    };
    pipeline.add_stage(RenderStage::new(traverser, render));
    let seen = Arc::<Mutex<Vec<u32>>>::default();
    pipeline.add_stage(DisplayStage::new().with(0, Brightness(Arc::clone(&seen))));

    let handle = pipeline.handle();
    let other = std::thread::spawn(move || {
        while handle.progress().frames < 2 {
            std::thread::yield_now();
        }
        let frame = handle.send("thicker fog", |state| state.renderer = Arc::new(Fog(0.1))).wait();
        handle.stop();
        frame
    });
    let report = pipeline.run_until_stopped()?;
    let frame = other.join().expect("the other thread does not panic")?;
    let seen = seen.lock().expect("the display does not panic");
    println!("{} frames; the fog thickens in frame {frame}: {seen:?}", report.frames);
    assert!(seen.len() as u64 == report.frames && frame >= 2);
    let thick = seen.get(frame as usize..).unwrap_or_default();
    assert!(thick.iter().all(|&light| light < seen[0]) && seen[..2].iter().all(|&light| light == seen[0]));
    Ok(())
}
