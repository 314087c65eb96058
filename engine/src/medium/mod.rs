//! Media: what is between surfaces.
//!
//! A new medium is a file with the trait [`Medium`].

mod composite;
mod fog;

pub use composite::{attenuate, composite};
pub use fog::Fog;

pub use crate::stack::{Medium, Segments};
