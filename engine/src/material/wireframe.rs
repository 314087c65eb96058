//! The edges of triangles, over a matt surface: to look at meshes.

use std::sync::Arc;

use glam::Vec3;

use super::lambertian::{diffuse, scatter};
use super::principled::unit;
use crate::packet::{Column, Columns3, SubPacket, set_vec3, vec3};
use crate::scratch::lend;
use crate::stack::{Context, Lit, Material};
use crate::texture::Maps;

/// How wide the lines of a [`Wireframe`] are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LineWidth {
    /// In units of the scene. Each of two triangles has half of the line along their common edge.
    Units(f32),
    /// As a part of what fits into each triangle: of the diameter of its inscribed circle. At 1 there is nothing but line.
    Relative(f32),
    /// In pixels, wherever they are.
    Pixels(f32),
}

impl LineWidth {
    /// Half the width of lines at a hit of some hits, whose triangle has an inscribed circle of such a radius.
    fn half(self, hits: &SubPacket<'_>, i: usize, inscribed: f32) -> f32 {
        match self {
            Self::Units(width) => 0.5 * width,
            Self::Relative(part) => part * inscribed,
            Self::Pixels(width) => 0.5 * width * hits.pixel_width(i),
        }
    }
}

/// Draws the edges of triangles. Geometry without edges has the colour of the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wireframe {
    /// The colour of lines, linear RGB from 0 to 1; lit as the surface is.
    pub line: Vec3,
    /// Fraction of the light that the surface scatters.
    pub color: Vec3,
    /// How wide the lines are.
    pub width: LineWidth,
}

impl Default for Wireframe {
    /// Dark lines on light grey.
    fn default() -> Self {
        Self { line: Vec3::splat(0.05), color: Vec3::splat(0.7), width: LineWidth::Relative(0.1) }
    }
}

impl Material for Wireframe {
    fn shade(&self, context: &Context<'_>, hits: &mut SubPacket<'_>, lit: Lit<'_>) {
        let light: &mut Columns3 = &mut lend(context.width);
        scatter(context, lit, light);
        let [distance, inscribed]: [&mut Column<f32>; 2] = [&mut lend(context.width), &mut lend(context.width)];
        let [line, color] = [self.line, self.color].map(|color| Vec3::from(color.to_array().map(unit)));
        let count = hits.len();
        if hits.edges([&mut distance[..count], &mut inscribed[..count]]) {
            for i in 0..count {
                let half = self.width.half(hits, i, inscribed[i]);
                let color = if distance[i] < half { line } else { color };
                let scattered = vec3(light, i) * color;
                set_vec3(light, i, scattered);
            }
            diffuse(hits, Vec3::ONE, Maps::NONE, light);
        } else {
            diffuse(hits, color, Maps::NONE, light);
        }
        hits.set_colors(light);
    }

    fn base_color(&self) -> Vec3 {
        self.color
    }

    fn scaled(&self, scale: f32) -> Option<Arc<dyn Material>> {
        let LineWidth::Units(width) = self.width else { return None };
        Some(Arc::new(Self { width: LineWidth::Units(width * scale), ..*self }))
    }

    fn describe(&self) -> String {
        let ([Vec3 { x, y, z }, b], width) = ([self.line, self.color], self.width);
        let width = match width {
            LineWidth::Units(width) => format!("{width} wide"),
            LineWidth::Relative(part) => format!("{part} of triangles wide"),
            LineWidth::Pixels(width) => format!("{width} pixels wide"),
        };
        format!("lines ({x:.2}, {y:.2}, {z:.2}), {width}, on ({:.2}, {:.2}, {:.2})", b.x, b.y, b.z)
    }
}
