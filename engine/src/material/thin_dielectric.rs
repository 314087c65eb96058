//! Window glass: two boundaries so near to each other that light goes on as it came.

use glam::Vec3;

use super::interface::{Interface, add_glints};
use super::microfacet::{fresnel, normal_reflectance};
use super::principled::unit;
use crate::math::normalize;
use crate::packet::{Columns3, SubPacket, set_vec3, vec3};
use crate::scratch::lend;
use crate::stack::{Context, Lit, Material};

/// A pane. What it reflects is the sum over all ways between its two sides: `2 F / (1 + F)`, where each side alone reflects `F`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThinDielectric {
    /// Index of refraction.
    pub ior: f32,
    /// What is left of light that goes through, beside what is reflected, linear RGB from 0 to 1.
    pub color: Vec3,
}

impl Default for ThinDielectric {
    /// Clear glass.
    fn default() -> Self {
        Self { ior: 1.5, color: Vec3::ONE }
    }
}

impl ThinDielectric {
    /// The index of refraction, in range.
    fn index(&self) -> f32 {
        if self.ior > 0.0 && self.ior.is_finite() { self.ior.clamp(0.01, 100.0) } else { 1.0 }
    }

    /// The colour, in range.
    fn tint(&self) -> Vec3 {
        Vec3::from(self.color.to_array().map(unit))
    }
}

/// What both sides reflect together.
fn of_both(reflected: f32) -> f32 {
    2.0 * reflected / (1.0 + reflected)
}

impl Material for ThinDielectric {
    fn shade(&self, context: &Context<'_>, hits: &mut SubPacket<'_>, lit: Lit<'_>) {
        let (index, tint) = (self.index(), self.tint());
        let pane: &mut Interface = &mut lend(context.width);
        let color: &mut Columns3 = &mut lend(context.width);
        for i in 0..hits.len() {
            let direction = normalize(vec3(&hits.directions(), i));
            let cosine = (-direction.dot(lit.normal(i))).clamp(0.0, 1.0);
            pane.reflected[i] = of_both(fresnel(cosine, index).0);
            set_vec3(&mut pane.through, i, direction);
            set_vec3(&mut pane.tints[0], i, Vec3::ONE);
            set_vec3(&mut pane.tints[1], i, tint);
        }
        pane.look_both_ways(context, hits, lit, color);
        add_glints(context, hits, lit, of_both(normal_reflectance(index)), |_| true, color);
        hits.set_colors(color);
    }

    fn base_color(&self) -> Vec3 {
        self.tint()
    }

    /// Along the normal, by the mean of the colour.
    fn opacity(&self) -> f32 {
        let Vec3 { x, y, z } = self.tint();
        1.0 - (1.0 - of_both(normal_reflectance(self.index()))) * ((x + y + z) * (1.0 / 3.0))
    }

    fn describe(&self) -> String {
        let Vec3 { x, y, z } = self.color;
        format!("window glass ({x:.2}, {y:.2}, {z:.2}), index of refraction {:.2}", self.ior)
    }
}
