//! Backgrounds: what colours the rays that hit nothing.
//!
//! A new background is a file with the trait [`Background`], and a line in [`BackgroundKind`].

mod constant;
mod daylight;
mod gradient;
mod kind;

pub use constant::Constant;
pub use daylight::Daylight;
pub use gradient::Gradient;
pub use kind::{BackgroundKind, parse};

pub use crate::stack::Background;
