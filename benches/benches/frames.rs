//! Whole frames: Mobula's pipeline beside a bare loop around Embree that makes the same picture: the same camera, flat
//! shading with one point light and constant ambient light, the same conversion to pixels. One thread, turn by turn. The views are
//! those of the bench `peers`, as far as they show triangles.
//!
//!     cargo bench -p mobula-benches --features embree --bench frames -- [--scene bunny,terr1m] [--level avx512,avx2,sse2]
//!         [--repeat 5] [--record FILE --date YYYY-MM-DD]

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

use clap::Parser;
use mobula::app::{self, Chosen, PacketWidth, Settings};
use mobula::background::Constant;
use mobula::camera::View;
use mobula::color::to_pixels;
use mobula::geometry::Mesh;
use mobula::image::Size;
use mobula::light::{Hemisphere, Point};
use mobula::material::Lambertian;
use mobula::renderer::RendererKind;
use mobula::sampler::morton;
use mobula::scene::SceneDescription;
use mobula::tone::Tone;
use mobula_benches::clock;
use mobula_benches::embree::{Device, Entry, Interface, Quality, Scene};
use mobula_benches::rays::{Found, NOTHING, RaySet};
use mobula_benches::report::Spread;
use mobula_benches::scenes::{self, Primitives, Triangles, VIEWS};
use mobula_core::rays::set_vec3;
use mobula_core::simd::{AnyToken, Level, Task, Token};
use mobula_core::{Column, Columns3};

/// Measures frames.
#[derive(Debug, Parser)]
struct Arguments {
    /// Views by name; all unless named.
    #[arg(long, value_delimiter = ',')]
    scene: Vec<String>,
    /// Levels.
    #[arg(long, value_delimiter = ',', default_value = "avx512,avx2,sse2")]
    level: Vec<Level>,
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

const TILE: usize = 16;
/// The constant ambient light.
const AMBIENT: f32 = 0.2;
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
        named.material = Arc::new(Lambertian::new(named.material.base_color()));
    }
    scene.lights = vec![Arc::new(Point { position: view.light.into(), color: glam::Vec3::ONE, falloff: false })];
    let ambient = glam::Vec3::splat(AMBIENT);
    scene.ambient = Arc::new(Hemisphere { above: ambient, below: ambient });
    scene.background = Arc::new(Constant { color: glam::Vec3::ZERO });
    let fov = 2.0 * view.tangent.atan().to_degrees();
    Ok((scene, View { eye: view.eye.into(), at: view.at.into(), up: view.up.into(), fov }))
}

/// The bare loop.
struct Bare<'a> {
    token: AnyToken,
    scene: &'a Scene<'a>,
    interface: Interface,
    triangles: &'a Triangles,
    /// Base colours by triangle, linear.
    colors: &'a [glam::Vec3],
    view: View,
    /// Pixels a side.
    side: usize,
    light: glam::Vec3,
    rays: RaySet,
    found: Found,
    shadow: RaySet,
    blocked: Found,
    picture: Vec<u32>,
}

/// Rays that start at one point and go nowhere yet.
fn rays_from(origin: [f32; 3]) -> RaySet {
    let mut rays = RaySet::default();
    (0..TILE * TILE).for_each(|_| rays.push(origin, [0.0; 3], f32::INFINITY));
    rays
}

/// A frame of the bare loop, compiled for the level as a whole.
struct Frame<'a, 'b> {
    bare: &'a mut Bare<'b>,
    shadows: bool,
}

impl Task for Frame<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<T: Token>(self, _: T) {
        let (bare, shadows) = (self.bare, self.shadows);
        let places: [[u32; 2]; TILE * TILE] = std::array::from_fn(|i| morton::decode(i as u32));
        let (across, basis) = (bare.view.slope(), bare.view.basis());
        let across_tiles = bare.side / TILE;
        for tile in 0..across_tiles.pow(2) {
            let corner = [tile % across_tiles * TILE, tile / across_tiles * TILE];
            let pixel = |i: usize| [corner[0] + places[i][0] as usize, corner[1] + places[i][1] as usize];
            bare.aim(across, basis, pixel);
            bare.scene.intersect(bare.interface, &bare.rays, &mut bare.found);
            if shadows {
                bare.shade(pixel);
            } else {
                let mut shown = [Column::splat(0.0); 3];
                for i in 0..TILE * TILE {
                    let hit = bare.found.primitive[i];
                    let color = if hit == NOTHING { glam::Vec3::ZERO } else { bare.colors[hit as usize] };
                    set_vec3(&mut shown, i, color);
                }
                bare.write(&shown, pixel);
            }
        }
    }
}

impl Bare<'_> {
    #[inline(always)]
    fn aim(&mut self, slope: f32, [right, up, forward]: [glam::Vec3; 3], pixel: impl Fn(usize) -> [usize; 2]) {
        let [dx, dy, dz] = &mut self.rays.direction;
        let per_pixel = 2.0 / self.side as f32;
        for i in 0..TILE * TILE {
            let [x, y] = pixel(i);
            let sx = ((x as f32 + 0.5) * per_pixel - 1.0) * slope;
            let sy = (1.0 - (y as f32 + 0.5) * per_pixel) * slope;
            let d = forward + right * sx + up * sy;
            let d = d * (1.0 / d.dot(d).sqrt());
            (dx[i], dy[i], dz[i]) = (d.x, d.y, d.z);
        }
    }

    #[inline(always)]
    fn shade(&mut self, pixel: impl Fn(usize) -> [usize; 2]) {
        let mut facing = [0u8; TILE * TILE];
        let mut lit = [0.0f32; TILE * TILE];
        let mut count = 0;
        self.shadow.t_max.clear();
        for i in 0..TILE * TILE {
            let hit = self.found.primitive[i];
            if hit == NOTHING {
                continue;
            }
            let (origin, direction) = self.rays.ray(i);
            let (origin, direction) = (glam::Vec3::from(origin), glam::Vec3::from(direction));
            let [a, b, c] = self.triangles.corners(hit as usize).map(glam::Vec3::from);
            let normal = (b - a).cross(c - a);
            let normal = normal * (1.0 / normal.dot(normal).sqrt());
            let normal = if normal.dot(direction) > 0.0 { -normal } else { normal };
            let position = origin + direction * self.found.t[i];
            let to_light = self.light - position;
            let distance = to_light.dot(to_light).sqrt();
            let cosine = to_light.dot(normal) * (1.0 / distance);
            if cosine > 0.0 {
                // As far off the surface as Mobula's shading goes.
                let size = position.abs().max_element().max(self.found.t[i]).max(distance);
                let v = position + normal * (size * (1.0 / 262_144.0)) - self.light;
                let distance = v.length();
                for axis in 0..3 {
                    self.shadow.direction[axis][count] = v[axis] * (1.0 / distance);
                }
                self.shadow.t_max.push(distance);
                (facing[count], lit[i]) = (i as u8, cosine);
                count += 1;
            }
        }
        self.scene.occluded(self.interface, &self.shadow, &mut self.blocked);
        for (k, &i) in facing[..count].iter().enumerate() {
            if self.blocked.hit(k, true) {
                lit[usize::from(i)] = 0.0;
            }
        }
        let mut shown = [Column::splat(0.0); 3];
        for i in 0..TILE * TILE {
            let hit = self.found.primitive[i];
            let color = if hit == NOTHING { glam::Vec3::ZERO } else { self.colors[hit as usize] * (AMBIENT + lit[i]) };
            set_vec3(&mut shown, i, color);
        }
        self.write(&shown, pixel);
    }

    /// Writes the pixels of a tile's colours, by the same kernel as Mobula.
    fn write(&mut self, shown: &Columns3<{ TILE * TILE }>, pixel: impl Fn(usize) -> [usize; 2]) {
        let mut pixels = [0; TILE * TILE];
        to_pixels(self.token, Tone::default(), shown.each_ref().map(|column| &column[..]), TILE * TILE, &mut pixels);
        for (i, &color) in pixels.iter().enumerate() {
            let [x, y] = pixel(i);
            self.picture[y * self.side + x] = color;
        }
    }
}

/// Pixels that differ by more than one step in a channel, and those that differ at all.
fn differences(a: impl Iterator<Item = u32>, b: &[u32]) -> [usize; 2] {
    a.zip(b).fold([0; 2], |[far, any], (a, &b)| {
        let step = a.to_le_bytes().iter().zip(b.to_le_bytes()).map(|(a, b)| a.abs_diff(b)).max().unwrap_or(0);
        [far + usize::from(step > 1), any + usize::from(step > 0)]
    })
}

/// The fastest of Embree's interfaces at one frame each.
fn best_interface(bare: &mut Bare<'_>, device: &Device, shadows: bool) -> Interface {
    let mut time = |interface| {
        bare.interface = interface;
        let token = bare.token;
        (interface, clock::time(|| token.run(Frame { bare: &mut *bare, shadows })).1.process)
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
    let default = Lambertian::default().diffuse;
    let color =
        |material: u32| description.materials.get(material as usize).map_or(default, |m| m.material.base_color());
    let meshes = description.geometry.iter().filter_map(|geometry| geometry.downcast_ref::<Mesh>());
    let colors: Vec<glam::Vec3> =
        meshes.flat_map(|mesh| (0..mesh.triangles.len()).map(|i| color(mesh.material_of(i)))).collect();
    assert_eq!(colors.len(), triangles.indices.len(), "both have the same triangles");
    let isa = match level {
        Level::Scalar | Level::Sse2 => "sse2",
        Level::Avx2 => "avx2",
        Level::Avx512 => "avx512",
    };
    let device = Device::new(isa, 1)?;
    let scene = Scene::new(&device, &primitives, Quality::Medium)?;
    let side = view.pixels as usize;
    let mut bare = Bare {
        token,
        scene: &scene,
        interface: Interface { entry: Entry::Sixteen, coherent: true },
        triangles,
        colors: &colors,
        view: camera,
        side,
        light: view.light.into(),
        rays: rays_from(view.eye),
        found: Found::new(TILE * TILE),
        shadow: rays_from(view.light),
        blocked: Found::new(TILE * TILE),
        picture: vec![0; side * side],
    };
    let size = Size::new(side, side)?;
    let packet = PacketWidth::best(level);
    let settings = Settings { token, packet, threads: 1, size, view: Some(camera), ..Settings::default() };
    let mut pipeline = app::pipeline(&description, &settings)?;
    let frames = arguments.frames * (1024 * 1024 / size.pixels()).max(1);
    for (what, renderer) in [("primary", RendererKind::Primary), ("shadows", RendererKind::Raytracer)] {
        let shadows = renderer == RendererKind::Raytracer;
        let state = pipeline.state();
        let chosen = Chosen { renderer, ..*state.chosen() };
        state.choose(chosen);
        bare.interface = best_interface(&mut bare, &device, shadows);
        let (mut theirs, mut ours) = (Vec::new(), Vec::new());
        for _ in 0..arguments.repeat {
            let (report, elapsed) = clock::time(|| pipeline.run(frames as u64));
            report?;
            ours.push(elapsed.process / frames as f64);
            let bare_frames = || (0..frames).for_each(|_| token.run(Frame { bare: &mut bare, shadows }));
            theirs.push(clock::time(bare_frames).1.process / frames as f64);
        }
        let (_, picture) = pipeline.picture(0).ok_or("no picture")?;
        let [far, any] = differences(picture.pixels(), &bare.picture);
        if far > size.pixels() / BAND {
            return Err(format!("{what}: {far} pixels differ from Embree's").into());
        }
        let rate = |times: &[f64]| size.pixels() as f64 * 1e-6 / Spread::of(times.iter().copied()).median;
        let ratio = Spread::of(theirs.iter().zip(&ours).map(|(embree, mobula)| embree / mobula));
        table.ratios.push((level, what, ratio.median));
        table.add(format!(
            "| {name} | {level} | {what} | {} | {:.2} | {:.2} | {:.2} / **{:.2}** / {:.2} | {far}, {any} |",
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
    ratios: Vec<(Level, &'static str, f64)>,
}

impl Table {
    fn add(&mut self, line: String) {
        println!("{line}");
        self.text.push_str(&line);
        self.text.push('\n');
    }

    /// A line for each level and kind of frame.
    fn summary(&mut self, levels: &[Level]) {
        for (level, what) in levels.iter().flat_map(|&level| ["primary", "shadows"].map(|what| (level, what))) {
            let all = self.ratios.iter().filter(|of| (of.0, of.1) == (level, what)).map(|of| of.2);
            let (count, logarithms) = all.clone().fold((0, 0.0), |(count, sum), ratio| (count + 1, sum + ratio.ln()));
            if count == 0 {
                continue;
            }
            let least = all.fold(f64::INFINITY, f64::min);
            let mean = (logarithms / f64::from(count)).exp();
            self.add(format!("\n{level}, {what}: geometric mean of {count} views {mean:.2}, the least {least:.2}"));
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
    table.summary(&arguments.level);
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
colours. Last: pixels that differ by more than one step of a channel, and at all: ties of surfaces that lie in one another, and
edges.

| view | level | frame | Embree's best | Mpixel/s | Mobula | ratio | pixels that differ |
|---|---|---|---|---|---|---|---|";
