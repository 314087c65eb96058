//! A pipeline of one's own: a renderer, a display, and transactions from another thread.

use std::error::Error;
use std::time::Duration;

use mobula::image::{Size, rgba8};
use mobula::pipeline::{Balance, Config, Display, DisplayStage, Frame, Picture, Pipeline, Shown, stage};

/// The state: what the frames show.
struct Scene {
    colour: u8,
}

/// A display that prints one pixel of each picture.
struct Print;

impl Display for Print {
    fn name(&self) -> &str {
        "print"
    }

    fn show(&mut self, picture: &Picture<'_>) -> Result<Shown, Box<dyn Error + Send + Sync>> {
        println!("frame {}: pixel (0, 0) is {:08x}", picture.frame, picture.buffer.get(0, 0));
        Ok(Shown::Continue)
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut pipeline = Pipeline::new(Scene { colour: 0 }, Config::with_threads(2))?;
    pipeline.add_channel("main", Size::new(64, 48)?);
    pipeline.add_stage(stage("render", Balance::Balanced, |frame: &Frame<'_, Scene>| {
        let (scene, picture) = (frame.state, frame.channels()[0].buffer);
        let row = vec![rgba8(scene.colour, 0, 0, 255); picture.width()];
        for y in (frame.thread..picture.height()).step_by(frame.threads) {
            picture.set_row(0, y, &row);
        }
    }));
    pipeline.add_stage(DisplayStage::new().with(0, Print));
    pipeline.callbacks().at_frame("dark again", 8, |point| point.state.colour = 0);

    let handle = pipeline.handle();
    let sender = std::thread::spawn(move || {
        let seen = handle.send("brighten", |scene| scene.colour = 255).wait();
        println!("the first bright frame is {seen:?}");
        std::thread::sleep(Duration::from_millis(1));
    });
    let report = pipeline.run(10)?;
    sender.join().expect("the sender does not panic");
    println!("{} frames, {:.0} per second", report.frames, report.frames_per_second());
    Ok(())
}
