//! Polished and rough metals: they mirror, with a colour, and scatter nothing.

use glam::Vec3;

use super::gloss::Gloss;
use super::principled::unit;
use crate::math::normalize;
use crate::packet::{Columns3, SubPacket, vec3};
use crate::scratch::lend;
use crate::stack::{Context, Lit, Material};

/// A conductor. Its reflectance goes from its colour along the normal to white at grazing angles (Schlick 1994).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Metal {
    /// Reflectance along the normal, linear RGB from 0 to 1: 1.00, 0.77, 0.34 for gold, 0.95, 0.64, 0.54 for copper.
    pub color: Vec3,
    /// From a mirror, 0, to 1.
    pub roughness: f32,
}

impl Default for Metal {
    /// Iron, brushed.
    fn default() -> Self {
        Self { color: Vec3::new(0.56, 0.57, 0.58), roughness: 0.3 }
    }
}

impl Material for Metal {
    fn shade(&self, context: &Context<'_>, hits: &mut SubPacket<'_>, lit: Lit<'_>) {
        let gloss: &mut Gloss = &mut lend(context.width);
        let color: &mut Columns3 = &mut lend(context.width);
        let reflectance = Vec3::from(self.color.to_array().map(unit));
        let own = hits.own_colors().is_some();
        for i in 0..hits.len() {
            let tint = match hits.own_colors().filter(|_| own) {
                Some(own) => reflectance * vec3(&own, i),
                None => reflectance,
            };
            let cosine = -normalize(vec3(&hits.directions(), i)).dot(lit.normal(i));
            let [_] = gloss.set(i, cosine, unit(self.roughness), [(1.0, tint)]);
        }
        color.iter_mut().for_each(|column| column[..lit.len()].fill(0.0));
        gloss.add_lights(hits, lit, color);
        gloss.add_surroundings(context, hits, lit, color);
        hits.set_colors(color);
    }

    fn base_color(&self) -> Vec3 {
        self.color
    }

    fn describe(&self) -> String {
        let Vec3 { x, y, z } = self.color;
        format!("metal ({x:.2}, {y:.2}, {z:.2}), roughness {:.2}", self.roughness)
    }
}
