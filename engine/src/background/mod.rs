//! Backgrounds: what colours the rays that hit nothing.
//!
//! A new background is a file with the trait [`Background`], and a line in [`BackgroundKind`].

mod constant;
mod daylight;
mod gradient;
mod kind;
mod panorama;

pub use constant::Constant;
pub use daylight::Daylight;
pub use gradient::Gradient;
pub use kind::{BackgroundKind, parse};
pub use panorama::Panorama;

pub use crate::stack::Background;
