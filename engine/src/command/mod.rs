//! The `mobula` command.
//!
//! Everything for people goes to standard error; standard output is for JSON and for what was asked for.

mod args;
mod failure;
mod frames;
mod histogram;
mod info;
mod manual;
mod memory;
mod particle_options;
mod particles;
mod progress;
mod raw;
mod render;
#[cfg(feature = "window")]
mod saved;
mod scale;
mod scene;
mod shown;
mod signals;
mod values;
#[cfg(feature = "window")]
mod view;
mod viewpoints;
mod volumes;

use std::fmt::Display;
use std::io::{self, Write};
#[cfg(feature = "window")]
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use clap::{CommandFactory, FromArgMatches};
use glam::Vec3;
use mobula::accel::Build;
use mobula::app::{self, Settings, State};
use mobula::camera::{CameraKind, Fisheye, Lens};
use mobula::light::{Head, Point};
use mobula::load::{Loaded, environment, printable};
#[cfg(feature = "window")]
use mobula::load::{Place, SCENE_FILE, SavedScene};
use mobula::medium::Fog;
use mobula::pipeline::{Config, Pipeline};
use mobula::renderer::RendererKind;
use mobula::sampler::SamplerKind;
use mobula::scene::{Geometries, Rendering, Steps, Time};
use mobula::stack::Scene;
use mobula::tone::Tone;
use mobula_core::simd::AnyToken;
use serde_json::Value;

use args::{Cli, Command, SceneOptions};
use failure::Failure;
use values::{BackgroundChoice, LightChoice};

/// Says something on standard error. That nobody can be told is no reason to do less.
macro_rules! say {
    ($($text:tt)*) => {{
        use std::io::Write as _;
        let _ = writeln!(std::io::stderr().lock(), $($text)*);
    }};
}
use say;

/// As `say`, but not to people who want it quiet.
macro_rules! tell {
    ($($text:tt)*) => {
        if !$crate::command::quiet() {
            $crate::command::say!($($text)*);
        }
    };
}
use tell;

/// The most samples a pixel gets with `--adaptive` unless somebody says how many.
const MOST_ADAPTIVE: u32 = 256;

static QUIET: AtomicBool = AtomicBool::new(false);

/// Is nothing to be said but warnings and errors?
fn quiet() -> bool {
    // Relaxed: set once, before there is another thread.
    QUIET.load(Ordering::Relaxed)
}

/// Runs the command line; returns the exit status.
pub(crate) fn run() -> ExitCode {
    signals::fail_on_abort();
    let parsed = Cli::command().try_get_matches().and_then(|found| Ok((Cli::from_arg_matches(&found)?, found)));
    let (cli, found) = match parsed {
        Ok(parsed) => parsed,
        Err(answer) => return answered(&answer),
    };
    QUIET.store(cli.quiet, Ordering::Relaxed);
    if let Some(failure) = manual::misplaced(&found) {
        return end(&failure);
    }
    let result = match &cli.command {
        Some(Command::Render(options)) => render::render(options),
        Some(Command::Scale(options)) => scale::scale(options),
        #[cfg(feature = "window")]
        Some(Command::View(options)) => view::view(options),
        Some(Command::Info(options)) => info::info(options),
        #[cfg(feature = "kernels")]
        Some(Command::Kernels(options)) => kernels(options),
        Some(Command::Completions { shell }) => manual::completions(*shell),
        Some(Command::Man { command }) => manual::page(command.as_deref()),
        None if let Some(command) = manual::misspelt(&cli.options.scenes) => Err(Failure::Usage(command)),
        #[cfg(feature = "window")]
        None => view::view_or_render(&cli.options),
        #[cfg(not(feature = "window"))]
        None => render::render_default(&cli.options)
            .inspect(|()| tell!("mobula: it was built without a window: that is why it is a picture")),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => end(&failure),
    }
}

fn end(failure: &Failure) -> ExitCode {
    if !matches!(failure, Failure::NobodyReads) {
        say!("mobula: error: {failure}");
    }
    failure.code()
}

/// Prints what was asked about the command itself, or what is wrong with the command line.
fn answered(answer: &clap::Error) -> ExitCode {
    match answer.print().and_then(|()| io::stdout().flush()) {
        Err(error) if !answer.use_stderr() => end(&unwritten(error).into()),
        _ => ExitCode::from(answer.exit_code() as u8),
    }
}

#[cfg(feature = "kernels")]
fn kernels(options: &mobula::kernels::Options) -> Result<(), Failure> {
    if options.plot.is_some() {
        signals::listen();
    }
    let all_right = mobula::kernels::run(options, &mut Out(io::stdout().lock()))?;
    if all_right { Ok(()) } else { Err(Failure::Output("a kernel is wrong: see the last column".to_owned())) }
}

/// Says so if a view that is chosen automatically cannot show everything, or there is nothing to show.
fn told_of_what_is_far(scene: &Scene) {
    let ((low, high), (all_low, all_high)) = (scene.bulk, scene.bounds());
    if !all_low.cmple(all_high).all() {
        if !(scene.geometry.list().is_empty() && scene.media.is_empty()) {
            say!("mobula: warning: nothing is left of the scene that could be seen");
        }
    } else if (low, high) != (all_low, all_high) {
        say!(
            "mobula: warning: some of the scene is far from the rest, which alone decides about view and light: most is from {low} to \
             {high}, all from {all_low} to {all_high}"
        );
    }
}

/// Prints to standard output.
fn print(text: &dyn Display) -> Result<(), Failure> {
    let mut out = Out(io::stdout().lock());
    writeln!(out, "{text}")?;
    Ok(out.flush()?)
}

/// Prints an object to standard output, with what could change how a terminal shows the rest written as its number.
fn print_object(object: &Value) -> Result<(), Failure> {
    let text: String = object
        .to_string()
        .chars()
        .map(|c| match c {
            ' '..='~' => String::from(c),
            _ if printable(&c.to_string()) == c.to_string() => String::from(c),
            _ => format!("\\u{:04x}", u32::from(c)),
        })
        .collect();
    print(&text)
}

/// Standard output, by which name its errors are told.
struct Out(io::StdoutLock<'static>);

impl Write for Out {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.write(bytes).map_err(unwritten)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush().map_err(unwritten)
    }
}

fn unwritten(error: io::Error) -> io::Error {
    io::Error::new(error.kind(), format!("standard output cannot be written: {error}"))
}

/// A pipeline that is ready to run, but for its display.
struct Prepared {
    pipeline: Pipeline<State>,
    settings: Settings,
    name: String,
    /// How time goes on.
    time: Option<Time>,
    /// How long it took to build what finds hits, and what is known of volumes.
    build_seconds: f64,
    #[cfg(feature = "window")]
    window: ForWindow,
}

/// What only a window wants to know.
#[cfg(feature = "window")]
struct ForWindow {
    /// The options that make the same.
    options: SceneOptions,
    /// Where the scene's files were put.
    place: Place,
    /// Is there a scene file that says how its volumes are shown?
    of_file: bool,
    /// The scene as a scene file.
    saved: Option<SavedScene>,
    /// Has nobody said where to look from?
    automatic: bool,
    /// The files that it comes from.
    files: Vec<PathBuf>,
}

/// Does what the options say: chooses the level, says so, loads the scenes, builds the pipeline. `sampler` is for those who do
/// not choose one. `all_steps`: not only the first step of time will be shown.
fn prepare(
    options: &SceneOptions,
    on_demand: bool,
    all_steps: bool,
    sampler: SamplerKind,
) -> Result<Prepared, Failure> {
    let token = match options.isa {
        Some(level) => AnyToken::for_level(level)?,
        None => AnyToken::from_env()?,
    };
    let packet = options.packet.unwrap_or(app::PacketWidth::best(token.level()));
    let threads = options.threads.unwrap_or(Config::default().threads);
    let counted = |count: usize, what: &str| format!("{count} {what}{}", if count == 1 { "" } else { "s" });
    let (rays, level) = (counted(packet.rays(), "ray"), token.level());
    tell!("mobula: {level}, packets of {rays}, {}", counted(threads, "thread"));

    let memory = memory::memory(options.memory);
    #[cfg_attr(not(feature = "window"), allow(unused_variables, reason = "for windows"))]
    let Loaded { mut scene, place, report } = scene::gather(&options.scenes, &options.raw, options.smooth, &memory)?;
    #[cfg(feature = "window")]
    let of_file = report.format == SCENE_FILE;
    // Options win over what scene files say.
    let said = scene.rendering.clone();
    let usual = Settings::default();
    let adaptive = options.adaptive.map(|threshold| {
        let most = options.samples.map_or(MOST_ADAPTIVE, SamplerKind::samples);
        SamplerKind::adaptive(most, threshold)
    });
    // A window refines its pictures however many samples a file has.
    let filed = said.sampler.map(|said| if on_demand { sampler.filtered_as(said) } else { said });
    let of_pixels = adaptive.or(options.samples).or(options.sampler).or(filed).unwrap_or(sampler);
    let of_pixels = if on_demand { of_pixels.refined() } else { of_pixels };
    let lens_given = options.aperture.is_some() || options.focus.is_some();
    let mut settings = Settings {
        token,
        packet,
        threads,
        size: options.size.or(said.size).unwrap_or(usual.size),
        view: None,
        camera: options.camera.or(lens_given.then_some(CameraKind::ThinLens)).or(said.camera).unwrap_or(usual.camera),
        lens: Lens {
            aperture: options.aperture.map(|radius| (radius * place.scale) as f32).or(said.aperture),
            focus: options.focus.map(|distance| (distance * place.scale) as f32).or(said.focus),
        },
        renderer: options.renderer.or(said.renderer).unwrap_or(usual.renderer),
        sampler: options.filter.into_iter().fold(of_pixels, SamplerKind::with_filter),
        traverser: options.traverser,
        balancer: options.balancer,
        acceleration: options.accel,
        shadows: !options.no_shadows && said.shadows.unwrap_or(usual.shadows),
        tone: Tone {
            curve: options.tone.or(said.tone).unwrap_or(usual.tone.curve),
            exposure: options.exposure.or(said.exposure).unwrap_or(usual.tone.exposure),
        },
        occlusion: options.ao.map(|reach| (reach * place.scale) as f32).or(said.occlusion).filter(|&reach| reach > 0.0),
        on_demand,
    };
    if lens_given && settings.camera != CameraKind::ThinLens {
        say!("mobula: warning: --aperture, --focus: the camera {} has no lens; thin-lens has", settings.camera);
    }
    let step = options.volumes.step.or(said.time.map(|time| time.shown)).unwrap_or(0);
    let steps = Steps { shown: step, all: all_steps, memory: memory.limit() };
    shown::without_effect(&scene, &options.volumes).iter().for_each(|warning| say!("mobula: warning: {warning}"));
    if step >= scene.steps() && scene.has_moving_meshes() {
        return Err(Failure::Usage(format!("--step {step}: there are {} steps of time, from 0", scene.steps())));
    }
    scene.show_meshes_at(step);
    let build = Build::from(settings.acceleration);
    particles::without_effect(&scene, &options.particles).iter().for_each(|warning| say!("mobula: warning: {warning}"));
    let (shown, shown_seconds) = render::timed(|| {
        shown::add(&mut scene, &options.volumes, &place, steps)?;
        particles::add(&mut scene, &options.particles, &place, steps, &build)
    });
    #[cfg_attr(not(feature = "window"), allow(unused_variables, reason = "for windows"))]
    let particles = shown?;
    scene.up = options.up.0.or(scene.up);
    match options.light {
        Some(LightChoice::At(values::Point(position))) => {
            scene.lights = vec![Arc::new(Point { position: place.put(position).into(), ..Point::KEY })];
        }
        Some(LightChoice::Camera) => scene.lights = vec![Arc::new(Head::default())],
        None => {}
    }
    if options.ground {
        scene.ground.get_or_insert_default();
    }
    if let Some(fog) = &options.fog {
        scene.media.retain(|medium| medium.downcast_ref::<Fog>().is_none());
        scene.media.push(Arc::new(fog.value));
    }
    if let Some(background) = &options.background {
        scene.background = match &background.value {
            BackgroundChoice::Plain(background) => Arc::clone(background),
            BackgroundChoice::File(file) => Arc::new(environment(file, 0.0, 1.0)?),
        };
    }
    if !scene.media.is_empty() && settings.renderer != RendererKind::Raytracer {
        say!("mobula: warning: the renderer {} shows no media (--transfer, --fog); raytracer does", settings.renderer);
    }
    let building = || -> Result<_, Failure> {
        let geometry = Geometries::build(scene.geometry.clone(), &build);
        Ok(app::pipeline_with_geometry(&scene, geometry.map_err(app::AppError::from)?, &settings)?)
    };
    let (pipeline, seconds) = render::timed(|| progress::watch("building", &build.progress, building));
    let mut pipeline = pipeline?;
    if seconds >= 0.5 {
        tell!("mobula: built in {seconds:.2} s");
    }

    let state = pipeline.state();
    told_of_what_is_far(&state.stack.scene);
    let mut chosen = *state.chosen();
    #[cfg(feature = "window")]
    let usual_view = (scene.view.is_none(), chosen.view);
    // Where the command line says which axis is up, it is that of the view too.
    let fov_said = said.fov;
    let up = said.up.filter(|_| options.up.0.is_none());
    chosen.view = Rendering { up, ..said }.view(chosen.view);
    let put = |point: values::Point| Vec3::from(place.put(point.0));
    chosen.view.eye = options.eye.map_or(chosen.view.eye, put);
    chosen.view.at = options.at.map_or(chosen.view.at, put);
    let usual = if settings.camera == CameraKind::Fisheye && fov_said.is_none() {
        Fisheye::DEFAULT_FOV
    } else {
        chosen.view.fov
    };
    chosen.view.fov = options.fov.unwrap_or(usual);
    let widest = settings.camera.widest();
    if chosen.view.fov > widest {
        return Err(Failure::Usage(format!(
            "--fov {}: the camera {} has a field of view of at most {widest} degrees; fisheye has up to 360",
            chosen.view.fov, settings.camera
        )));
    }
    if chosen.view.eye == chosen.view.at {
        let problem = "the eye is where it looks at, so that it looks nowhere: --eye and --at must be different points";
        return Err(Failure::Usage(problem.to_owned()));
    }
    state.choose(chosen);
    settings.view = Some(chosen.view);
    #[cfg(feature = "window")]
    let automatic = usual_view == (true, chosen.view);
    #[cfg(feature = "window")]
    let window = {
        let options = saved::options(options, particles, &scene, &state.stack.scene, &place);
        let saved = if on_demand { saved::scene(&options, &scene, of_file, place) } else { None };
        let files = view::files(&options.scenes, &scene.objects);
        ForWindow { options, place, of_file, saved, automatic, files }
    };
    Ok(Prepared {
        pipeline,
        settings,
        name: scene.name,
        time: said.time,
        build_seconds: shown_seconds + seconds,
        #[cfg(feature = "window")]
        window,
    })
}
