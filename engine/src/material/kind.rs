//! The materials that there are, each with usual parameters.

use super::{Flat, Lambertian, NormalColor, Phong};
use crate::choice::choice;
use crate::stack::Material;

choice! {
    /// A kind of material.
    "material" MaterialKind -> Material {
        /// The same brightness from all directions.
        Lambertian = "lambertian" => Lambertian::default(),
        /// Lambertian, a highlight, mirror reflection, thin transparency.
        Phong = "phong" => Phong::default(),
        /// Constant colour, not lit.
        Flat = "flat" => Flat::default(),
        /// The shading normal as a colour.
        NormalColor = "normal-color" => NormalColor,
    }
}
