//! `mobula view`, and `mobula` without a subcommand: a window.

use mobula::display::window::{Connection, HELP, WindowError, has_display};

use super::args::SceneOptions;
use super::failure::Failure;
use super::{Prepared, prepare, render};

/// A window if there is a display, else a picture.
pub(crate) fn view_or_render(options: &SceneOptions) -> Result<(), Failure> {
    let connection = if has_display() { Connection::open().ok() } else { None };
    match connection {
        Some(connection) => show(connection, options),
        None => {
            let result = render::render_default(options);
            eprintln!("mobula: no display for a window: that is why there is a picture instead");
            result
        }
    }
}

pub(crate) fn view(options: &SceneOptions) -> Result<(), Failure> {
    show(Connection::open()?, options)
}

fn show(connection: Connection, options: &SceneOptions) -> Result<(), Failure> {
    let Prepared { pipeline, settings, name } = prepare(options, true)?;
    eprintln!("{HELP}");
    Ok(connection.show(pipeline, &settings, &name)?)
}

impl From<WindowError> for Failure {
    fn from(error: WindowError) -> Self {
        match error {
            WindowError::Open(problem) => Self::Window(problem),
            WindowError::Fault(fault) => Self::Fault(fault),
        }
    }
}
