//! The materials that there are, each with usual parameters.

use glam::Vec3;

use super::{
    Checker, Dielectric, Flat, Lambertian, Metal, NormalColor, OrenNayar, Phong, Principled, ThinDielectric, Wireframe,
};
use crate::choice::choice;
use crate::stack::Material;

choice! {
    /// A kind of material.
    "material" MaterialKind -> Material {
        /// The same brightness from all directions.
        Lambertian = "lambertian" => Lambertian::default(),
        /// Lambertian, a highlight, mirror reflection, thin transparency.
        Phong = "phong" => Phong::default(),
        /// Metallic-roughness, as glTF has it: plastics and metals, from matt to mirrors.
        Principled = "principled" => Principled::default(),
        /// Mirrors with a colour, polished or brushed.
        Metal = "metal" => Metal::default(),
        /// Glass, water, gems: bends light.
        Dielectric = "dielectric" => Dielectric::default(),
        /// Window glass: does not.
        ThinDielectric = "thin-dielectric" => ThinDielectric::default(),
        /// Rough and matt: clay, plaster.
        OrenNayar = "oren-nayar" => OrenNayar::default(),
        /// Two colours by turns.
        Checker = "checker" => Checker::default(),
        /// The edges of triangles.
        Wireframe = "wireframe" => Wireframe::default(),
        /// Constant colour, not lit.
        Flat = "flat" => Flat::default(),
        /// The same, of any brightness: what glows.
        Emissive = "emissive" => Flat::new(Vec3::ONE),
        /// The shading normal as a colour.
        NormalColor = "normal-color" => NormalColor,
    }
}
