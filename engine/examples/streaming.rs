//! Measures what it costs to stream steps of particles from disk: frames a second standing still, and while time goes on.
//!
//! `cargo run --release --example streaming -- [PARTICLES] [THREADS]`; 2.8 million by default, for which the temporary folder needs 400 MB.

use std::error::Error;
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use mobula::accel::AccelerationKind;
use mobula::app::{self, Settings, Streamer};
use mobula::image::Size;
use mobula::load::series::Gathering;
use mobula::load::{Memory, Options, load_with};
use mobula::pipeline::{Display, DisplayStage, Picture, Shown};
use mobula::scene::{ParticleLook, SceneDescription, Steps, show_particles};

const STEPS: usize = 8;
/// Steps that are in memory.
const IN_MEMORY: u64 = 3;
const SECONDS: Duration = Duration::from_secs(8);

/// Notes when frames are shown.
struct Clock(Arc<Mutex<Vec<Instant>>>);

impl Display for Clock {
    fn name(&self) -> &str {
        "clock"
    }

    fn show(&mut self, _: &Picture<'_>) -> Result<Shown, Box<dyn Error + Send + Sync>> {
        self.0.lock().expect("no panic").push(Instant::now());
        Ok(Shown::Continue)
    }
}

/// A step as binary PLY: particles in a cube that turn around its axis, each with a temperature.
fn write(file: &Path, count: usize, step: usize) -> std::io::Result<()> {
    let names = ["x", "y", "z", "temperature"].map(|name| format!("property float {name}\n")).concat();
    let mut bytes =
        format!("ply\nformat binary_little_endian 1.0\nelement vertex {count}\n{names}end_header\n").into_bytes();
    let mut random = 1_u64;
    let mut next = || {
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (random >> 40) as f32 / (1 << 24) as f32
    };
    for _ in 0..count {
        let [x, y, z] = [next(), next(), next()].map(|x| x - 0.5);
        let (sin, cos) = (0.02 * step as f32).sin_cos();
        for number in [x * cos - z * sin, y, x * sin + z * cos, x] {
            bytes.extend(number.to_le_bytes());
        }
    }
    fs::File::create(file)?.write_all(&bytes)
}

fn scene(files: &[PathBuf], memory: u64) -> Result<SceneDescription, Box<dyn Error>> {
    let options = Options { memory: Memory::new(memory), ..Options::default() };
    let mut all = Gathering::new(&options, load_with);
    for file in files {
        if !all.defers(file) {
            all.add(file.clone(), load_with(file, &options)?);
        }
    }
    let mut scene = all.join().swap_remove(0).loaded.scene;
    let look = ParticleLook { radius: Some(0.004), ..ParticleLook::default() };
    let steps = Steps { all: true, memory, ..Steps::default() };
    show_particles(&mut scene, |_| look.clone(), steps, &AccelerationKind::Bvh.into())?;
    Ok(scene)
}

/// Renders for some time; `pace` is the time between two steps, none standing still. Prints frames a second, the longest frame, and steps.
fn measure(scene: &SceneDescription, threads: usize, what: &str, pace: Option<Duration>) -> Result<(), Box<dyn Error>> {
    let settings = Settings { size: Size::new(1024, 768)?, threads, ..Settings::default() };
    let mut pipeline = app::pipeline(scene, &settings)?;
    let times = Arc::new(Mutex::new(Vec::new()));
    pipeline.add_stage(DisplayStage::new().with(0, Clock(Arc::clone(&times))));
    let handle = pipeline.handle();
    let streamer = Streamer::start(pipeline.state(), handle.clone(), |problem| eprintln!("{problem}"))?;
    let (mut step, mut due) = (0, Instant::now());
    std::thread::scope(|scope| -> Result<(), Box<dyn Error>> {
        let run = scope.spawn(|| pipeline.run_until_stopped());
        let start = Instant::now();
        while start.elapsed() < SECONDS {
            if let (Some(streamer), Some(pace)) = (&streamer, pace)
                && !streamer.waits()
                && Instant::now() >= due
            {
                (step, due) = (step + 1, Instant::now() + pace);
                streamer.show(step % STEPS);
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        handle.stop();
        run.join().expect("no panic")?;
        Ok(())
    })?;
    let times = times.lock().expect("no panic");
    let longest = times.windows(2).map(|pair| pair[1] - pair[0]).max().unwrap_or_default();
    let fps = times.len() as f64 / SECONDS.as_secs_f64();
    println!("{what:<22}{fps:>10.2}{:>12.0}{:>10.2}", longest.as_secs_f64() * 1e3, step as f64 / SECONDS.as_secs_f64());
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let count = arguments.next().map_or(Ok(2_800_000), |text| text.parse())?;
    let threads = arguments.next().map_or(Ok(Settings::default().threads), |text| text.parse())?;
    let folder = std::env::temp_dir().join(format!("mobula-streaming-{}", std::process::id()));
    fs::create_dir_all(&folder)?;
    let files: Vec<_> = (0..STEPS).map(|step| folder.join(format!("step-{step}.ply"))).collect();
    files.iter().enumerate().try_for_each(|(step, file)| write(file, count, step))?;
    let memory = IN_MEMORY * 34 * count as u64;
    let scene = scene(&files, memory)?;
    println!(
        "{count} particles a step, {STEPS} steps, room for {IN_MEMORY} of them; {threads} render threads, 1024x768, shadows"
    );
    println!("{:<22}{:>10}{:>12}{:>10}", "", "frames/s", "longest ms", "steps/s");
    measure(&scene, threads, "standing still", None)?;
    measure(&scene, threads, "a step a second", Some(Duration::from_secs(1)))?;
    measure(&scene, threads, "as fast as it goes", Some(Duration::ZERO))?;
    fs::remove_dir_all(&folder)?;
    Ok(())
}
