//! What the command line may say.

use std::path::PathBuf;

use clap::{ArgAction, Args, Parser, Subcommand};
use mobula::accel::AccelerationKind;
use mobula::app::PacketWidth;
use mobula::background::BackgroundKind;
use mobula::balance::BalancerKind;
use mobula::camera::CameraKind;
#[cfg(feature = "window")]
use mobula::camera::Up;
use mobula::choice::list;
use mobula::display::stereo::Stereo;
use mobula::image::Size;
use mobula::load::{FORMATS, PICTURES};
use mobula::medium::{DEFAULT_STEP, Fog};
use mobula::renderer::RendererKind;
use mobula::sampler::{Filter, SamplerKind};
use mobula::tone::{Curve, Tone};
use mobula::traverse::TraverserKind;
use mobula::volume::Preset;
use mobula_core::simd::Level;

use super::memory;
use super::particle_options::ParticleOptions;
use super::raw::RawOptions;
#[cfg(feature = "window")]
use super::values::quoted;
use super::values::{
    BackgroundChoice, Given, LightChoice, Plane, Point, Shading, Transfer, UpChoice, Window, as_given, at_least_one,
    background, channels, crease, distance, exposure, finite, focus, fog, fov, light, part, picture, plane, point,
    radius, rate, reach, samples, size, step_length, threads, threshold, transfer, up, window,
};

/// Packet ray tracer for triangle meshes, spheres and iso-surfaces of volumes.
///
/// Without a subcommand: opens the scene in a window if there is a display, else writes mobula.png.
#[derive(Debug, Parser)]
#[command(name = "mobula", version, after_help = scenes_help())]
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
    /// Render a scene to a picture file, or to several
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
         digit; volumes, particles, or meshes of the same triangles, whose names differ in a number are steps of time [default: the built-in scene]", extensions()
    ))]
    pub(crate) scenes: Vec<PathBuf>,

    #[command(flatten)]
    pub(crate) raw: RawOptions,

    /// How much memory steps of particles may take, such as 500M or 4G: those that do not fit are read when they are shown, the next ones
    /// ahead [default: three quarters of what is free]
    #[arg(long, value_name = "SIZE", value_parser = memory::limit)]
    pub(crate) memory: Option<u64>,

    /// Size of the picture in pixels; a width alone has 3/4 of it as height [default: 1024x768]
    #[arg(short, long, value_name = "WxH", value_parser = size)]
    pub(crate) size: Option<Size>,

    /// Render threads [default: one per processor]
    #[arg(short, long, value_name = "N", value_parser = threads)]
    pub(crate) threads: Option<usize>,

    /// Instruction set: scalar, sse2, avx2 or avx512 [default: the best there is; env: MOBULA_ISA]
    #[arg(long, value_name = "LEVEL")]
    pub(crate) isa: Option<Level>,

    #[arg(short, long, value_name = "N", help = format!(
        "Rays in a packet: {} [default: {}, at the scalar level {}]",
        PacketWidth::list(), PacketWidth::best(Level::Avx2), PacketWidth::best(Level::Scalar)
    ))]
    pub(crate) packet: Option<PacketWidth>,

    #[arg(
        short, long, value_name = "NAME",
        help = format!("Renderer: {} [default: {}]", list(RendererKind::NAMES), RendererKind::Raytracer)
    )]
    pub(crate) renderer: Option<RendererKind>,

    /// Samples per pixel; powers of two are spread best [default: 16 for pictures in files, up to 1024 in windows, else 1]
    #[arg(long, value_name = "K", conflicts_with = "sampler", value_parser = samples)]
    pub(crate) samples: Option<SamplerKind>,

    /// Samples only where they are needed: until the error of a pixel is below THRESHOLD, in light from 0 to 1 (0.005 is hardly seen), up to
    /// --samples [default: 256 of them]
    #[arg(long, value_name = "THRESHOLD", conflicts_with = "sampler", value_parser = threshold)]
    pub(crate) adaptive: Option<f64>,

    /// Pixel sampler: single, sobol:N for N samples per pixel, or adaptive:N:THRESHOLD [default: sobol:16 for pictures in files, sobol:1024 in
    /// windows, else single]
    #[arg(long, value_name = "NAME")]
    pub(crate) sampler: Option<SamplerKind>,

    /// What several samples count for a pixel: box, gaussian or mitchell (sharper) [default: gaussian]
    #[arg(long, value_name = "NAME")]
    pub(crate) filter: Option<Filter>,

    /// Image traverser: tiled, progressive (coarse at once, then refined frame by frame), deadline:MILLISECONDS or null
    #[arg(long, value_name = "NAME", default_value_t)]
    pub(crate) traverser: TraverserKind,

    /// Load balancer: auto (by the number of threads), work-queue, work-queue:GRANULARITY, by-cost (learns what tiles cost; for
    /// many processors), cyclic or static
    #[arg(long, value_name = "NAME", default_value_t)]
    pub(crate) balancer: BalancerKind,

    /// Acceleration structure: bvh, bvh-fast to build it quickly, or brute for none
    #[arg(long, value_name = "NAME", default_value_t = AccelerationKind::Bvh)]
    pub(crate) accel: AccelerationKind,

    #[arg(
        long, value_name = "KIND", help = format!("Camera: {} [default: {}]", list(CameraKind::NAMES), CameraKind::Pinhole)
    )]
    pub(crate) camera: Option<CameraKind>,

    /// Position of the eye, as files have it [default: frames the scene]
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    pub(crate) eye: Option<Point>,

    /// Point to look at
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    pub(crate) at: Option<Point>,

    /// Vertical field of view in degrees [default: frames the scene; 180 for fisheye]
    #[arg(long, value_name = "DEGREES", value_parser = fov)]
    pub(crate) fov: Option<f32>,

    /// Radius of the lens of the camera thin-lens, in units of the scene [default: a 40th of the distance of what is in focus]
    #[arg(long, value_name = "RADIUS", value_parser = radius)]
    pub(crate) aperture: Option<f64>,

    /// Distance of what the camera thin-lens has in focus [default: that of the point looked at]
    #[arg(long, value_name = "DISTANCE", value_parser = focus)]
    pub(crate) focus: Option<f64>,

    /// Which way is up: y, z or auto
    #[arg(long, value_name = "AXIS", default_value = "auto", value_parser = up)]
    pub(crate) up: UpChoice,

    #[arg(
        long, value_name = "NAME|COLOUR|FILE", value_parser = as_given(background),
        help = format!(
            "Background: {}; a colour: R,G,B from 0 to 1 of light, or #RRGGBB of a screen; or a picture of everything around ({}; twice as \
             wide as high), which lights the scene, as daylight does. daylight:ELEVATION,AZIMUTH,TURBIDITY places the sun: degrees above \
             the horizon and clockwise from what is behind the scene, and how hazy it is, 1.8 to 10 [default for daylight: 45,215,3]",
            BackgroundKind::NAMES.join(", "), PICTURES.join(", ")
        )
    )]
    pub(crate) background: Option<Given<BackgroundChoice>>,

    /// Puts a grey ground under the scene, which ends far away and is no part of it
    #[arg(long, action = ArgAction::SetTrue)]
    pub(crate) ground: bool,

    /// Fog, for the renderer `raytracer`: of light that goes x units through it exp(-DENSITY x) is left; its colour is written as that
    /// of the background, and pale grey if not given [default: no fog]
    #[arg(long, value_name = "DENSITY[,COLOUR]", value_parser = as_given(fog))]
    pub(crate) fog: Option<Given<Fog>>,

    /// Meshes without normals are smooth where triangles meet at less than this angle, from 0 (they keep their facets) to 180 degrees
    /// [default: 30]
    #[arg(long, value_name = "DEGREES", value_parser = crease)]
    pub(crate) smooth: Option<f32>,

    /// No shadows
    #[arg(long, action = ArgAction::SetTrue)]
    pub(crate) no_shadows: bool,

    #[arg(
        long, value_name = "NAME",
        help = format!("What becomes of light that is brighter than a screen: {} [default: {}]", list(Curve::NAMES), Tone::default().curve)
    )]
    pub(crate) tone: Option<Curve>,

    /// Make everything brighter, or darker if negative: by how many powers of 2 [default: 0]
    #[arg(long, value_name = "STOPS", value_parser = exposure, allow_hyphen_values = true)]
    pub(crate) exposure: Option<f32>,

    /// Ambient occlusion: less ambient light where things are near, at most DISTANCE away, or as far as the scene goes; 0: none
    #[arg(long, value_name = "DISTANCE", value_parser = reach, num_args = 0..=1, default_missing_value = "inf", require_equals = true)]
    pub(crate) ao: Option<f64>,

    /// Where the light is, instead of those of the scene: at a point, or at the camera, wherever that goes. A background that lights goes on
    /// doing so [default: the lights of the scene, or one to the upper left of its own view]
    #[arg(long, value_name = "X,Y,Z|camera", value_parser = light, allow_hyphen_values = true)]
    pub(crate) light: Option<LightChoice>,

    #[command(flatten)]
    pub(crate) volumes: VolumeOptions,

    #[command(flatten)]
    pub(crate) particles: ParticleOptions,
}

#[derive(Args, Clone, Debug)]
pub(crate) struct VolumeOptions {
    /// Values of iso-surfaces [default: one that parts what is dark from what is bright]
    #[arg(long, help_heading = "Volumes", allow_hyphen_values = true, value_name = "V[,V...]", value_delimiter = ',', value_parser = finite)]
    pub(crate) iso: Vec<f64>,

    #[arg(long, help_heading = "Volumes", value_name = "NAME|FILE", value_parser = transfer, help = format!(
        "Shows volumes as a medium, as a transfer function says: {}, labels (a colour for each whole number), or a file: text, or a \
         colour map of ParaView as JSON; several times: one a volume, the last for all further ones. With --iso both are shown",
        list(Preset::NAMES)
    ))]
    pub(crate) transfer: Vec<Transfer>,

    /// The values that the transfer function is for: their middle, and how wide they are [default: as the function says]
    #[arg(long, help_heading = "Volumes", allow_hyphen_values = true, value_name = "LEVEL,WIDTH", requires = "transfer", value_parser = window)]
    pub(crate) window: Option<Window>,

    /// Are media of volumes lit by the lights, as surfaces are, or do they glow? [default: lit are bone, skin and muscle]
    #[arg(long, help_heading = "Volumes", value_name = "WHEN", default_value = "auto", hide_default_value = true)]
    pub(crate) shading: Shading,

    /// The longest step of rays through media of volumes, in units of cells, from 1/32 to 16
    #[arg(long, help_heading = "Volumes", value_name = "CELLS", default_value_t = DEFAULT_STEP, value_parser = step_length)]
    pub(crate) step_length: f32,

    /// Where the first sample of volumes is [default: as files say]
    #[arg(long, help_heading = "Volumes", value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    pub(crate) volume_origin: Option<Point>,

    /// How much light gets through each iso-surface, from 0 to 1; the last number is for all further ones
    #[arg(long, help_heading = "Volumes", value_name = "A[,A...]", value_delimiter = ',', value_parser = part)]
    pub(crate) transparent: Vec<f32>,

    /// Leaves out of volumes what lies where X x + Y y + Z z > D; may be given several times
    #[arg(long, help_heading = "Volumes", allow_hyphen_values = true, value_name = "X,Y,Z,D", value_parser = plane)]
    pub(crate) cut: Vec<Plane>,

    /// Step of time, of volumes, particles and meshes, from 0 [default: 0]
    #[arg(long, help_heading = "Volumes", value_name = "N")]
    pub(crate) step: Option<usize>,
}

#[derive(Args, Clone, Debug)]
pub(crate) struct RenderOptions {
    #[command(flatten)]
    pub(crate) scene: SceneOptions,

    /// The picture to write: PNG, JPEG, PPM or EXR, by the end of its name, or - for PPM on standard output; with #### in its name every
    /// frame is, under its number in so many digits, at least two. EXR has light before --exposure and --tone, and as layers depth,
    /// normals, colours of surfaces and numbers of what is seen
    #[arg(short, long, value_name = "FILE", default_value = "mobula.png", value_parser = picture)]
    pub(crate) output: PathBuf,

    /// Frames to render; the last is written, or all of them if the file's name has a place for their numbers
    #[arg(short = 'n', long, value_name = "N", default_value_t = 1, value_parser = at_least_one)]
    pub(crate) frames: u64,

    /// Goes once around the scene in so many frames, and writes each
    #[arg(long, value_name = "N", value_parser = at_least_one, conflicts_with_all = ["frames", "channels"])]
    pub(crate) turntable: Option<u64>,

    /// Lets time go on from frame to frame, so many frames a second; a step lasts as long as the scene file says, else a frame
    #[arg(long, value_name = "FPS", value_parser = rate)]
    pub(crate) fps: Option<f64>,

    /// Draws what the colours of particles mean into a corner of the picture
    #[arg(long)]
    pub(crate) legend: bool,

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

    /// How much memory steps of particles may take, such as 500M or 4G: further ones are not looked at [default: three quarters of what is
    /// free]
    #[arg(long, value_name = "SIZE", value_parser = memory::limit)]
    pub(crate) memory: Option<u64>,

    /// Print one JSON object on standard output
    #[arg(long)]
    pub(crate) json: bool,
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
        option("smooth", self.smooth.map(|degrees| degrees.to_string()));
        let joined = |numbers: Vec<String>| (!numbers.is_empty()).then(|| numbers.join(","));
        option("light", self.light.map(|light| light.to_string()));
        // Those that a viewer can change are its own to tell.
        let VolumeOptions { transparent, cut, step_length, volume_origin, .. } = &self.volumes;
        option("volume-origin", volume_origin.and_then(|Point(numbers)| joined(numbers.map(|x| x.to_string()).into())));
        option("step-length", (*step_length != DEFAULT_STEP).then(|| step_length.to_string()));
        option("transparent", joined(transparent.iter().map(f32::to_string).collect()));
        for Plane(numbers) in cut {
            option("cut", joined(numbers.iter().map(f64::to_string).collect()));
        }
        self.particles.words().into_iter().for_each(|(name, value)| option(name, Some(value)));
        option("fog", self.fog.as_ref().map(|given| given.words.clone()));
        if self.ground {
            words.push("--ground".to_owned());
        }
        words.join(" ")
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
    format!("In the window:\n{}", mobula::display::window::help())
}

/// How names of files end that can be loaded.
fn extensions() -> String {
    let ends = FORMATS.iter().flat_map(|format| format.extensions);
    format!("{}; each also with .gz", ends.copied().collect::<Vec<_>>().join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }
}
