//! Whole frames: Mobula's pipeline beside a bare loop around Embree that makes the same picture: the same camera, flat
//! shading with one point light and constant ambient light, the same conversion to pixels. One thread, turn by turn.
//!
//!     cargo bench -p mobula-benches --features embree --bench frames -- [--scene bunny,terr1m] [--level avx512,avx2,sse2]
//!         [--repeat 5] [--record FILE --date YYYY-MM-DD]

use std::fmt::Write;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

use clap::Parser;
use mobula::app::{self, PacketWidth, Settings};
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
    /// Scenes by name.
    #[arg(long, value_delimiter = ',', default_value = "bunny,motorbike,fzk_inside,atrium,terr1m")]
    scene: Vec<String>,
    /// Levels.
    #[arg(long, value_delimiter = ',', default_value = "avx512,avx2,sse2")]
    level: Vec<Level>,
    /// Turns.
    #[arg(long, default_value_t = 5)]
    repeat: usize,
    /// Frames in a turn.
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

/// Pixels a side.
const SIDE: usize = 1024;
const TILE: usize = 16;
/// The constant ambient light.
const AMBIENT: f32 = 0.2;
/// Pixels whose bytes may differ by more than one step, at most one of so many: edges, and surfaces that lie in one another.
const BAND: usize = 500;
const WIDTHS: [PacketWidth; 2] = [PacketWidth::W64, PacketWidth::W256];

/// A scene whose surfaces are all matt and flat, under one light.
fn describe(view: &scenes::View, data: &std::path::Path) -> Result<(SceneDescription, View), String> {
    let mut scene = scenes::scene(view.source, data)?;
    for geometry in &mut scene.geometry {
        if let Some(mesh) = geometry.downcast_ref::<Mesh>() {
            *geometry = Arc::new(Mesh { normals: Vec::new(), triangle_normals: Vec::new(), ..mesh.clone() });
        }
    }
    for named in &mut scene.materials {
        named.material = Arc::new(Lambertian { diffuse: named.material.base_color() });
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
    light: glam::Vec3,
    rays: RaySet,
    found: Found,
    shadow: RaySet,
    blocked: Found,
    picture: Vec<u32>,
}

impl<'a> Bare<'a> {
    fn new(
        token: AnyToken,
        scene: &'a Scene<'a>,
        triangles: &'a Triangles,
        colors: &'a [glam::Vec3],
        view: View,
        light: glam::Vec3,
    ) -> Self {
        let mut rays = RaySet::default();
        (0..TILE * TILE).for_each(|_| rays.push(view.eye.to_array(), [0.0; 3], f32::INFINITY));
        let mut shadow = rays.clone();
        (0..3).for_each(|axis| shadow.origin[axis].fill(light[axis]));
        let found = Found::new(TILE * TILE);
        let interface = Interface { entry: Entry::Sixteen, coherent: true };
        let picture = vec![0; SIDE * SIDE];
        Self {
            token,
            scene,
            interface,
            triangles,
            colors,
            view,
            light,
            rays,
            blocked: found.clone(),
            found,
            shadow,
            picture,
        }
    }
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
        for tile in 0..(SIDE / TILE).pow(2) {
            let corner = [tile % (SIDE / TILE) * TILE, tile / (SIDE / TILE) * TILE];
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
        for i in 0..TILE * TILE {
            let [x, y] = pixel(i);
            let sx = ((x as f32 + 0.5) * (2.0 / SIDE as f32) - 1.0) * slope;
            let sy = (1.0 - (y as f32 + 0.5) * (2.0 / SIDE as f32)) * slope;
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
        to_pixels(self.token, shown.each_ref().map(|column| &column[..]), TILE * TILE, &mut pixels);
        for (i, &color) in pixels.iter().enumerate() {
            let [x, y] = pixel(i);
            self.picture[y * SIDE + x] = color;
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

fn measure(
    name: &str,
    level: Level,
    arguments: &Arguments,
    table: &mut String,
) -> Result<(), Box<dyn std::error::Error>> {
    let view = VIEWS.iter().find(|view| view.name == name).ok_or("no such scene")?;
    let token = AnyToken::for_level(level)?;
    let primitives = scenes::primitives(view, &arguments.data)?;
    let Primitives::Triangles(triangles) = &primitives else { return Err("spheres".into()) };
    let light = glam::Vec3::from(view.light);
    let (description, camera) = describe(view, &arguments.data)?;
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
    let mut bare = Bare::new(token, &scene, triangles, &colors, camera, light);
    for (what, renderer) in [("primary", RendererKind::Primary), ("shadows", RendererKind::Raytracer)] {
        let shadows = renderer == RendererKind::Raytracer;
        let size = Size::new(SIDE, SIDE)?;
        let settings =
            |packet| Settings { token, packet, threads: 1, size, view: Some(camera), renderer, ..Settings::default() };
        let pipeline = |width| app::pipeline(&description, &settings(width));
        let mut pipelines = [pipeline(WIDTHS[0])?, pipeline(WIDTHS[1])?];
        // Its best interface, from one frame of each.
        let packets = [Entry::One, Entry::Four, Entry::Eight, Entry::Sixteen];
        let tried = packets.map(|entry| Interface { entry, coherent: true }).into_iter();
        let time = |interface| {
            bare.interface = interface;
            (interface, clock::time(|| token.run(Frame { bare: &mut bare, shadows })).1.process)
        };
        let tried = tried.filter(|&interface| device.is_native(interface)).map(time);
        let (best, _) = tried.min_by(|a, b| a.1.total_cmp(&b.1)).ok_or("no interface")?;
        bare.interface = best;
        let (mut theirs, mut ours) = (Vec::new(), [Vec::new(), Vec::new()]);
        for _ in 0..arguments.repeat {
            for (pipeline, times) in pipelines.iter_mut().zip(&mut ours) {
                let (report, elapsed) = clock::time(|| pipeline.run(arguments.frames as u64));
                report?;
                times.push(elapsed.process / arguments.frames as f64);
            }
            let frames = || (0..arguments.frames).for_each(|_| token.run(Frame { bare: &mut bare, shadows }));
            theirs.push(clock::time(frames).1.process / arguments.frames as f64);
        }
        let (_, picture) = pipelines[0].picture(0).ok_or("no picture")?;
        let [far, any] = differences(picture.pixels(), &bare.picture);
        assert!(far <= SIDE * SIDE / BAND, "{name} {what}: {far} pixels differ from Embree's");
        let mut row = format!("| {name} | {level} | {what} | {best} ");
        let rate = |times: &[f64]| (SIDE * SIDE) as f64 * 1e-6 / Spread::of(times.iter().copied()).median;
        let _ = write!(row, "| {:.2} ", rate(&theirs));
        for times in &ours {
            let _ = write!(row, "| {:.2} ", rate(times));
        }
        for times in &ours {
            let ratio = Spread::of(theirs.iter().zip(times).map(|(embree, mobula)| embree / mobula));
            let _ = write!(row, "| {:.2} / **{:.2}** / {:.2} ", ratio.min, ratio.median, ratio.max);
        }
        let _ = write!(row, "| {far}, {any} |");
        println!("{row}");
        table.push_str(&row);
        table.push('\n');
    }
    Ok(())
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let given: Vec<String> = std::env::args().skip(1).filter(|argument| argument != "--bench").collect();
    let mut table = format!(
        "# Frames, {}\n\n- Command: `cargo bench -p mobula-benches --features embree --bench frames -- {}`\n- Machine: {}\n\n",
        arguments.date,
        given.join(" "),
        clock::machine(clock::tick_frequency())
    );
    table.push_str(EXPLANATION);
    print!("{table}");
    let mut failed = false;
    for name in &arguments.scene {
        for &level in &arguments.level {
            if let Err(error) = measure(name, level, &arguments, &mut table) {
                eprintln!("{name} {level}: {error}");
                failed = true;
            }
            if let Some(file) = &arguments.record
                && let Err(error) = std::fs::write(file, &table)
            {
                eprintln!("{}: {error}", file.display());
                failed = true;
            }
        }
    }
    if failed { ExitCode::FAILURE } else { ExitCode::SUCCESS }
}

const EXPLANATION: &str = "\
One thread, 1024x1024 pixels, Mpixel/s by processor time (medians of the turns); ratios are Mobula's rate over that of the bare
loop, turn by turn. Mobula is the whole pipeline: its components, its materials, its frame buffer, in packets of 64 and of 256. The
bare loop makes 256 primary rays a tile, calls Embree 3.13.5 (quality medium, limited to the level's instructions, the best of its
packet interfaces with the coherent flag), shades, and writes pixels; it is compiled for the level as a whole. Both shade flat:
Lambertian, one point light, shadow rays from the light, constant ambient light, no vertex normals. `primary` shows base
colours. Last: pixels that differ by more than one step of a channel, and at all: ties of surfaces that lie in one another, and
edges.

| scene | level | frame | Embree's best | Mpixel/s | Mobula 64 | Mobula 256 | ratio of 64 | ratio of 256 | pixels that differ |
|---|---|---|---|---|---|---|---|---|---|
";
