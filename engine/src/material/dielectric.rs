//! Glass, water, gems: bodies that bend light and may absorb it on its way.

use std::sync::Arc;

use glam::Vec3;

use super::interface::{Interface, add_glints};
use super::microfacet::{fresnel, normal_reflectance};
use crate::math::{exp_minus, log2, normalize};
use crate::packet::{Columns3, SubPacket, set_vec3, vec3};
use crate::scratch::lend;
use crate::stack::{Context, Lit, Material};

/// The smooth boundary of a transparent body. Which side is in the body is as the geometric normal says, which points out of it: the
/// corners of meshes are counter-clockwise as seen from outside. A ray is reflected or refracted as Fresnel's and Snell's laws say, or
/// reflected in all. What is in the body, where rays end in it, is seen as if nothing were absorbed before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dielectric {
    /// Index of refraction of the body relative to what is around it.
    pub ior: f32,
    /// What is left of light after a way of [`distance`](Self::distance) in the body, linear RGB from 0 to 1 (Beer-Lambert).
    pub color: Vec3,
    /// A length in units of the scene.
    pub distance: f32,
}

impl Default for Dielectric {
    /// Clear glass.
    fn default() -> Self {
        Self { ior: 1.5, color: Vec3::ONE, distance: 1.0 }
    }
}

/// Black glass lets this much through: absorption has no end.
const DARKEST: f32 = 1e-6;

impl Dielectric {
    /// The index of refraction, in range.
    fn index(&self) -> f32 {
        if self.ior > 0.0 && self.ior.is_finite() { self.ior.clamp(0.01, 100.0) } else { 1.0 }
    }

    /// Absorption coefficients, per unit of length.
    fn absorption(&self) -> Vec3 {
        let distance = if self.distance > 0.0 { self.distance } else { f32::INFINITY };
        let of = |left: f32| {
            let left = if left > DARKEST { left.min(1.0) } else { DARKEST };
            (-log2(f64::from(left)) * std::f64::consts::LN_2) as f32 / distance
        };
        Vec3::from(self.color.to_array().map(of))
    }
}

impl Material for Dielectric {
    fn shade(&self, context: &Context<'_>, hits: &mut SubPacket<'_>, lit: Lit<'_>) {
        let (index, absorption) = (self.index(), self.absorption());
        // As they are, before they are turned to where rays come from.
        hits.geometric_normals();
        let boundary: &mut Interface = &mut lend(context.width);
        let color: &mut Columns3 = &mut lend(context.width);
        let inside: &mut crate::packet::Column<u8> = &mut lend(context.width);
        for i in 0..hits.len() {
            let direction = vec3(&hits.directions(), i);
            let leaves = vec3(&hits.geometric_normals(), i).dot(direction) > 0.0;
            let length = hits.distances()[i] * direction.length();
            let (direction, normal) = (normalize(direction), lit.normal(i));
            let eta = if leaves { 1.0 / index } else { index };
            let cosine = (-direction.dot(normal)).clamp(0.0, 1.0);
            let (reflected, behind) = fresnel(cosine, eta);
            let refracted = (direction + normal * cosine) * (1.0 / eta) - normal * behind;
            let left = match leaves {
                true => Vec3::from(absorption.to_array().map(|a| exp_minus(a * length))),
                false => Vec3::ONE,
            };
            inside[i] = u8::from(leaves);
            boundary.reflected[i] = reflected;
            set_vec3(&mut boundary.through, i, normalize(refracted));
            boundary.tints.iter_mut().for_each(|tint| set_vec3(tint, i, left));
        }
        boundary.look_both_ways(context, hits, lit, color);
        add_glints(context, hits, lit, normal_reflectance(index), |i| inside[i] == 0, color);
        hits.set_colors(color);
    }

    fn base_color(&self) -> Vec3 {
        self.color
    }

    /// Light goes straight through, in shadows; what is absorbed is left aside, as is what it is gathered to.
    fn opacity(&self) -> f32 {
        normal_reflectance(self.index())
    }

    fn scaled(&self, scale: f32) -> Option<Arc<dyn Material>> {
        Some(Arc::new(Self { distance: self.distance * scale, ..*self }))
    }

    fn describe(&self) -> String {
        let Vec3 { x, y, z } = self.color;
        let mut text = format!("dielectric, index of refraction {:.2}", self.ior);
        if self.color != Vec3::ONE {
            text.push_str(&format!(", ({x:.2}, {y:.2}, {z:.2}) after {}", self.distance));
        }
        text
    }
}
