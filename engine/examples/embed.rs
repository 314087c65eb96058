//! Mobula inside a program: a renderer and a display of its own, and a change from another thread.

use mobula::prelude::*;

/// A renderer: things fade with the distance, by this much a unit.
struct Fog(f32);

impl Renderer for Fog {
    fn trace(&self, context: &Context<'_>, packet: &mut Packet) {
        context.scene.intersect(context, packet);
        for i in 0..packet.len() {
            let light = if packet.was_hit(i) { (-self.0 * packet.rays().t_max()[i]).exp() } else { 0.0 };
            set_vec3(&mut packet.color, i, Vec3::splat(light));
        }
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let size = Size::new(160, 120)?;
    let mut components = Components::build(&mobula::builtin::scene(), size)?;
    components.renderer = Arc::new(Fog(0.01));
    let mut pipeline = components.pipeline(size, Config::with_threads(2))?;
    let brightness = display("brightness", |picture: &Picture<'_>| {
        println!("frame {}: {}", picture.frame, picture.buffer.pixels().map(|pixel| pixel & 0xff).sum::<u32>());
        Ok(Shown::Continue)
    });
    pipeline.add_stage(DisplayStage::new().with(0, brightness));
    let handle = pipeline.handle();
    let other = std::thread::spawn(move || {
        std::thread::sleep(std::time::Duration::from_millis(50));
        let frame = handle.send("thicker fog", |state| state.renderer = Arc::new(Fog(0.1))).wait();
        handle.stop();
        frame
    });
    pipeline.run_until_stopped()?;
    println!("the fog thickened in frame {}", other.join().expect("it does not panic")?);
    Ok(())
}
