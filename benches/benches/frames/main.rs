//! Whole frames: Mobula's pipeline beside a bare loop around Embree that makes the same picture: the same camera, textures, flat
//! shading with one point light and constant ambient light, or ambient occlusion, the same conversion to pixels. One thread, turn by
//! turn. The views are those of the bench `peers`, as far as they show triangles.
//!
//!     cargo bench -p mobula-benches --features embree --bench frames -- [--scene bunny,terr1m] [--level avx512,avx2,sse2]
//!         [--frame primary,shadows,ao] [--repeat 5] [--record FILE --date YYYY-MM-DD]

mod bare;
mod surfaces;

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

use clap::Parser;
use mobula::app::{self, Chosen, PacketWidth, Settings};
use mobula::background::Constant;
use mobula::camera::View;
use mobula::geometry::Mesh;
use mobula::image::Size;
use mobula::light::{Hemisphere, Point};
use mobula::material::Lambertian;
use mobula::renderer::RendererKind;
use mobula::scene::SceneDescription;
use mobula::stack::Occlusion;
use mobula::texture::Maps;
use mobula_benches::clock;
use mobula_benches::embree::{Device, Entry, Interface, Quality, Scene};
use mobula_benches::report::Spread;
use mobula_benches::scenes::{self, Primitives, VIEWS};
use mobula_core::simd::{AnyToken, Level};

use bare::Bare;
use surfaces::Surfaces;

/// Measures frames.
#[derive(Debug, Parser)]
struct Arguments {
    /// Views by name; all unless named.
    #[arg(long, value_delimiter = ',')]
    scene: Vec<String>,
    /// Levels.
    #[arg(long, value_delimiter = ',', default_value = "avx512,avx2,sse2")]
    level: Vec<Level>,
    /// Kinds of frames.
    #[arg(long, value_delimiter = ',', default_values = ["primary", "shadows", "ao"])]
    frame: Vec<Shown>,
    /// Rays in Mobula's packets, instead of as many as are usual at the level.
    #[arg(long)]
    packet: Option<PacketWidth>,
    /// Turns.
    #[arg(long, default_value_t = 5)]
    repeat: usize,
    /// Frames in a turn, of a picture of 1024x1024; more of smaller ones.
    #[arg(long, default_value_t = 3)]
    frames: usize,
    /// Folder of the meshes.
    #[arg(long, default_value = concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/data/meshes"))]
    data: PathBuf,
    /// Write the table there as Markdown.
    #[arg(long)]
    record: Option<PathBuf>,
    /// The day that the record names.
    #[arg(long, default_value = "undated")]
    date: String,
    /// What `cargo bench` adds.
    #[arg(long, hide = true)]
    bench: bool,
}

/// What a frame shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Shown {
    /// Base colours, with their textures.
    Primary,
    /// The same, in the light of a point light with shadows.
    Shadows,
    /// How open the sky is.
    #[value(name = "ao")]
    Occlusion,
}

impl Shown {
    const fn name(self) -> &'static str {
        match self {
            Self::Primary => "primary",
            Self::Shadows => "shadows",
            Self::Occlusion => "ao",
        }
    }

    const fn renderer(self) -> RendererKind {
        match self {
            Self::Primary => RendererKind::Primary,
            Self::Shadows => RendererKind::Raytracer,
            Self::Occlusion => RendererKind::AmbientOcclusion,
        }
    }
}

/// The constant ambient light.
const AMBIENT: f32 = 0.2;
/// Rays that ask how open the sky is, of every pixel.
const OCCLUSION_RAYS: u32 = 16;
/// Pixels whose bytes may differ by more than one step, at most one of so many: edges, and surfaces that lie in one another (of the house,
/// seen from outside, one of 350).
const BAND: usize = 300;

/// A scene whose surfaces are all matt and flat, under one light.
fn describe(view: &scenes::View, data: &std::path::Path) -> Result<(SceneDescription, View), String> {
    let mut scene = scenes::seen(view, data)?;
    for geometry in &mut scene.geometry {
        if let Some(mesh) = geometry.downcast_ref::<Mesh>() {
            *geometry = Arc::new(Mesh { normals: Vec::new(), triangle_normals: Vec::new(), ..mesh.clone() });
        }
    }
    for named in &mut scene.materials {
        let maps = Maps { color: named.material.maps().color.clone(), ..Maps::default() };
        named.material = Arc::new(Lambertian { maps, ..Lambertian::new(named.material.base_color()) });
    }
    scene.lights = vec![Arc::new(Point { position: view.light.into(), color: glam::Vec3::ONE, falloff: false })];
    let ambient = glam::Vec3::splat(AMBIENT);
    scene.ambient = Arc::new(Hemisphere { above: ambient, below: ambient });
    scene.background = Arc::new(Constant { color: glam::Vec3::ZERO });
    let fov = 2.0 * view.tangent.atan().to_degrees();
    Ok((scene, View { eye: view.eye.into(), at: view.at.into(), up: view.up.into(), fov }))
}

/// How two pictures of the same differ, in words; an error where they differ too much.
fn difference(shown: Shown, ours: impl Iterator<Item = u32>, theirs: &[u32]) -> Result<String, String> {
    let steps = ours.zip(theirs).map(|(a, b)| {
        let channels = a.to_le_bytes().into_iter().zip(b.to_le_bytes());
        channels.map(|(a, b)| i32::from(a) - i32::from(b)).max_by_key(|step| step.abs()).unwrap_or(0)
    });
    if shown == Shown::Occlusion {
        // Their rays go other ways, so that pixels differ by noise, which vanishes in the mean.
        let (sum, squares) =
            steps.fold((0.0, 0.0), |(sum, squares), step| (sum + f64::from(step), squares + f64::from(step).powi(2)));
        let [mean, deviation] = [sum / theirs.len() as f64, (squares / theirs.len() as f64).sqrt()];
        let text = format!("{mean:.2} of 255 in the mean, deviation {deviation:.1}");
        return if mean.abs() < 1.0 { Ok(text) } else { Err(format!("{}: {text}", shown.name())) };
    }
    let [far, any] =
        steps.fold([0; 2], |[far, any], step| [far + usize::from(step.abs() > 1), any + usize::from(step != 0)]);
    if far > theirs.len() / BAND {
        return Err(format!("{}: {far} pixels differ from Embree's", shown.name()));
    }
    Ok(format!("{far}, {any}"))
}

/// The fastest of Embree's interfaces at one frame each.
fn best_interface(bare: &mut Bare<'_>, device: &Device, shown: Shown) -> Interface {
    let mut time = |interface| {
        bare.interface = interface;
        (interface, clock::time(|| bare.frame(shown)).1.process)
    };
    let tried = Interface::all().filter(|&interface| device.is_native(interface)).map(&mut time);
    let (best, _) = tried.min_by(|a, b| a.1.total_cmp(&b.1)).expect("there are interfaces");
    best
}

fn measure(
    view: &scenes::View,
    level: Level,
    arguments: &Arguments,
    table: &mut Table,
) -> Result<(), Box<dyn std::error::Error>> {
    let (token, name) = (AnyToken::for_level(level)?, view.name);
    let (description, camera) = describe(view, &arguments.data)?;
    let primitives = Primitives::of(&description);
    let Primitives::Triangles(triangles) = &primitives else { return Err("spheres".into()) };
    let surfaces = Surfaces::new(&description, triangles);
    let isa = match level {
        Level::Scalar | Level::Sse2 => "sse2",
        Level::Avx2 => "avx2",
        Level::Avx512 => "avx512",
    };
    let device = Device::new(isa, 1)?;
    let scene = Scene::new(&device, &primitives, Quality::Medium)?;
    let side = view.pixels as usize;
    let interface = Interface { entry: Entry::Sixteen, coherent: true };
    let mut bare = Bare::new(token, &scene, &surfaces, camera, (side, view.light.into(), view.reach), interface);
    let size = Size::new(side, side)?;
    let packet = arguments.packet.unwrap_or(PacketWidth::best(level));
    let settings = Settings { token, packet, threads: 1, size, view: Some(camera), ..Settings::default() };
    let mut pipeline = app::pipeline(&description, &settings)?;
    let frames = arguments.frames * (1024 * 1024 / size.pixels()).max(1);
    for &shown in &arguments.frame {
        let state = pipeline.state();
        let chosen = Chosen { renderer: shown.renderer(), ..*state.chosen() };
        state.choose(chosen);
        if shown == Shown::Occlusion {
            state.stack.scene.occlusion = Some(Occlusion { rays: OCCLUSION_RAYS, distance: view.reach });
        }
        bare.interface = best_interface(&mut bare, &device, shown);
        let (mut theirs, mut ours) = (Vec::new(), Vec::new());
        for _ in 0..arguments.repeat {
            let (report, elapsed) = clock::time(|| pipeline.run(frames as u64));
            report?;
            ours.push(elapsed.process / frames as f64);
            let bare_frames = || (0..frames).for_each(|_| bare.frame(shown));
            theirs.push(clock::time(bare_frames).1.process / frames as f64);
        }
        let (_, picture) = pipeline.picture(0).ok_or("no picture")?;
        let differing = difference(shown, picture.pixels(), &bare.picture)?;
        let rate = |times: &[f64]| size.pixels() as f64 * 1e-6 / Spread::of(times.iter().copied()).median;
        let ratio = Spread::of(theirs.iter().zip(&ours).map(|(embree, mobula)| embree / mobula));
        table.ratios.push((level, shown, ratio.median));
        table.add(format!(
            "| {name} | {level} | {} | {} | {:.2} | {:.2} | {:.2} / **{:.2}** / {:.2} | {differing} |",
            shown.name(),
            bare.interface,
            rate(&theirs),
            rate(&ours),
            ratio.min,
            ratio.median,
            ratio.max
        ));
    }
    Ok(())
}

/// What is printed and recorded.
struct Table {
    text: String,
    ratios: Vec<(Level, Shown, f64)>,
}

impl Table {
    fn add(&mut self, line: String) {
        println!("{line}");
        self.text.push_str(&line);
        self.text.push('\n');
    }

    /// A line for each level and kind of frame.
    fn summary(&mut self, levels: &[Level], frames: &[Shown]) {
        for (level, what) in levels.iter().flat_map(|&level| frames.iter().map(move |&what| (level, what))) {
            let all = self.ratios.iter().filter(|of| (of.0, of.1) == (level, what)).map(|of| of.2);
            let (count, logarithms) = all.clone().fold((0, 0.0), |(count, sum), ratio| (count + 1, sum + ratio.ln()));
            if count == 0 {
                continue;
            }
            let least = all.fold(f64::INFINITY, f64::min);
            let mean = (logarithms / f64::from(count)).exp();
            self.add(format!(
                "\n{level}, {}: geometric mean of {count} views {mean:.2}, the least {least:.2}",
                what.name()
            ));
        }
    }
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let given: Vec<String> = std::env::args().skip(1).filter(|argument| argument != "--bench").collect();
    let mut table = Table { text: String::new(), ratios: Vec::new() };
    table.add(format!(
        "# Frames, {}\n\n- Command: `cargo bench -p mobula-benches --features embree --bench frames -- {}`\n- Machine: {}\n",
        arguments.date,
        given.join(" "),
        clock::machine(clock::tick_frequency())
    ));
    table.add(EXPLANATION.into());
    let mut failed = false;
    let mut fail = |what: &str, error: &dyn std::fmt::Display| {
        eprintln!("{what}: {error}");
        failed = true;
    };
    for name in arguments.scene.iter().filter(|name| !VIEWS.iter().any(|view| view.name == **name)) {
        fail(name, &"there is no such view");
    }
    let named =
        |view: &&scenes::View| arguments.scene.is_empty() || arguments.scene.iter().any(|name| name == view.name);
    for view in VIEWS.iter().filter(named) {
        for &level in &arguments.level {
            if let Err(error) = measure(view, level, &arguments, &mut table) {
                fail(&format!("{} {level}", view.name), &error);
            }
        }
    }
    table.summary(&arguments.level, &arguments.frame);
    if let Some(file) = &arguments.record
        && let Err(error) = std::fs::write(file, &table.text)
    {
        fail(&file.display().to_string(), &error);
    }
    if failed { ExitCode::FAILURE } else { ExitCode::SUCCESS }
}

const EXPLANATION: &str = "\
One thread, Mpixel/s by processor time (medians of the turns); ratios are Mobula's rate over that of the bare loop, turn by turn:
least, median, greatest. Mobula is the whole pipeline: its components, its materials, its frame buffer, with the packets that are
usual at the level. The bare loop makes 256 primary rays a tile, calls Embree 3.13.5 (quality medium, limited to the level's
instructions, the best of its interfaces for this frame), shades, and writes pixels; it is compiled for the level as a whole. Both
shade flat: Lambertian, one point light, shadow rays from the light, constant ambient light, no vertex normals. `primary` shows base
colours; textures, where there are any (`couch`, `chicken`), are filtered trilinearly, by the same function. `ao` is one primary
ray and 16 ambient occlusion rays a pixel, as long as the view's `reach`; the bare loop takes their directions from a table. Last: pixels
that differ by more than one step of a channel, and at all: ties of surfaces that lie in one another, and edges; of `ao`, whose noise
differs, how far apart the pictures are in the mean.

| view | level | frame | Embree's best | Mpixel/s | Mobula | ratio | pixels that differ |
|---|---|---|---|---|---|---|---|";
