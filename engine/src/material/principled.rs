//! Metallic-roughness surfaces, as glTF 2.0 has them (specification, appendix B): a rough boundary (GGX) over a diffuse base, or a
//! metal.
//!
//! Two things differ from the appendix, so that white surfaces lose and gain nothing: what light loses from facet to facet is
//! [added](super::albedo), and the base gets what the boundary does not reflect in all (as the appendix calls albedo scaling), instead
//! of what it does not reflect towards each light.

use glam::Vec3;

use super::gloss::Gloss;
use super::lambertian::scatter;
use super::microfacet::normal_reflectance;
use crate::math::normalize;
use crate::packet::{Column, Columns3, SubPacket, columns3, set_vec3, vec3};
use crate::scratch::{ForWidth, lend};
use crate::stack::{Context, Lit, Material};
use crate::texture::{ChannelMap, Map, Maps};

/// What most things are made of. Colours are linear RGB; numbers out of range count as the nearest that is within, NaN as 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Principled {
    /// What is scattered, or of metals, what is mirrored along the normal.
    pub base_color: Vec3,
    /// 1 for metals, 0 for all else.
    pub metallic: f32,
    /// From a mirror, 0, to a surface without highlights, 1.
    pub roughness: f32,
    /// Radiance of its own.
    pub emission: Vec3,
    /// The fraction of the light that the surface stops; the rest comes from behind, unbent.
    pub opacity: f32,
    /// Index of refraction, 1 or more: what is no metal mirrors as much as it says.
    pub ior: f32,
    /// Its textures; that of colours counts for `base_color`.
    pub maps: Maps,
    /// By which `metallic` is multiplied.
    pub metallic_map: Option<ChannelMap>,
    /// By which `roughness` is multiplied.
    pub roughness_map: Option<ChannelMap>,
    /// Colours by which the emission is multiplied.
    pub emission_map: Option<Map>,
}

impl Default for Principled {
    /// Light grey plastic.
    fn default() -> Self {
        Self {
            base_color: Vec3::splat(0.7),
            metallic: 0.0,
            roughness: 0.5,
            emission: Vec3::ZERO,
            opacity: 1.0,
            ior: 1.5,
            maps: Maps::default(),
            metallic_map: None,
            roughness_map: None,
            emission_map: None,
        }
    }
}

/// What surfaces are made of at hits: one row a hit. Numbers are in range. Who evaluates them writes all of it.
pub(super) struct Parameters {
    pub(super) base_color: Columns3,
    pub(super) metallic: Column<f32>,
    pub(super) roughness: Column<f32>,
    pub(super) emission: Columns3,
    pub(super) opacity: Column<f32>,
}

impl ForWidth for Parameters {
    fn for_width(width: usize) -> Self {
        Self {
            base_color: columns3(width),
            metallic: Column::new(width),
            roughness: Column::new(width),
            emission: columns3(width),
            opacity: Column::new(width),
        }
    }
}

/// The nearest number from 0 to 1.
pub(super) fn unit(x: f32) -> f32 {
    if x > 0.0 { x.min(1.0) } else { 0.0 }
}

impl Principled {
    /// With roughness in green and whether it is a metal in blue, as glTF has them.
    pub fn with_metallic_roughness(self, map: Option<Map>) -> Self {
        let channel = |channel| map.clone().map(|map| ChannelMap { map, channel });
        Self { roughness_map: channel(1), metallic_map: channel(2), ..self }
    }

    /// Fills the parameters of hits with the surface's own.
    fn fill(&self, hits: &mut SubPacket<'_>, to: &mut Parameters) {
        let count = hits.len();
        let color = |columns: &mut Columns3, color: Vec3, most: f32| {
            for (column, channel) in columns.iter_mut().zip(color.to_array()) {
                column[..count].fill(if channel > 0.0 { channel.min(most) } else { 0.0 });
            }
        };
        color(&mut to.base_color, self.base_color, 1.0);
        color(&mut to.emission, self.emission, f32::MAX);
        to.metallic[..count].fill(unit(self.metallic));
        to.roughness[..count].fill(unit(self.roughness));
        to.opacity[..count].fill(unit(self.opacity));
        if let Some(map) = &self.maps.color {
            multiply(hits, map, &mut to.base_color);
        }
        if let Some(map) = &self.emission_map {
            multiply(hits, map, &mut to.emission);
        }
        match (&self.roughness_map, &self.metallic_map) {
            // The same texture, as glTF has it: looked up once.
            (Some(rough), Some(metallic)) if rough.map == metallic.map => hits.sample(&rough.map, |i, texel| {
                to.roughness[i] *= texel[rough.channel];
                to.metallic[i] *= texel[metallic.channel];
            }),
            (rough, metallic) => {
                for (of, column) in [(rough, &mut to.roughness), (metallic, &mut to.metallic)] {
                    if let Some(of) = of {
                        hits.sample(&of.map, |i, texel| column[i] *= texel[of.channel]);
                    }
                }
            }
        }
    }
}

/// Multiplies colours at hits by those of a texture.
fn multiply(hits: &mut SubPacket<'_>, map: &Map, colors: &mut Columns3) {
    hits.sample(map, |i, texel| set_vec3(colors, i, vec3(colors, i) * texel.truncate()));
}

impl Material for Principled {
    fn shade(&self, context: &Context<'_>, hits: &mut SubPacket<'_>, lit: Lit<'_>) {
        let parameters: &mut Parameters = &mut lend(context.width);
        self.fill(hits, parameters);
        if let Some(own) = hits.own_colors() {
            for (column, own) in parameters.base_color.iter_mut().zip(own) {
                column.iter_mut().zip(own).for_each(|(channel, own)| *channel *= own);
            }
        }
        evaluate(context, hits, lit, self.ior, parameters);
    }

    fn maps(&self) -> &Maps {
        &self.maps
    }

    fn base_color(&self) -> Vec3 {
        self.base_color
    }

    fn opacity(&self) -> f32 {
        unit(self.opacity)
    }

    fn describe(&self) -> String {
        let Vec3 { x, y, z } = self.base_color;
        let what = if self.metallic > 0.5 { "metal" } else { "plastic" };
        let mut text = format!("{what} ({x:.2}, {y:.2}, {z:.2}), roughness {:.2}", self.roughness);
        if self.opacity < 1.0 {
            text.push_str(&format!(", opacity {:.2}", self.opacity));
        }
        text.push_str(self.maps.describe());
        text
    }
}

/// Colours hits by what their surfaces are made of. `ior` is the index of refraction of what is no metal.
pub(super) fn evaluate(
    context: &Context<'_>,
    hits: &mut SubPacket<'_>,
    lit: Lit<'_>,
    ior: f32,
    parameters: &Parameters,
) {
    let count = hits.len();
    let color: &mut Columns3 = &mut lend(context.width);
    let gloss: &mut Gloss = &mut lend(context.width);
    scatter(context, lit, color);
    let reflectance = Vec3::splat(normal_reflectance(if ior > 1.0 { ior } else { 1.0 }));
    let directions = &hits.directions();
    for i in 0..count {
        let cosine = -normalize(vec3(directions, i)).dot(lit.normal(i));
        let (base, metallic) = (vec3(&parameters.base_color, i), parameters.metallic[i]);
        let layers = [(1.0 - metallic, reflectance), (metallic, base)];
        let [boundary, _] = gloss.set(i, cosine, parameters.roughness[i], layers);
        let scattered = base * (Vec3::ONE - boundary) * (1.0 - metallic);
        let own = vec3(color, i) * scattered + vec3(&parameters.emission, i);
        set_vec3(color, i, own);
    }
    gloss.add_lights(hits, lit, color);
    gloss.add_surroundings(context, hits, lit, color);
    hits.set_colors(color);
    let opacities = &parameters.opacity[..count];
    if opacities.iter().any(|&opacity| opacity < 1.0) {
        hits.fade(opacities);
    }
}
