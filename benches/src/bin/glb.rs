//! Loads a GLB file, and beside that reads it and decodes its images and nothing else, turn by turn:
//! `cargo run --release -p mobula-benches --bin glb -- FILE`. `benches/reference/glb.py` makes such a file.

use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;
use std::{fs, thread};

use clap::Parser;
use mobula::load;
use mobula_benches::clock;
use mobula_benches::report::Spread;
use serde_json::Value;

/// Loads a GLB file beside decoding its images.
#[derive(Debug, Parser)]
struct Options {
    file: PathBuf,
    /// Turns.
    #[arg(long, default_value_t = 7)]
    repeat: usize,
}

fn main() -> ExitCode {
    match run(&Options::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("glb: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(options: &Options) -> Result<(), Box<dyn Error + Send + Sync>> {
    let (mut loads, mut decodes) = (Vec::new(), Vec::new());
    let mut images = 0;
    for _ in 0..options.repeat {
        let (loaded, elapsed) = clock::time(|| load::load(&options.file));
        loaded?;
        loads.push([elapsed.wall, elapsed.process]);
        let (decoded, elapsed) = clock::time(|| decode(&options.file));
        images = decoded?;
        decodes.push([elapsed.wall, elapsed.process]);
    }
    println!("{}", clock::machine(clock::tick_frequency()));
    println!("{}: {} bytes, {images} images", options.file.display(), fs::metadata(&options.file)?.len());
    for (i, clock) in ["wall clock", "processor time"].into_iter().enumerate() {
        let [load, decode] = [&loads, &decodes].map(|all| Spread::of(all.iter().map(|times| times[i])).median);
        let ratio = Spread::of(loads.iter().zip(&decodes).map(|(load, decode)| load[i] / decode[i]));
        println!(
            "{clock}: {:.0} ms to load, {:.0} ms to read it and decode its images: {:.2} / {:.2} / {:.2}",
            load * 1e3,
            decode * 1e3,
            ratio.min,
            ratio.median,
            ratio.max
        );
    }
    Ok(())
}

/// Reads the file, and decodes its images with as many threads as there are processors.
fn decode(file: &PathBuf) -> Result<usize, Box<dyn Error + Send + Sync>> {
    let bytes = fs::read(file)?;
    let number = |at: usize| u32::from_le_bytes([0, 1, 2, 3].map(|i| bytes[at + i])) as usize;
    let (json, binary) = (&bytes[20..20 + number(12)], &bytes[20 + number(12) + 8..]);
    let document: Value = serde_json::from_slice(json)?;
    let field = |value: &Value, name: &str| value[name].as_u64().unwrap_or(0) as usize;
    let images: Vec<&[u8]> = document["images"]
        .as_array()
        .into_iter()
        .flatten()
        .map(|image| &document["bufferViews"][field(image, "bufferView")])
        .map(|view| &binary[field(view, "byteOffset")..][..field(view, "byteLength")])
        .collect();
    let threads = thread::available_parallelism()?.get();
    thread::scope(|scope| {
        let parts: Vec<_> = (0..threads)
            .map(|first| {
                let images = &images;
                scope.spawn(move || {
                    images.iter().skip(first).step_by(threads).all(|image| load::picture::decode(image, None).is_ok())
                })
            })
            .collect();
        parts.into_iter().all(|part| part.join().unwrap_or(false)).then_some(()).ok_or("an image cannot be decoded")
    })?;
    Ok(images.len())
}
