//! What went wrong with a file: its name, the line, the problem and the remedy, in one line.

use std::fmt;
use std::path::{Path, PathBuf};

use super::text::printable;

/// A file that could not be loaded. Prints as `file:line:column: problem; remedy`, without a line break.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub struct LoadError {
    /// The file as the user named it.
    pub file: PathBuf,
    /// The line, counted from 1, where lines mean anything.
    pub line: Option<u64>,
    /// The column of that line, in characters from 1, where it is known.
    pub column: Option<u64>,
    /// What is wrong.
    pub problem: String,
    /// What to do about it; may be empty.
    pub remedy: String,
}

impl LoadError {
    /// An error about `file` as a whole.
    pub fn new(file: &Path, problem: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { file: file.to_owned(), line: None, column: None, problem: problem.into(), remedy: remedy.into() }
    }

    /// The same error at a line and a column of it.
    #[must_use]
    pub fn at_column(mut self, line: u64, column: u64) -> Self {
        (self.line, self.column) = (Some(line), Some(column));
        self
    }

    /// The same error at a line.
    #[must_use]
    pub fn at(mut self, line: u64) -> Self {
        self.line = Some(line);
        self
    }
}

impl fmt::Display for LoadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", printable(&self.file.display().to_string()))?;
        if let Some(line) = self.line {
            write!(f, ":{line}")?;
        }
        if let Some(column) = self.column {
            write!(f, ":{column}")?;
        }
        write!(f, ": {}", printable(&self.problem))?;
        if !self.remedy.is_empty() {
            write!(f, "; {}", self.remedy)?;
        }
        Ok(())
    }
}
