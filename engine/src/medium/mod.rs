//! Media: what is between surfaces.
//!
//! A new medium is a file with the trait [`Medium`].
//!
//! | file | idea |
//! |---|---|
//! | `composite` | media before what rays see, and before lights |
//! | `several` | media that overlap |
//! | `volume` | a volume, as a transfer function shows it |
//! | `fog` | the same everywhere |

mod composite;
mod fog;
mod several;
#[cfg(test)]
mod tests;
mod volume;

pub use composite::{attenuate, composite};
pub use fog::Fog;
pub use volume::{Between, DEFAULT_STEP, LEAST_STEP, Volume};

pub use crate::stack::{Medium, Segments};
