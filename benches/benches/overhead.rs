//! What flexibility costs: entering a level at run time, and the rendering stack of components that are chosen at run time,
//! against a bare loop over the same kernels, turn by turn in one process. Both must give the same picture.
//!
//!     cargo bench -p mobula-benches --bench overhead -- [--scene bunny,terr20k] [--level avx512] [--repeat 15]

use std::hint::black_box;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;
use mobula::accel::AccelerationKind;
use mobula::app::{self, PacketWidth, Settings};
use mobula::camera::View;
use mobula::color::to_pixels;
use mobula::geometry::{Geometries, InTree, Mesh};
use mobula::image::Size;
use mobula::material::Lambertian;
use mobula::renderer::RendererKind;
use mobula::sampler::morton::for_each_piece;
use mobula::scene::SceneDescription;
use mobula::stack::Fragment;
use mobula::tone::Tone;
use mobula::traverse::TileSize;
use mobula_benches::clock;
use mobula_benches::scenes::{self, VIEWS};
use mobula_core::bvh::{Bvh, Serial};
use mobula_core::leaf::{Block, TriangleBlock};
use mobula_core::rays::set_vec3;
use mobula_core::simd::{AnyToken, F32Lanes, Level, Task, Token};
use mobula_core::{Column, Columns3, Properties, RayPacket};

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

/// The bare loop: no component, no trait object, one tree of triangles, the packet width a constant.
struct Bare {
    token: AnyToken,
    bvh: Bvh<TriangleBlock>,
    mesh: Mesh,
    /// Base colours by material, linear; the last is the default one.
    colors: Vec<[f32; 3]>,
    view: View,
    side: usize,
    picture: Vec<u32>,
    packets: u64,
}

/// Aims the rays of a packet at its samples: what the pinhole camera does.
struct Aim<'a> {
    view: &'a View,
    side: usize,
    image: &'a [Column<f32, N>; 2],
    packet: &'a mut RayPacket<N>,
}

impl Task for Aim<'_> {
    type Output = ();

    #[inline(always)]
    fn run<T: Token>(self, token: T) {
        let Self { view, side, image, packet } = self;
        let [right, up, forward] = view.basis();
        let (slope, per_pixel) = (token.splat(view.slope()), token.splat(2.0 / side as f32));
        let one = token.splat(1.0);
        for at in (0..N).step_by(T::LANES) {
            let active = packet.active(token, at);
            let sx = (token.load(&image[0][..], at) * per_pixel - one) * slope;
            let sy = (one - token.load(&image[1][..], at) * per_pixel) * slope;
            let axis = |i: usize| token.splat(forward[i]) + sx * token.splat(right[i]) + sy * token.splat(up[i]);
            let d = [axis(0), axis(1), axis(2)];
            let scale = one / (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
            for (column, d) in packet.directions_mut().iter_mut().zip(d) {
                (d * scale).store_masked(&mut column[..], at, active);
            }
        }
    }
}

impl Bare {
    fn frame(&mut self) {
        let TileSize { width, height } = TileSize::default();
        let (mut packet, mut shown) = (RayPacket::<N>::default(), [0; N]);
        let (mut image, mut colors) = ([Column::splat(0.0); 2], Columns3::<N>::default());
        for y0 in (0..self.side).step_by(height) {
            for x0 in (0..self.side).step_by(width) {
                let (x1, y1) = ((x0 + width).min(self.side), (y0 + height).min(self.side));
                for_each_piece(Fragment { channel: 0, x0, y0, x1, y1, step: 1 }, N, |pixels| {
                    packet.reset(0..pixels.len());
                    for (i, pixel) in pixels.iter().enumerate() {
                        image[0][i] = pixel[0] as f32 + 0.5;
                        image[1][i] = pixel[1] as f32 + 0.5;
                    }
                    packet.set_common_origin(self.view.eye);
                    self.token.run(Aim { view: &self.view, side: self.side, image: &image, packet: &mut packet });
                    packet.promise(Properties::NORMALIZED_DIRECTIONS);
                    self.bvh.intersect(self.token, &mut packet);
                    for i in 0..pixels.len() {
                        let mut color = [0.0; 3];
                        if packet.was_hit(i) {
                            let material = self.mesh.material_of(packet.hits.primitive[i] as usize) as usize;
                            color = self.colors[material.min(self.colors.len() - 1)];
                        }
                        set_vec3(&mut colors, i, color.into());
                    }
                    to_pixels(
                        self.token,
                        Tone::default(),
                        colors.each_ref().map(|column| &column[..]),
                        pixels.len(),
                        &mut shown,
                    );
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
    let scene = scenes::scene(view.source, data)?;
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
    let [geometry] = &description.geometry[..] else { return Err("more than one mesh".into()) };
    let mesh = geometry.downcast_ref::<Mesh>().ok_or("not a mesh")?.clone();
    let geometries = Geometries::build(description.geometry.clone(), &AccelerationKind::Bvh.into())?;
    let mut pipeline = app::pipeline_with_geometry(&description, geometries, &settings)?;
    let default = Lambertian::default().diffuse.to_array();
    let materials = description.materials.iter().map(|named| named.material.base_color().to_array());
    let corners = |i: usize| mesh.primitive(i).unwrap_or(TriangleBlock::NOWHERE);
    let mut bare = Bare {
        token,
        bvh: Bvh::triangles(mesh.triangles.len(), 0, &Serial, corners),
        colors: materials.chain([default]).collect(),
        mesh: mesh.clone(),
        view,
        side,
        picture: vec![0; side * side],
        packets: 0,
    };
    let (mut of_bare, mut of_stack, mut ratios) = (Vec::new(), Vec::new(), Vec::new());
    for _ in 0..arguments.repeat {
        let ((), elapsed) = clock::time(|| (0..FRAMES).for_each(|_| bare.frame()));
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
