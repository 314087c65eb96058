//! What is told to a window, and what goes wrong with one.

use std::io::{self, Write as _};
use std::path::PathBuf;

use crate::app::{Picked, Settings, State};
use crate::camera::View;
use crate::load::{Place, SavedScene};
use crate::pipeline::{Fault, Pipeline};
use crate::scene::Time;

/// What the window says of what it shows.
#[derive(Clone, Debug)]
pub struct Titles {
    /// The scene's name.
    pub name: String,
    /// What names the scene on the command line of `mobula render`, as a shell takes it; without what a viewer can change.
    pub scene: String,
    /// The transfer functions that volumes are shown with, in words of that command.
    pub transfer: Vec<String>,
    /// Whether they are lit, if that was said.
    pub shading: Option<String>,
    /// What decides about the colours of particles, in words of that command.
    pub coloring: String,
    /// How a shell takes a word.
    pub quoted: fn(&str) -> String,
    /// Where its files were put.
    pub place: Place,
    /// Does a scene file say what volumes are shown as? The command line then says nothing of that.
    pub of_file: bool,
    /// The scene as a scene file, if there can be one.
    pub saved: Option<SavedScene>,
    /// How time goes on, if the scene says so.
    pub time: Option<Time>,
    /// Is the view one that was chosen so that all is seen? Then it goes with the window's size until somebody moves it.
    pub automatic: bool,
    /// The files that it was loaded from: when these change it is loaded again.
    pub files: Vec<PathBuf>,
}

/// A scene that a window can show.
#[derive(Debug)]
pub struct Ready {
    /// Renders on demand, in one channel; without a display.
    pub pipeline: Pipeline<State>,
    /// What it was made with.
    pub settings: Settings,
    /// What the window says of it.
    pub titles: Titles,
}

/// What the event loop is told by other threads.
#[derive(Debug)]
pub(super) enum News {
    /// There is a new picture.
    Picture,
    /// A screenshot was written, or not.
    Screenshot(Result<String, String>),
    /// The run of the pipeline of a number is over.
    Ended(u64),
    /// A scene was loaded, or not: the number of the request, the files that were dropped for it.
    Loaded(u64, Vec<PathBuf>, Result<Box<Ready>, String>),
    /// The pipeline of a number has chosen a view; is it one that goes with the window's size?
    View(u64, View, bool),
    /// What is at a place, for the pipeline of a number; should it come into the middle?
    Picked(u64, Option<Picked>, bool),
}

/// Why a window did not work.
#[derive(Debug, thiserror::Error)]
pub enum WindowError {
    /// There is no display, or it refuses.
    #[error("{0}")]
    Open(String),
    /// Nothing could be loaded.
    #[error("{0}")]
    Load(String),
    /// Rendering failed.
    #[error(transparent)]
    Fault(#[from] Fault),
}

/// Tells people something on standard error. A window goes on when nobody can be told.
pub(super) fn tell(text: std::fmt::Arguments<'_>) {
    let _ = writeln!(io::stderr().lock(), "{text}");
}

/// What winit says, without the place in its own source that it begins with.
pub(super) fn without_place(error: &dyn std::fmt::Display) -> String {
    let text = error.to_string();
    // "os error at FILE:LINE: PROBLEM", where the problem is what is left.
    let problem = text.strip_prefix("os error at ").and_then(|text| {
        let (place, problem) = text.split_once(": ")?;
        place.ends_with(|last: char| last.is_ascii_digit()).then_some(problem)
    });
    problem.unwrap_or(&text).trim_end_matches('.').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_in_sources_are_left_out() {
        assert_eq!(without_place(&"os error at /a b/c-0.1/x.rs:765: no display: none."), "no display: none");
        assert_eq!(without_place(&"os error at home: none"), "os error at home: none");
        assert_eq!(without_place(&"not supported"), "not supported");
    }
}
