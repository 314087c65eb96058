//! Materials that no light changes.

use glam::Vec3;

use crate::packet::{Columns3, SubPacket};
use crate::scratch::lend;
use crate::stack::{Context, Lit, Material};

/// The same colour everywhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flat {
    /// The colour, linear RGB.
    pub color: Vec3,
}

impl Default for Flat {
    /// A light grey, which is seen before black and before white.
    fn default() -> Self {
        Self { color: Vec3::splat(0.7) }
    }
}

impl Material for Flat {
    fn shade(&self, context: &Context<'_>, hits: &mut SubPacket<'_>, _: Lit<'_>) {
        let Some(own) = hits.own_colors() else { return hits.fill_color(self.color) };
        let colors: &mut Columns3 = &mut lend(context.width);
        for ((to, own), channel) in colors.iter_mut().zip(own).zip(self.color.to_array()) {
            to.iter_mut().zip(own).for_each(|(to, own)| *to = channel * own);
        }
        hits.set_colors(colors);
    }

    fn is_lit(&self) -> bool {
        false
    }

    fn base_color(&self) -> Vec3 {
        self.color
    }

    fn describe(&self) -> String {
        format!("flat ({:.2}, {:.2}, {:.2})", self.color.x, self.color.y, self.color.z)
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
