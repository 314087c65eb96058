//! What flexibility costs: entering a level at run time, and the rendering stack of components that are chosen at run time,
//! against a bare loop over the same kernels, turn by turn in one process. Both must give the same picture.
//!
//!     cargo bench -p mobula-benches --bench overhead -- [--scene bunny,terr20k] [--level avx512] [--repeat 15]

use std::hint::black_box;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

use clap::Parser;
use mobula::app::{self, PacketWidth, Settings};
use mobula::camera::{Pinhole, View};
use mobula::color::to_pixels;
use mobula::image::Size;
use mobula::renderer::{Primary, RendererKind};
use mobula::sampler::morton::for_each_piece;
use mobula::scene::{Geometry, Scene, SceneDescription};
use mobula::stack::{Camera, Context, Fragment, Statistics};
use mobula::traverse::TileSize;
use mobula::{generate, load};
use mobula_benches::clock;
use mobula_benches::scenes::VIEWS;
use mobula_core::bvh::{Bvh, Serial};
use mobula_core::leaf::{Block, TriangleBlock};
use mobula_core::rays::set_vec3;
use mobula_core::simd::{AnyToken, Level, Task, Token};
use mobula_core::{Properties, RayPacket};

/// Measures what flexibility costs.
#[derive(Debug, Parser)]
struct Arguments {
    /// Scenes by name.
    #[arg(long, value_delimiter = ',', default_value = "bunny,terr20k,terr1m")]
    scene: Vec<String>,
    /// Levels; all unless named.
    #[arg(long, value_delimiter = ',')]
    level: Vec<Level>,
    /// Turns.
    #[arg(long, default_value_t = 15)]
    repeat: usize,
    /// Side of the square picture.
    #[arg(long, default_value_t = 512)]
    side: usize,
    /// Folder of the meshes.
    #[arg(long, default_value = concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/data/meshes"))]
    data: PathBuf,
    /// What `cargo bench` adds.
    #[arg(long, hide = true)]
    bench: bool,
}

/// The packet width.
const N: usize = 64;
/// Frames in a turn: a pipeline starts its threads in every run.
const FRAMES: usize = 10;

/// Nothing but entering and leaving the level.
struct Nothing<'a>(&'a mut u32);

impl Task for Nothing<'_> {
    type Output = ();

    #[inline(always)]
    fn run<T: Token>(self, _token: T) {
        *self.0 = self.0.wrapping_add(T::LANES as u32);
    }
}

/// Seconds that it takes to choose a level and to enter it.
fn dispatch(token: AnyToken) -> f64 {
    const TIMES: u32 = 1_000_000;
    let mut sum = 0;
    let ((), elapsed) = clock::time(|| (0..TIMES).for_each(|_| black_box(token).run(Nothing(black_box(&mut sum)))));
    elapsed.process / f64::from(TIMES)
}

/// The bare loop: no component, no trait object, one tree of triangles.
struct Bare {
    bvh: Bvh<TriangleBlock>,
    geometry: Arc<Geometry>,
    /// Base colours by material, linear.
    colors: Vec<[f32; 3]>,
    camera: Pinhole,
    side: usize,
    picture: Vec<u32>,
    packets: u64,
}

impl Bare {
    fn frame(&mut self, context: &Context<'_, N>) {
        let size = [self.side as u32; 2];
        let TileSize { width, height } = TileSize::default();
        let (mut packet, mut shown) = (RayPacket::<N>::default(), [0; N]);
        for y0 in (0..self.side).step_by(height) {
            for x0 in (0..self.side).step_by(width) {
                let (x1, y1) = ((x0 + width).min(self.side), (y0 + height).min(self.side));
                for_each_piece::<N>(Fragment { channel: 0, x0, y0, x1, y1, step: 1 }, N, |pixels| {
                    packet.reset(0..pixels.len());
                    for (i, pixel) in pixels.iter().enumerate() {
                        packet.image[0][i] = pixel[0] as f32 + 0.5;
                        packet.image[1][i] = pixel[1] as f32 + 0.5;
                    }
                    packet.promise(Properties::HAVE_IMAGE_COORDINATES);
                    Camera::<N>::make_rays(&self.camera, context, size, &mut packet);
                    packet.reset_hits();
                    self.bvh.intersect(context.token, &mut packet);
                    let mut near = 0;
                    for i in 0..pixels.len() {
                        let mut color = [0.0; 3];
                        if packet.was_hit(i) {
                            let material = self.geometry.material(packet.hits.primitive[i], &mut near) as usize;
                            color = self.colors[material.min(self.colors.len() - 1)];
                        }
                        set_vec3(&mut packet.color, i, color.into());
                    }
                    to_pixels(context.token, &packet.color, pixels.len(), &mut shown);
                    for (&[x, y], &color) in pixels.iter().zip(&shown) {
                        self.picture[y as usize * self.side + x as usize] = color;
                    }
                    self.packets += 1;
                });
            }
        }
    }
}

fn describe(name: &str, data: &std::path::Path) -> Result<(SceneDescription, View), String> {
    let view = VIEWS.iter().find(|view| view.name == name).ok_or_else(|| format!("no scene {name}"))?;
    let scene = if view.source.starts_with(generate::PREFIX) {
        generate::generate(view.source).ok_or_else(|| format!("no generator {}", view.source))?
    } else {
        load::load(&data.join(view.source)).map_err(|error| error.to_string())?.scene
    };
    let fov = 2.0 * view.tangent.atan().to_degrees();
    Ok((scene, View { eye: view.eye.into(), at: view.at.into(), up: view.up.into(), fov }))
}

/// The least of some times.
fn least(times: &[f64]) -> f64 {
    times.iter().copied().fold(f64::INFINITY, f64::min)
}

fn median(times: &mut [f64]) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

fn measure(name: &str, token: AnyToken, arguments: &Arguments) -> Result<(), Box<dyn std::error::Error>> {
    let (description, view) = describe(name, &arguments.data)?;
    let geometry = Arc::new(Geometry::new(&description.objects)?);
    let side = arguments.side;
    let settings = Settings {
        token,
        packet: PacketWidth::W64,
        threads: 1,
        size: Size::new(side, side)?,
        view: Some(view),
        renderer: RendererKind::Primary,
        ..Settings::default()
    };
    assert_eq!(settings.packet.to_string(), N.to_string(), "the bare loop has the same width");
    let mut pipeline = app::pipeline_with_geometry(&description, geometry.clone(), &settings)?;
    let scene = Scene::<N>::with_geometry(&description, geometry.clone(), settings.acceleration);
    let statistics = Statistics::default();
    let context = Context { token, scene: &scene, renderer: &Primary, statistics: &statistics, frame: 0 };
    let ids = geometry.triangle_ids();
    // The last one is the default.
    let color = |index: usize| scene.material(index as u32).base_color().to_array();
    let corners = |i: usize| {
        geometry.triangle(ids.start + i as u32).map_or(TriangleBlock::NOWHERE, |corners| corners.map(|p| p.to_array()))
    };
    let mut bare = Bare {
        bvh: Bvh::triangles(ids.len(), ids.start, &Serial, corners),
        colors: (0..=description.materials.len()).map(color).collect(),
        geometry: geometry.clone(),
        camera: Pinhole::new(view),
        side,
        picture: vec![0; side * side],
        packets: 0,
    };
    let (mut of_bare, mut of_stack, mut ratios) = (Vec::new(), Vec::new(), Vec::new());
    for _ in 0..arguments.repeat {
        let ((), elapsed) = clock::time(|| (0..FRAMES).for_each(|_| bare.frame(&context)));
        let (report, of_pipeline) = clock::time(|| pipeline.run(FRAMES as u64));
        report?;
        of_bare.push(elapsed.process / FRAMES as f64);
        of_stack.push(of_pipeline.process / FRAMES as f64);
        ratios.push(elapsed.process / of_pipeline.process);
    }
    let (_, picture) = pipeline.picture(0).ok_or("no picture")?;
    let different = picture.pixels().zip(&bare.picture).filter(|(a, b)| a != *b).count();
    assert_eq!(different, 0, "{name}: pixels of the bare loop differ from those of the stack");
    let packets = bare.packets as f64 / (arguments.repeat * FRAMES) as f64;
    let rays = (side * side) as f64;
    let dispatch = least(&(0..9).map(|_| dispatch(token)).collect::<Vec<_>>());
    let per_packet = least(&of_bare) / packets;
    println!(
        "| {name} | {} | {:.1} | {:.1} | {:.3} | {:.3} | {:.1} | {:.0} | {:.2} % |",
        token.level(),
        rays / least(&of_bare) * 1e-6,
        rays / least(&of_stack) * 1e-6,
        least(&of_bare) / least(&of_stack),
        median(&mut ratios),
        dispatch * 1e9,
        per_packet * 1e9,
        100.0 * dispatch / per_packet
    );
    Ok(())
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    println!("{}\n", clock::machine(clock::tick_frequency()));
    println!("Mrays/s of primary rays, the least times of {} turns; the same pictures.\n", arguments.repeat);
    println!("| scene | level | bare | stack | stack / bare | median of turns | dispatch ns | packet ns | share |");
    println!("|---|---|---|---|---|---|---|---|---|");
    for name in &arguments.scene {
        for token in AnyToken::available() {
            if !arguments.level.is_empty() && !arguments.level.contains(&token.level()) {
                continue;
            }
            if let Err(error) = measure(name, token, &arguments) {
                eprintln!("skipped: {name}: {error}");
            }
        }
    }
    ExitCode::SUCCESS
}
