//! `mobula view`, and `mobula` without a subcommand: a window.

use mobula::display::window::{Connection, HELP, Titles, WindowError, has_display};
use mobula::sampler::SamplerKind;

use super::args::SceneOptions;
use super::failure::Failure;
use super::values::{Shading, quoted};
use super::{ForWindow, Prepared, memory, prepare, render, scene, signals, tell};

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
    let Prepared { pipeline, settings, name, time, window, .. } = prepare(options, true, true, SamplerKind::Single)?;
    tell!("{HELP}");
    // Screenshots are files too.
    signals::listen();
    let ForWindow { options, place, of_file, saved } = window;
    let scene = options.scene_words();
    let shading = match options.volumes.shading {
        Shading::Auto => None,
        Shading::On => Some("on".to_owned()),
        Shading::Off => Some("off".to_owned()),
    };
    let transfer = options.volumes.transfer.iter().map(ToString::to_string).collect();
    let words = options.particles.color_words();
    let coloring = words.map(|(name, value)| format!(" --{name} {}", quoted(&value))).collect();
    let titles = Titles { name, scene, transfer, shading, coloring, quoted, place, of_file, saved, time };
    Ok(connection.show(pipeline, &settings, &titles)?)
}

impl From<WindowError> for Failure {
    fn from(error: WindowError) -> Self {
        match error {
            WindowError::Open(problem) => Self::Window(problem),
            WindowError::Fault(fault) => fault.into(),
        }
    }
}
