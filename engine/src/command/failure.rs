//! How the command ends when it does not end well.

use std::io;
use std::process::ExitCode;

use mobula::app::AppError;
use mobula::load::LoadError;
use mobula::pipeline::Fault;
use mobula_core::simd::{EnvError, Unavailable};

/// Why the command stops; prints as one line.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Failure {
    /// A file could not be loaded.
    #[error("{0}")]
    Load(#[from] LoadError),
    /// A scene name that is not known.
    #[error("{0}: no such generated scene; there are {1}")]
    UnknownScene(String, String),
    /// The scene cannot be rendered.
    #[error("{0}")]
    App(#[from] AppError),
    /// A level that this machine does not have.
    #[error("{0}")]
    Level(#[from] Unavailable),
    /// The environment asks for a level that there is not.
    #[error("{0}")]
    Environment(#[from] EnvError),
    /// A picture could not be written.
    #[error("{0}")]
    Output(String),
    /// Nobody reads standard output to its end. Whoever stopped knows: nothing is said.
    #[error("standard output was closed")]
    NobodyReads,
    /// A component failed.
    #[error("{0}; this is a bug: please report it")]
    Fault(Fault),
    /// The window.
    #[cfg(feature = "window")]
    #[error("cannot open a window: {0}; `mobula render` writes a picture instead")]
    Window(String),
    /// What was asked for makes no sense together.
    #[error("{0}")]
    Usage(String),
    /// Ctrl-C, and at least how many frames had been written.
    #[error("interrupted; {}", written(*.0))]
    Interrupted(u64),
}

impl Failure {
    /// The exit status.
    pub(crate) fn code(&self) -> ExitCode {
        ExitCode::from(match self {
            Self::UnknownScene(..) | Self::Usage(_) | Self::Environment(EnvError::Unknown(..)) => 2,
            Self::Interrupted(_) => 130,
            _ => 1,
        })
    }
}

fn written(frames: u64) -> String {
    match frames {
        0 => "nothing was written".to_owned(),
        1 => "the first frame was written".to_owned(),
        _ => format!("the first {frames} frames were written"),
    }
}

impl From<Fault> for Failure {
    fn from(fault: Fault) -> Self {
        // What is no bug is no panic, and its message says all: a full disk, no memory.
        if fault.location.is_none() { Self::Output(fault.message) } else { Self::Fault(fault) }
    }
}

impl From<io::Error> for Failure {
    fn from(error: io::Error) -> Self {
        if error.kind() == io::ErrorKind::BrokenPipe { Self::NobodyReads } else { Self::Output(error.to_string()) }
    }
}
