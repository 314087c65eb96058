//! Displays: where finished pictures go.
//!
//! The trait [`Display`] and the stage that calls it belong to the [`pipeline`](crate::pipeline); here is what they show
//! pictures on: a PNG file, a window, nothing.

mod legend;
pub mod png;
mod sheet;
pub mod stereo;
#[cfg(feature = "window")]
pub mod window;

pub use legend::legend;
pub use sheet::{Corner, Sheet};

pub use crate::pipeline::{Display, NullDisplay, Picture, Shown};
