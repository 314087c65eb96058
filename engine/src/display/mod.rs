//! Displays: where finished pictures go.
//!
//! The trait [`Display`] and the stage that calls it belong to the [`pipeline`](crate::pipeline); here is what they show
//! pictures on: files, a window, nothing.

mod error;
mod exr;
mod file;
mod format;
mod jpeg;
mod legend;
pub mod png;
mod ppm;
mod sheet;
pub mod stereo;
#[cfg(feature = "window")]
pub mod window;

pub use error::PictureError;
pub use file::{PictureFile, STANDARD_OUTPUT, is_numbered};
pub use format::PictureFormat;
pub use legend::legend;
pub use sheet::{Corner, Sheet};

pub use crate::pipeline::{Display, NullDisplay, Picture, Shown};
