//! Mobula inside a program: a renderer and a display of its own, and a change from another thread.

use std::error::Error;
use std::sync::Arc;

use mobula::accel::AccelerationKind;
use mobula::app::Components;
use mobula::image::Size;
use mobula::pipeline::{Config, DisplayStage, Picture, Shown, display};
use mobula::scene::Scene;
use mobula::stack::{Context, Renderer};
use mobula_core::{RayPacket, rays::set_vec3};
use mobula_simd::AnyToken;

/// A renderer: things fade with the distance, by this much a unit.
struct Fog(f32);

impl Renderer<64> for Fog {
    fn trace(&self, context: &Context<'_, 64>, packet: &mut RayPacket<64>) {
        packet.reset_hits();
        context.scene.intersect(context, packet);
        for i in packet.range() {
            let light = if packet.was_hit(i) { (-self.0 * packet.t_max[i]).exp() } else { 0.0 };
            set_vec3(&mut packet.color, i, glam::Vec3::splat(light));
        }
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let scene = Scene::build(&mobula::builtin::scene(), AccelerationKind::Bvh)?;
    let mut components = Components::new(AnyToken::detect(), scene, 4.0 / 3.0);
    components.renderer = Arc::new(Fog(0.01));
    let mut pipeline = components.pipeline(Size::new(160, 120)?, Config::with_threads(2))?;
    let brightness = display("brightness", |picture: &Picture<'_>| {
        println!("frame {}: {}", picture.frame, picture.buffer.pixels().map(|pixel| pixel & 0xff).sum::<u32>());
        Ok(Shown::Continue)
    });
    pipeline.add_stage(DisplayStage::new().with(0, brightness));
    let handle = pipeline.handle();
    let other = std::thread::spawn(move || {
        while handle.progress().frames < 3 {
            std::thread::yield_now();
        }
        let shown = handle.send("thicker fog", |state| state.renderer = Arc::new(Fog(0.1))).wait();
        handle.stop();
        shown
    });
    pipeline.run_until_stopped()?;
    println!("the fog thickened in frame {}", other.join().expect("it does not panic")?);
    Ok(())
}
