//! A checker board: two colours in cubes of space, or in squares of texture coordinates.

use std::sync::Arc;

use glam::Vec3;

use super::lambertian::{diffuse, scatter};
use super::principled::unit;
use crate::packet::{Columns3, SubPacket, set_vec3, vec3};
use crate::scratch::lend;
use crate::stack::{Context, Lit, Material};
use crate::texture::Maps;

/// What the squares of a [`Checker`] are squares of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Pattern {
    /// Positions: cubes of space.
    #[default]
    Position,
    /// Texture coordinates. Geometry without any has one colour.
    Texture,
}

impl std::str::FromStr for Pattern {
    type Err = crate::choice::UnknownName;
    fn from_str(name: &str) -> Result<Self, Self::Err> {
        match name {
            "position" => Ok(Self::Position),
            "texture" => Ok(Self::Texture),
            _ => Err(Self::Err { kind: "pattern", name: name.to_owned(), known: "position, texture".to_owned() }),
        }
    }
}

/// Two colours by turns, scattered as [`Lambertian`](super::Lambertian) does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Checker {
    /// Fractions of the light that are scattered, linear RGB from 0 to 1; the square from 0 to [`size`](Self::size) has the first.
    pub colors: [Vec3; 2],
    /// Side of a square, in units of the scene or of texture coordinates.
    pub size: f32,
    /// What it is measured in.
    pub by: Pattern,
}

impl Default for Checker {
    /// Light and dark squares of 1.
    fn default() -> Self {
        Self { colors: [Vec3::splat(0.8), Vec3::splat(0.2)], size: 1.0, by: Pattern::Position }
    }
}

/// So far below the surface it is looked for its colour, in sides of squares: surfaces in the plane between two squares have one.
const BELOW: f32 = 1.0 / 1024.0;

impl Checker {
    /// Sets the first rows of `out` to the colours of the squares.
    fn paint(&self, hits: &mut SubPacket<'_>, out: &mut Columns3) {
        let per_size = 1.0 / if self.size > 0.0 { self.size } else { 1.0 };
        let colors = self.colors.map(|color| Vec3::from(color.to_array().map(unit)));
        hits.forward_normals();
        for i in 0..hits.len() {
            let at = match self.by {
                Pattern::Position => vec3(&hits.positions(), i) * per_size - vec3(&hits.geometric_normals(), i) * BELOW,
                Pattern::Texture => vec3(&hits.texture_coordinates(), i).truncate().extend(0.0) * per_size,
            };
            // Of the sum of three whole numbers it counts whether it is odd.
            let half = at.floor().element_sum() * 0.5;
            set_vec3(out, i, colors[usize::from(half != half.floor())]);
        }
    }
}

impl Material for Checker {
    fn shade(&self, context: &Context<'_>, hits: &mut SubPacket<'_>, lit: Lit<'_>) {
        let [light, color]: [&mut Columns3; 2] = [&mut lend(context.width), &mut lend(context.width)];
        scatter(context, lit, light);
        self.paint(hits, color);
        for i in 0..hits.len() {
            let scattered = vec3(light, i) * vec3(color, i);
            set_vec3(light, i, scattered);
        }
        diffuse(hits, Vec3::ONE, Maps::NONE, light);
        hits.set_colors(light);
    }

    fn base_color(&self) -> Vec3 {
        (self.colors[0] + self.colors[1]) * 0.5
    }

    fn albedo(&self, hits: &mut SubPacket<'_>, out: &mut Columns3) {
        self.paint(hits, out);
        diffuse(hits, Vec3::ONE, Maps::NONE, out);
    }

    fn scaled(&self, scale: f32) -> Option<Arc<dyn Material>> {
        (self.by == Pattern::Position).then(|| Arc::new(Self { size: self.size * scale, ..*self }) as Arc<dyn Material>)
    }

    fn describe(&self) -> String {
        let [Vec3 { x, y, z }, b] = self.colors;
        format!("checker ({x:.2}, {y:.2}, {z:.2}) and ({:.2}, {:.2}, {:.2})", b.x, b.y, b.z)
    }
}
