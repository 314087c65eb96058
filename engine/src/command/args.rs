//! What the command line may say.

use std::path::PathBuf;
use std::sync::Arc;

use clap::{ArgAction, Args, Parser, Subcommand};
use glam::Vec3;
use mobula::accel::AccelerationKind;
use mobula::app::PacketWidth;
use mobula::background::{Background, BackgroundKind, Constant};
use mobula::balance::BalancerKind;
use mobula::camera::{CameraKind, Up};
use mobula::choice::list;
use mobula::color::from_srgb8;
use mobula::display::stereo::Stereo;
use mobula::image::Size;
use mobula::load::FORMATS;
use mobula::medium::Fog;
use mobula::pipeline::MAX_THREADS;
use mobula::renderer::RendererKind;
use mobula::sampler::SamplerKind;
use mobula::traverse::TraverserKind;
use mobula_core::simd::Level;

use super::volumes::RawOptions;

/// Packet ray tracer for triangle meshes, spheres and iso-surfaces of volumes.
///
/// Without a subcommand: opens the scene in a window if there is a display, else writes mobula.png.
#[derive(Debug, Parser)]
#[command(name = "mobula", version, args_conflicts_with_subcommands = true, after_help = scenes_help())]
#[command(allow_negative_numbers = true)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Option<Command>,
    /// Say nothing but warnings and errors, and show no progress
    #[arg(short, long, global = true)]
    pub(crate) quiet: bool,
    #[command(flatten)]
    pub(crate) options: SceneOptions,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Render a scene to a PNG file
    #[command(after_help = scenes_help(), allow_negative_numbers = true)]
    Render(RenderOptions),
    /// Open a scene in a window
    #[cfg(feature = "window")]
    #[command(after_help = keys_help(), allow_negative_numbers = true)]
    View(SceneOptions),
    /// Measure how rendering scales, and project it to more processors
    #[command(after_help = scenes_help(), allow_negative_numbers = true)]
    Scale(super::scale::ScaleOptions),
    /// Tell what is in a file
    Info(InfoOptions),
    /// Measure and check every kernel, special case, level and packet width
    #[cfg(feature = "kernels")]
    Kernels(mobula::kernels::Options),
    /// Print what makes a shell complete this command line
    #[command(after_help = "For bash: mobula completions bash > ~/.local/share/bash-completion/completions/mobula")]
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
    /// Print the manual page, or that of a subcommand, as troff
    #[command(after_help = "To read it: mobula man render | man -l -")]
    Man {
        /// A subcommand
        #[arg(value_name = "COMMAND")]
        command: Option<String>,
    },
}

#[derive(Args, Clone, Debug)]
pub(crate) struct SceneOptions {
    #[arg(value_name = "SCENE", help = format!(
        "Files ({}) or generated scenes (gen:NAME), all shown together; a name may have * ? # for anything, a character, a \
         digit; volumes whose names differ in a number are steps of time [default: the built-in scene]", extensions()
    ))]
    pub(crate) scenes: Vec<PathBuf>,

    #[command(flatten)]
    pub(crate) raw: RawOptions,

    /// Size of the picture in pixels; a width alone has 3/4 of it as height
    #[arg(short, long, value_name = "WxH", default_value = "1024x768", value_parser = size)]
    pub(crate) size: Size,

    /// Render threads [default: one per processor]
    #[arg(short, long, value_name = "N", value_parser = threads)]
    pub(crate) threads: Option<usize>,

    /// Instruction set: scalar, sse2, avx2 or avx512 [default: the best there is; env: MOBULA_ISA]
    #[arg(long, value_name = "LEVEL")]
    pub(crate) isa: Option<Level>,

    #[arg(short, long, value_name = "N", help = format!(
        "Rays in a packet: {} [default: {} at avx2 and avx512, else {}]",
        PacketWidth::list(), PacketWidth::best(Level::Avx2), PacketWidth::best(Level::Sse2)
    ))]
    pub(crate) packet: Option<PacketWidth>,

    #[arg(
        short, long, value_name = "NAME", default_value_t = RendererKind::Raytracer,
        help = format!("Renderer: {}", list(RendererKind::NAMES))
    )]
    pub(crate) renderer: RendererKind,

    /// Samples per pixel, a square number up to 1024 [default: 16 for pictures in files, else 1]
    #[arg(long, value_name = "K", conflicts_with = "sampler", value_parser = samples)]
    pub(crate) samples: Option<SamplerKind>,

    /// Pixel sampler: single, or jittered:K for K x K samples per pixel [default: jittered:4 for pictures in files, else single]
    #[arg(long, value_name = "NAME")]
    pub(crate) sampler: Option<SamplerKind>,

    /// Image traverser: tiled, progressive (coarse at once, then refined frame by frame), deadline:MILLISECONDS or null
    #[arg(long, value_name = "NAME", default_value_t)]
    pub(crate) traverser: TraverserKind,

    /// Load balancer: work-queue, work-queue:GRANULARITY, by-cost (learns what tiles cost; for many processors), cyclic or
    /// static
    #[arg(long, value_name = "NAME", default_value_t)]
    pub(crate) balancer: BalancerKind,

    /// Acceleration structure: bvh, bvh-fast to build it quickly, or brute for none
    #[arg(long, value_name = "NAME", default_value_t = AccelerationKind::Bvh)]
    pub(crate) accel: AccelerationKind,

    #[arg(
        long, value_name = "KIND", default_value_t = CameraKind::Pinhole,
        help = format!("Camera: {}", list(CameraKind::NAMES))
    )]
    pub(crate) camera: CameraKind,

    /// Position of the eye, as files have it [default: frames the scene]
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    pub(crate) eye: Option<Point>,

    /// Point to look at
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    pub(crate) at: Option<Point>,

    /// Vertical field of view in degrees
    #[arg(long, value_name = "DEGREES", value_parser = fov)]
    pub(crate) fov: Option<f32>,

    /// Which way is up: y, z or auto
    #[arg(long, value_name = "AXIS", default_value = "auto", value_parser = up)]
    pub(crate) up: UpChoice,

    #[arg(
        long, value_name = "COLOUR", value_parser = as_given(background),
        help = format!(
            "Background: {}, or a colour: R,G,B from 0 to 1 of light, or #RRGGBB of a screen",
            BackgroundKind::NAMES.join(", ")
        )
    )]
    pub(crate) background: Option<Given<Arc<dyn Background>>>,

    /// Fog, for the renderer `raytracer`: of light that goes x units through it exp(-DENSITY x) is left; its colour as that of
    /// the background [default: none]
    #[arg(long, value_name = "DENSITY[,COLOUR]", value_parser = as_given(fog))]
    pub(crate) fog: Option<Given<Fog>>,

    /// No shadows
    #[arg(long, action = ArgAction::SetTrue)]
    pub(crate) no_shadows: bool,

    #[command(flatten)]
    pub(crate) volumes: VolumeOptions,
}

#[derive(Args, Clone, Debug)]
pub(crate) struct VolumeOptions {
    /// Values of iso-surfaces [default: one that parts what is dark from what is bright]
    #[arg(long, help_heading = "Volumes", value_name = "V[,V...]", value_delimiter = ',', value_parser = finite)]
    pub(crate) iso: Vec<f64>,

    /// How much light gets through each iso-surface, from 0 to 1; the last number is for all further ones
    #[arg(long, help_heading = "Volumes", value_name = "A[,A...]", value_delimiter = ',', value_parser = part)]
    pub(crate) transparent: Vec<f32>,

    /// Leaves out of volumes what lies where X x + Y y + Z z > D; may be given several times
    #[arg(long, help_heading = "Volumes", value_name = "X,Y,Z,D", value_parser = plane)]
    pub(crate) cut: Vec<Plane>,

    /// Step of time, from 0
    #[arg(long, help_heading = "Volumes", value_name = "N", default_value_t = 0)]
    pub(crate) step: usize,
}

#[derive(Args, Clone, Debug)]
pub(crate) struct RenderOptions {
    #[command(flatten)]
    pub(crate) scene: SceneOptions,

    /// The PNG file to write; with #### in its name every frame is, under its number in so many digits, at least two
    #[arg(short, long, value_name = "FILE", default_value = "mobula.png", value_parser = png)]
    pub(crate) output: PathBuf,

    /// Frames to render; the last is written, or all of them if the file's name has a place for their numbers
    #[arg(short = 'n', long, value_name = "N", default_value_t = 1, value_parser = at_least_one)]
    pub(crate) frames: u64,

    /// Viewpoints around the scene, rendered together; with more than one, FILE-0.png, FILE-1.png, ... are written
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = channels)]
    pub(crate) channels: u16,

    /// Two eyes in one picture: side-by-side (twice as wide) or anaglyph (red and cyan)
    #[arg(long, value_name = "KIND", conflicts_with = "channels")]
    pub(crate) stereo: Option<Stereo>,

    /// How far the eyes are apart, in units of the scene [default: a 30th of the distance to what they look at]
    #[arg(long, value_name = "DISTANCE", requires = "stereo", value_parser = distance)]
    pub(crate) eye_distance: Option<f32>,

    /// Print rays by kind and by path, and where the time went
    #[arg(long)]
    pub(crate) stats: bool,

    /// Print one JSON object on standard output
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args, Clone, Debug)]
pub(crate) struct InfoOptions {
    #[arg(required = true, value_name = "FILE", help = format!(
        "The file ({}), a generated scene (gen:NAME), or several that are shown together", extensions()
    ))]
    pub(crate) files: Vec<PathBuf>,

    #[command(flatten)]
    pub(crate) raw: RawOptions,

    /// Print one JSON object on standard output
    #[arg(long)]
    pub(crate) json: bool,
}

/// An axis, or a guess.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct UpChoice(pub(crate) Option<Up>);

/// A value, and the words that it was given in.
#[derive(Clone, Debug)]
pub(crate) struct Given<T> {
    #[cfg_attr(not(feature = "window"), allow(dead_code, reason = "for windows"))]
    pub(crate) words: String,
    pub(crate) value: T,
}

fn as_given<T>(parse: fn(&str) -> Result<T, String>) -> impl Fn(&str) -> Result<Given<T>, String> + Clone {
    move |words| parse(words).map(|value| Given { words: words.to_owned(), value })
}

impl SceneOptions {
    /// What makes the same scene on the command line, with what a viewer cannot change.
    #[cfg(feature = "window")]
    pub(crate) fn scene_words(&self) -> String {
        let mut words: Vec<String> = self.scenes.iter().map(|scene| quoted(&scene.to_string_lossy())).collect();
        let mut option = |name: &str, value: Option<String>| {
            words.extend(value.map(|value| format!("--{name} {}", quoted(&value))));
        };
        self.raw.words().into_iter().for_each(|(name, value)| option(name, value));
        option("isa", self.isa.map(|level| level.to_string()));
        option("up", self.up.0.map(|up| if up == Up::Y { "y" } else { "z" }.to_owned()));
        option("background", self.background.as_ref().map(|given| given.words.clone()));
        let joined = |numbers: Vec<String>| (!numbers.is_empty()).then(|| numbers.join(","));
        // Those of iso-surfaces are a viewer's to tell.
        let VolumeOptions { iso: _, transparent, cut, step } = &self.volumes;
        option("transparent", joined(transparent.iter().map(f32::to_string).collect()));
        for Plane(numbers) in cut {
            option("cut", joined(numbers.iter().map(f64::to_string).collect()));
        }
        option("step", (*step > 0).then(|| step.to_string()));
        option("fog", self.fog.as_ref().map(|given| given.words.clone()));
        words.join(" ")
    }
}

/// A word as a shell takes it.
#[cfg(feature = "window")]
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "_-+=:,./%@".contains(c);
    if word.contains(char::is_control) {
        // As bash, zsh and others read it; bytes, so that no control character is shown.
        let bytes = word.bytes().map(|b| {
            if b.is_ascii_graphic() && !b"'\\".contains(&b) { char::from(b).to_string() } else { format!("\\x{b:02x}") }
        });
        return format!("$'{}'", bytes.collect::<String>());
    }
    if !word.is_empty() && word.chars().all(plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}

fn scenes_help() -> String {
    let mut text = String::from("Generated scenes:\n");
    for (name, what) in mobula::generate::SCENES {
        text.push_str(&format!("  {name:<14} {what}\n"));
    }
    text.push_str("\nExit status: 0 done, 1 failed, 2 wrong usage, 130 interrupted, 143 terminated");
    text
}

#[cfg(feature = "window")]
fn keys_help() -> String {
    format!("In the window:\n{}", mobula::display::window::HELP)
}

fn size(text: &str) -> Result<Size, String> {
    let side = |text: &str| {
        let digits = !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
        // More digits than a usize holds are too large in any case.
        let side = digits.then(|| text.parse().unwrap_or(usize::MAX));
        side.ok_or_else(|| "write it as WIDTHxHEIGHT, such as 1024x768".to_owned())
    };
    let (width, height) = match text.split_once(['x', 'X', '×', '*', ',']) {
        Some((width, height)) => (side(width.trim())?, side(height.trim())?),
        None => side(text).map(|width| (width, if width < 2 { width } else { width.saturating_mul(3) / 4 }))?,
    };
    Size::new(width, height).map_err(|error| error.to_string())
}

fn at_least_one(text: &str) -> Result<u64, String> {
    text.parse().ok().filter(|count| *count > 0).ok_or_else(|| "give a whole number, 1 or more".to_owned())
}

fn channels(text: &str) -> Result<u16, String> {
    text.parse().ok().filter(|count| (1..=64).contains(count)).ok_or_else(|| "give a number from 1 to 64".to_owned())
}

fn threads(text: &str) -> Result<usize, String> {
    let count = text.parse().ok().filter(|count| (1..=MAX_THREADS).contains(count));
    count.ok_or_else(|| format!("there can be 1 to {MAX_THREADS} threads"))
}

fn samples(text: &str) -> Result<SamplerKind, String> {
    let problem = || "give a square number from 1 to 1024, such as 1, 4, 9 or 16".to_owned();
    let count: u32 = text.parse().map_err(|_| problem())?;
    let side = count.isqrt();
    if side * side != count || !(1..=32).contains(&side) {
        return Err(problem());
    }
    Ok(if side == 1 { SamplerKind::Single } else { SamplerKind::Jittered { side } })
}

/// A point with the numbers of a file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Point(pub(crate) [f64; 3]);

fn point(text: &str) -> Result<Point, String> {
    let parts: Vec<&str> = text.split([',', ' ']).filter(|part| !part.is_empty()).collect();
    let numbers: Vec<f64> = parts.iter().filter_map(|part| finite(part).ok()).collect();
    match numbers[..] {
        [x, y, z] if parts.len() == 3 && !text.contains(",,") => Ok(Point([x, y, z])),
        _ => Err("write three numbers with commas between them, such as 1,2.5,-3".into()),
    }
}

fn vector(text: &str) -> Result<Vec3, String> {
    let Point([x, y, z]) = point(text)?;
    let vector = Vec3::new(x as f32, y as f32, z as f32);
    if vector.is_finite() { Ok(vector) } else { Err("the numbers are too large".into()) }
}

fn finite(text: &str) -> Result<f64, String> {
    let number = text.trim().parse().ok().filter(|number: &f64| number.is_finite());
    number.ok_or_else(|| "give numbers with commas between them, such as 300 or -200,300".into())
}

fn part(text: &str) -> Result<f32, String> {
    let part = text.trim().parse().ok().filter(|part| (0.0..=1.0).contains(part));
    part.ok_or_else(|| "give numbers from 0 (opaque) to 1 with commas between them".into())
}

/// A plane (a, b, c, d) with the points where a x + b y + c z = d.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Plane(pub(crate) [f64; 4]);

fn plane(text: &str) -> Result<Plane, String> {
    let numbers: Vec<f64> = text.split(',').filter_map(|number| finite(number).ok()).collect();
    match numbers[..] {
        [a, b, c, d] if text.split(',').count() == 4 && [a, b, c] != [0.0; 3] => Ok(Plane([a, b, c, d])),
        _ => Err("give four numbers, the first three not all 0, such as 1,0,0,0.5 for what is right of x = 0.5".into()),
    }
}

fn fov(text: &str) -> Result<f32, String> {
    let angle = text.parse().ok().filter(|angle| (1.0..=170.0).contains(angle));
    angle.ok_or_else(|| "give an angle from 1 to 170 degrees".into())
}

fn distance(text: &str) -> Result<f32, String> {
    let distance = text.parse().ok().filter(|distance: &f32| distance.is_finite() && *distance > 0.0);
    distance.ok_or_else(|| "give a number above 0".into())
}

fn up(text: &str) -> Result<UpChoice, String> {
    match text {
        "y" => Ok(UpChoice(Some(Up::Y))),
        "z" => Ok(UpChoice(Some(Up::Z))),
        "auto" => Ok(UpChoice(None)),
        _ => Err("the axes are y, z and auto".into()),
    }
}

fn background(text: &str) -> Result<Arc<dyn Background>, String> {
    if let Ok(kind) = text.parse::<BackgroundKind>() {
        return Ok(kind.build());
    }
    let unknown = || {
        format!("give {}, three numbers from 0 to 1 such as 0.1,0.2,0.3, or #rrggbb", BackgroundKind::NAMES.join(", "))
    };
    color(text).map(|color| Arc::new(Constant { color }) as _).ok_or_else(unknown)
}

/// A colour: three numbers from 0 to 1 that are linear in light, or six hexadecimal digits, or three, that are sRGB.
fn color(text: &str) -> Option<Vec3> {
    let text = text.trim();
    let digits = text.strip_prefix('#').unwrap_or(text);
    let number = u32::from_str_radix(digits, 16).ok().filter(|_| !digits.starts_with('+'));
    match (number, digits.len()) {
        (Some(number), 6) => Some(from_srgb8([number >> 16, number >> 8, number].map(|byte| byte as u8))),
        // Each digit stands for two.
        (Some(number), 3) if digits != text => {
            Some(from_srgb8([number >> 8, number >> 4, number].map(|digit| (digit & 15) as u8 * 17)))
        }
        _ => vector(text).ok().filter(|color| color.min_element() >= 0.0 && color.max_element() <= 1.0),
    }
}

fn fog(text: &str) -> Result<Fog, String> {
    let usage = || {
        "give a density of at least 0, or a density and a colour such as 0.05,0.6,0.7,0.8 or 0.05,#aabbcc".to_owned()
    };
    let (density, tint) = text.split_once(',').map_or((text, None), |(density, tint)| (density, Some(tint)));
    let density = density.trim().parse().ok().filter(|density: &f32| density.is_finite() && *density >= 0.0);
    let fog = Fog::new(density.ok_or_else(usage)?);
    match tint {
        None => Ok(fog),
        Some(tint) => color(tint).map(|color| Fog { color, ..fog }).ok_or_else(usage),
    }
}

/// How names of files end that can be loaded.
fn extensions() -> String {
    let ends = FORMATS.iter().flat_map(|format| format.extensions);
    format!("{}; each also with .gz", ends.copied().collect::<Vec<_>>().join(", "))
}

fn png(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    if text.is_empty() {
        return Err("give the name of a file".to_owned());
    }
    if path.is_dir() || path.file_name().is_none() || text.ends_with('/') {
        let end = if text.ends_with('/') { "" } else { "/" };
        return Err(format!("that is a folder; name a file in it, such as {text}{end}mobula.png"));
    }
    let device = path.metadata().is_ok_and(|there| !there.is_file());
    let end = path.extension().map(|end| end.to_string_lossy().to_ascii_lowercase());
    match end.as_deref() {
        _ if device => Ok(path),
        Some("png") => Ok(path),
        Some("jpg" | "jpeg" | "exr" | "hdr" | "ppm" | "pfm" | "tga" | "tif" | "tiff" | "bmp" | "webp" | "gif") => {
            Err(format!("pictures are written as PNG; name it {}", path.with_extension("png").display()))
        }
        _ => Err(format!("pictures are written as PNG; name it {text}.png")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn sizes_are_checked() {
        for (text, width, height) in [("640x480", 640, 480), ("640 × 480", 640, 480), ("800", 800, 600), ("1", 1, 1)] {
            assert_eq!(size(text), Ok(Size::new(width, height).unwrap()), "{text}");
        }
        for (text, expected) in [
            ("0x0", "at least 1"),
            ("100000x100000", "at most"),
            ("99999999999999999999999x1", "at most"),
            ("640x", "WIDTHxHEIGHT"),
            ("-1x5", "WIDTHxHEIGHT"),
            ("6.5x5", "WIDTHxHEIGHT"),
            ("", "WIDTHxHEIGHT"),
        ] {
            assert!(size(text).unwrap_err().contains(expected), "{text}");
        }
    }

    #[test]
    fn values_are_checked() {
        assert_eq!(vector("1,-2.5, 3e1"), Ok(Vec3::new(1.0, -2.5, 30.0)));
        for bad in ["", "1,2", "1,2,3,4", "1,2,x", "nan,0,0", "1,,2,3"] {
            assert!(vector(bad).is_err(), "{bad}");
        }
        assert_eq!(samples("1"), Ok(SamplerKind::Single));
        assert_eq!(samples("16"), Ok(SamplerKind::Jittered { side: 4 }));
        for bad in ["0", "2", "1025", "1089", "-4", "4294967295"] {
            assert!(samples(bad).is_err(), "{bad}");
        }
        assert!(threads("0").is_err() && threads("1025").is_err() && threads("two").is_err());
        assert!(background("2,0,0").is_err() && background("pink").is_err() && background("1,0,0.5").is_ok());
        for (text, expected) in [("#ff8800", [255, 136, 0]), ("FF8800", [255, 136, 0]), ("#f80", [255, 136, 0])] {
            assert_eq!(color(text), Some(from_srgb8(expected)), "{text}");
        }
        for bad in ["#ff88", "f80", "#+ff880", "#ff880g", "ff", ""] {
            assert_eq!(color(bad), None, "{bad}");
        }
        assert_eq!(fog("0.5").unwrap().density, 0.5);
        assert_eq!(fog("0.5,#ffffff").unwrap().color, Vec3::ONE);
        assert_eq!(fog("0.5,1,0,0.25").unwrap().color, Vec3::new(1.0, 0.0, 0.25));
        for bad in ["", "-1", "nan", "1,", "1,2,0,0", "1,0,0", "x"] {
            assert!(fog(bad).is_err(), "{bad}");
        }
        for (name, expected) in [
            ("a.jpg", "name it a.png"),
            ("b/a", "name it b/a.png"),
            ("a.b", "name it a.b.png"),
            (".", "such as ./mobula.png"),
            ("none/", "such as none/mobula.png"),
        ] {
            assert!(png(name).unwrap_err().ends_with(expected), "{name}: {:?}", png(name));
        }
        assert!(png("b.PNG").is_ok() && png("####.png").is_ok());
        #[cfg(feature = "window")]
        assert_eq!(["a/b.obj", "a b", "it's", ""].map(quoted), ["a/b.obj", "'a b'", r"'it'\''s'", "''"]);
    }
}
