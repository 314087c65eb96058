//! `mobula view`, and `mobula` without a subcommand: a window.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use mobula::app::Settings;
use mobula::display::window::{Connection, Loader, Ready, SAMPLES, Titles, WindowError, has_display, help};
use mobula::load::series;
use mobula::sampler::SamplerKind;
use mobula::scene::Object;

use super::args::SceneOptions;
use super::failure::Failure;
use super::values::{Shading, quoted};
use super::{ForWindow, Prepared, memory, prepare, progress, render, scene, signals, tell};

/// A window if there is a display, else a picture.
pub(crate) fn view_or_render(options: &SceneOptions) -> Result<(), Failure> {
    let connection = if has_display() { Connection::open().ok() } else { None };
    match connection {
        Some(connection) => show(connection, options),
        None => {
            render::render_default(options)?;
            tell!("mobula: there is no display for a window: that is why it is a picture");
            Ok(())
        }
    }
}

pub(crate) fn view(options: &SceneOptions) -> Result<(), Failure> {
    match Connection::open() {
        Ok(connection) => show(connection, options),
        Err(error) => {
            // What is wrong with the scenes is told first: it is wrong on every display.
            scene::gather(&options.scenes, &options.raw, options.smooth, &memory::memory(options.memory))?;
            Err(error.into())
        }
    }
}

fn show(connection: Connection, options: &SceneOptions) -> Result<(), Failure> {
    tell!("{}", help());
    // Screenshots are files too.
    signals::listen();
    let scenes = Arc::new(Scenes { options: options.clone(), failure: Mutex::default() });
    let size = options.size.unwrap_or(Settings::default().size);
    let shown = connection.load(Arc::clone(&scenes) as Arc<dyn Loader>, size);
    let failure = scenes.failure.lock().unwrap_or_else(PoisonError::into_inner).take();
    match (shown, failure) {
        (Err(WindowError::Load(_)), Some(failure)) => Err(failure),
        (shown, _) => Ok(shown?),
    }
}

/// Loads what the command line names, or files that are dropped on the window, as its options say.
struct Scenes {
    options: SceneOptions,
    /// Why the last one could not be loaded.
    failure: Mutex<Option<Failure>>,
}

impl Loader for Scenes {
    fn load(&self, files: &[PathBuf]) -> Result<Ready, String> {
        let mut options = self.options.clone();
        if !files.is_empty() {
            options.scenes = files.to_vec();
            // Where somebody looks from is another matter in another scene.
            (options.eye, options.at) = (None, None);
        }
        ready(&options).map_err(|failure| {
            let problem = failure.to_string();
            *self.failure.lock().unwrap_or_else(PoisonError::into_inner) = Some(failure);
            problem
        })
    }

    fn progress(&self) -> Option<(String, Option<f64>)> {
        progress::watched()
    }
}

/// A scene for the window.
fn ready(options: &SceneOptions) -> Result<Ready, Failure> {
    let sampler = SamplerKind::of_samples(SAMPLES);
    let Prepared { pipeline, settings, name, time, window, .. } = prepare(options, true, true, sampler)?;
    let ForWindow { options, place, of_file, saved, automatic, files } = window;
    let scene = options.scene_words();
    let shading = match options.volumes.shading {
        Shading::Auto => None,
        Shading::On => Some("on".to_owned()),
        Shading::Off => Some("off".to_owned()),
    };
    let transfer = options.volumes.transfer.iter().map(ToString::to_string).collect();
    let words = options.particles.color_words();
    let coloring = words.map(|(name, value)| format!(" --{name} {}", quoted(&value))).collect();
    let titles =
        Titles { name, scene, transfer, shading, coloring, quoted, place, of_file, saved, time, automatic, files };
    Ok(Ready { pipeline, settings, titles })
}

/// The files that scenes come from, as far as it is known: those on the command line, and those that scene files name.
pub(crate) fn files(names: &[PathBuf], objects: &[Object]) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = names.iter().flat_map(|name| series::expand(name).unwrap_or_default()).collect();
    for folder in names.iter().map(|name| name.parent().unwrap_or(Path::new(""))) {
        let named = objects.iter().flat_map(|object| &object.names).map(|name| folder.join(name));
        files.extend(named.flat_map(|name| series::expand(&name).unwrap_or_default()));
    }
    files.retain(|file| file.is_file());
    files.sort_unstable();
    files.dedup();
    files
}

impl From<WindowError> for Failure {
    fn from(error: WindowError) -> Self {
        match error {
            WindowError::Open(problem) => Self::Window(problem),
            WindowError::Load(problem) => Self::Output(problem),
            WindowError::Fault(fault) => fault.into(),
        }
    }
}
