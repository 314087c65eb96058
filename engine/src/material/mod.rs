//! Materials: what colours the rays that hit something.
//!
//! A new material is a file with its parameters and the trait [`Material`], and a line in [`MaterialKind`]. Those that mirror share
//! `gloss` (rough surfaces, hit by hit) and `interface` (smooth boundaries that let light through), which are above `albedo` (how much rough
//! surfaces reflect in all) and `microfacet` (how they do).

mod albedo;
mod checker;
mod dielectric;
mod gloss;
mod interface;
mod kind;
mod lambertian;
mod metal;
mod microfacet;
mod oren_nayar;
mod phong;
mod principled;
mod thin_dielectric;
mod unlit;
mod wireframe;

pub use checker::{Checker, Pattern};
pub use dielectric::Dielectric;
pub use kind::MaterialKind;
pub use lambertian::Lambertian;
pub use metal::Metal;
pub use oren_nayar::OrenNayar;
pub use phong::Phong;
pub use principled::Principled;
pub use thin_dielectric::ThinDielectric;
pub use unlit::{Flat, NormalColor};
pub use wireframe::{LineWidth, Wireframe};

pub use crate::stack::{Material, NamedMaterial};
