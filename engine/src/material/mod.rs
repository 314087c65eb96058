//! Materials: what colours the rays that hit something.
//!
//! A new material is a file with its parameters and the trait [`Material`], and a line in [`MaterialKind`].

mod kind;
mod lambertian;
mod phong;
mod unlit;

pub use kind::MaterialKind;
pub use lambertian::Lambertian;
pub use phong::Phong;
pub use unlit::{Flat, NormalColor};

pub use crate::stack::{Material, NamedMaterial};
