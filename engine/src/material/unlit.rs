//! Materials that no light changes.

use glam::Vec3;

use super::lambertian::diffuse;
use crate::packet::{Columns3, SubPacket};
use crate::scratch::lend;
use crate::stack::{Context, Lit, Material};
use crate::texture::Maps;

/// The same colour in any light.
#[derive(Clone, Debug, PartialEq)]
pub struct Flat {
    /// The colour, linear RGB.
    pub color: Vec3,
    /// Its textures.
    pub maps: Maps,
}

impl Flat {
    /// Without textures.
    pub fn new(color: Vec3) -> Self {
        Self { color, maps: Maps::default() }
    }
}

impl Default for Flat {
    /// A light grey, which is seen before black and before white.
    fn default() -> Self {
        Self::new(Vec3::splat(0.7))
    }
}

impl Material for Flat {
    fn shade(&self, context: &Context<'_>, hits: &mut SubPacket<'_>, _: Lit<'_>) {
        if self.maps.color.is_none() && hits.own_colors().is_none() {
            return hits.fill_color(self.color);
        }
        let colors: &mut Columns3 = &mut lend(context.width);
        colors.iter_mut().for_each(|column| column[..hits.len()].fill(1.0));
        diffuse(hits, self.color, &self.maps, colors);
        hits.set_colors(colors);
    }

    fn maps(&self) -> &Maps {
        &self.maps
    }

    fn is_lit(&self) -> bool {
        false
    }

    fn base_color(&self) -> Vec3 {
        self.color
    }

    fn describe(&self) -> String {
        let Vec3 { x, y, z } = self.color;
        format!("flat ({x:.2}, {y:.2}, {z:.2}){}", self.maps.describe())
    }
}

/// The shading normal as a colour: `(n + 1) / 2`, for looking at geometry.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NormalColor;

impl NormalColor {
    /// Writes the colours.
    pub(crate) fn show(hits: &mut SubPacket<'_>) {
        let (normals, colors) = hits.normals_and_colors();
        for (out, normal) in colors.into_iter().zip(normals) {
            out.iter_mut().zip(normal).for_each(|(out, normal)| *out = normal * 0.5 + 0.5);
        }
    }
}

impl Material for NormalColor {
    fn shade(&self, _: &Context<'_>, hits: &mut SubPacket<'_>, _: Lit<'_>) {
        Self::show(hits);
    }

    fn is_lit(&self) -> bool {
        false
    }

    fn base_color(&self) -> Vec3 {
        Vec3::splat(0.5)
    }

    fn describe(&self) -> String {
        "normal as colour".to_owned()
    }
}
