//! Why a picture could not be written, and what to do about it.

use std::io;
use std::path::{Path, PathBuf};

/// A picture that could not be written.
#[derive(Debug, thiserror::Error)]
#[error("{}: cannot be written: {problem}; {}", file.display(), remedy(problem))]
pub struct PictureError {
    /// The file as it was named.
    pub file: PathBuf,
    /// What the system said.
    pub problem: io::Error,
}

fn remedy(problem: &io::Error) -> &'static str {
    match problem.kind() {
        io::ErrorKind::NotFound => "make the folder first",
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => "free some space or choose another folder",
        io::ErrorKind::IsADirectory => "add a file name",
        io::ErrorKind::InvalidFilename => "choose a shorter name",
        _ => "choose another folder",
    }
}

impl PictureError {
    /// A problem with a file.
    pub(super) fn new(file: &Path, problem: io::Error) -> Self {
        Self { file: file.to_owned(), problem }
    }
}
