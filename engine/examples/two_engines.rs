//! Two engines in one process, at once: neither sees the other.

use std::error::Error;

use mobula::app::{self, Settings};
use mobula::image::Size;
use mobula::scene::SceneDescription;

/// Renders so many frames of a scene; returns the last picture.
fn picture(scene: &SceneDescription, frames: u64) -> Result<Vec<u32>, Box<dyn Error + Send + Sync>> {
    let settings = Settings { size: Size::new(96, 64)?, threads: 2, ..Settings::default() };
    let mut pipeline = app::pipeline(scene, &settings)?;
    let report = pipeline.run(frames)?;
    assert_eq!(report.frames, frames);
    let (_, buffer) = pipeline.picture(0).ok_or("no picture")?;
    Ok(buffer.pixels().collect())
}

fn main() -> Result<(), Box<dyn Error + Send + Sync>> {
    let terrain = mobula::generate::generate("gen:terr20k").ok_or("no such scene")?;
    let reef = mobula::builtin::scene();
    let alone = [picture(&terrain, 1)?, picture(&reef, 1)?];
    let together = std::thread::scope(|scope| {
        let other = scope.spawn(|| picture(&reef, 20));
        let mine = picture(&terrain, 20);
        [mine, other.join().expect("it does not panic")]
    });
    for (together, alone) in together.into_iter().zip(&alone) {
        assert!(together? == *alone, "an engine renders what it renders alone");
    }
    assert_ne!(alone[0], alone[1]);
    println!("{} and {} at once: the pictures are those of each alone", terrain.name, reef.name);
    Ok(())
}
