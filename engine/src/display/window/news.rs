//! What is told to a window, and what goes wrong with one.

use crate::pipeline::Fault;

/// What the event loop is told by other threads.
#[derive(Debug)]
pub(super) enum News {
    /// There is a new picture.
    Picture,
    /// A screenshot was written, or not.
    Screenshot(Result<String, String>),
    /// The pipeline's run is over.
    Ended,
}

/// Why a window did not work.
#[derive(Debug, thiserror::Error)]
pub enum WindowError {
    /// There is no display, or it refuses.
    #[error("{0}")]
    Open(String),
    /// Rendering failed.
    #[error(transparent)]
    Fault(#[from] Fault),
}
