//! `mobula render`: a scene to picture files.

use std::path::{Path, PathBuf};
use std::time::Instant;

use mobula::app::{RayCounts, State};
use mobula::display::is_numbered;
use mobula::load::printable;
use mobula::pipeline::{Pipeline, Report};
use mobula::sampler::{Filter, SamplerKind};
use mobula::traverse::TraverserKind;
use serde_json::json;

use super::args::{RenderOptions, SceneOptions};
use super::failure::Failure;
use super::progress::watch;
use super::scene::grouped;
use super::{Prepared, frames, prepare, print_object, say, signals, tell, viewpoints};

/// How files are sampled unless somebody says how.
const STILL: SamplerKind = SamplerKind::Sobol { samples: 16, filter: Filter::Gaussian };

pub(crate) fn render(options: &RenderOptions) -> Result<(), Failure> {
    let film = options.fps.is_some();
    let Prepared { mut pipeline, settings, build_seconds, time, .. } = prepare(&options.scene, false, film, STILL)?;
    let frames = options.turntable.unwrap_or(options.frames);
    let output = if options.turntable.is_some() { frames::numbered(&options.output) } else { options.output.clone() };
    let outputs = viewpoints::add(&mut pipeline, &settings, options, &output)?;
    if let Some(fps) = options.fps {
        frames::go_on(&mut pipeline, fps, time);
    }
    if settings.traverser == TraverserKind::Tiled {
        let pixels = settings.size.pixels() as u64 * outputs.channels();
        pipeline.state().progress.expect(pixels.saturating_mul(frames));
    }
    let report = run(&mut pipeline, frames, &output)?;
    let outputs = outputs.finish(&mut pipeline, report.frames)?;

    let rays = pipeline.state().rays();
    // Of rendering: writing the file comes after the last frame.
    let seconds = report.frame_times.mean * report.frames as f64;
    let fps = if seconds > 0.0 { report.frames as f64 / seconds } else { 0.0 };
    let rate = if seconds > 0.0 { rays.total() as f64 / seconds * 1e-6 } else { 0.0 };
    let frames = if report.frames == 1 { "1 frame".to_owned() } else { format!("{} frames", report.frames) };
    tell!(
        "mobula: wrote {} ({}), {frames} in {seconds:.3} s, {rate:.1} million rays a second",
        names(&outputs),
        settings.size
    );
    let started = report.threads.len();
    if started < settings.threads {
        say!("mobula: warning: only {started} of {} threads could be started", settings.threads);
    }
    if options.stats {
        print_statistics(&report, &rays, seconds);
    }
    if options.json {
        print_object(&json!({
            "level": settings.token.level().to_string(),
            "packet": settings.packet.rays(),
            "threads": settings.threads,
            "pinned_threads": report.threads.iter().filter(|thread| thread.pinned).count(),
            "size": [settings.size.width(), settings.size.height()],
            "frames": report.frames,
            "seconds": seconds,
            "fps": fps,
            "total_seconds": report.seconds,
            "rays": { "primary": rays.primary, "shadow": rays.shadow, "secondary": rays.secondary },
            "paths": {
                "common_origin": rays.paths.common_origin,
                "general": rays.paths.general,
                "single": rays.paths.single,
            },
            "mrays_per_second": rate,
            "output": outputs[0].to_string_lossy(),
            "outputs": outputs.iter().map(|output| output.to_string_lossy()).collect::<Vec<_>>(),
            "geometries": pipeline.state().stack.scene.geometry.list().len(),
            "build_seconds": build_seconds,
            "media": pipeline.state().stack.scene.media.len(),
            "camera": settings.camera.to_string(),
            "renderer": settings.renderer.to_string(),
            "sampler": settings.sampler.to_string(),
            "balancer": settings.balancer.to_string(),
            "acceleration": settings.acceleration.to_string(),
            "shadows": settings.shadows,
            "occlusion": settings.occlusion.map(|reach| reach.to_string()),
            "tone": settings.tone.curve.name(),
            "exposure": settings.tone.exposure,
        }))?;
    }
    Ok(())
}

/// Runs the pipeline so that Ctrl-C ends it between two tiles.
fn run(pipeline: &mut Pipeline<State>, frames: u64, output: &Path) -> Result<Report, Failure> {
    let (handle, progress) = (pipeline.handle(), pipeline.state().progress.clone());
    let rendering = || watch("rendering", &progress, || pipeline.run_refined(frames));
    let (report, interrupted) = signals::stopping(handle, rendering);
    let report = report?;
    match interrupted {
        false => Ok(report),
        true if is_numbered(output) => Err(Failure::Interrupted(report.frames.saturating_sub(1))),
        true => Err(Failure::Interrupted(0)),
    }
}

/// Files as people are told of them.
fn names(files: &[PathBuf]) -> String {
    let names = match files {
        [first, .., last] if files.len() > 8 => {
            format!("{} files, {} to {}", files.len(), first.display(), last.display())
        }
        _ => files.iter().map(|file| file.display().to_string()).collect::<Vec<_>>().join(", "),
    };
    printable(&names).into_owned()
}

fn print_statistics(report: &Report, rays: &RayCounts, seconds: f64) {
    let per_second = |count: u64| count as f64 / seconds.max(1e-9) * 1e-6;
    say!("  rays{:>30}{:>16}", "count", "million/s");
    for (name, count) in
        [("primary", rays.primary), ("shadow", rays.shadow), ("secondary", rays.secondary), ("all", rays.total())]
    {
        say!("    {name:<16}{:>14}{:>16.2}", grouped(count), per_second(count));
    }
    say!("  paths through acceleration structures");
    let paths = &rays.paths;
    for (name, count) in
        [("common origin", paths.common_origin), ("general", paths.general), ("single rays", paths.single)]
    {
        say!("    {name:<16}{:>14}", grouped(count));
    }
    let times = &report.frame_times;
    say!(
        "  frame times      median {:.2} ms, least {:.2} ms, 95 % within {:.2} ms",
        times.median * 1e3,
        times.min * 1e3,
        times.p95 * 1e3
    );
    for stage in &report.stages {
        say!("  stage {:<11}{:.3} s, all threads together", stage.name, stage.seconds);
    }
    for thread in &report.threads {
        let pinned = if thread.pinned { ", pinned" } else { "" };
        let (busy, waiting) = (thread.busy_seconds, thread.waiting_seconds);
        say!("  thread {:<10}busy {busy:.3} s, waiting {waiting:.3} s{pinned}", thread.index);
    }
    for note in &report.notes {
        say!("  note: {note}");
    }
}

/// How long something took, for people.
pub(crate) fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let start = Instant::now();
    let result = work();
    (result, start.elapsed().as_secs_f64())
}

/// What `mobula` without a window does.
pub(crate) fn render_default(options: &SceneOptions) -> Result<(), Failure> {
    let scene = options.clone();
    let output = "mobula.png".into();
    render(&RenderOptions {
        scene,
        output,
        frames: 1,
        turntable: None,
        fps: None,
        channels: 1,
        stereo: None,
        eye_distance: None,
        stats: false,
        legend: false,
        json: false,
    })
}
