//! A rectangle that shines.

use glam::Vec3;
use mobula_core::simd::{Task, Token};

use super::area::{aim, emit};
use crate::lanes::{add, load3, scale, splat3};
use crate::stack::{Context, Illumination, Light, Receivers};

/// Light from one side of a rectangle: a window, a lamp of a studio. It is not seen itself. Points of it are chosen by area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rectangle {
    /// The middle.
    pub position: Vec3,
    /// Where it shines, of any length; downwards along y if it has none.
    pub direction: Vec3,
    /// Its height goes along this, as far as it is across the direction; anywhere, if it is not.
    pub up: Vec3,
    /// Width and height.
    pub size: [f32; 2],
    /// Radiance that leaves it, the same in all directions, linear RGB.
    pub color: Vec3,
}

impl Default for Rectangle {
    /// A square of side 2 at a height of 4 that shines down, about as bright below as the usual point light.
    fn default() -> Self {
        let (position, direction) = (Vec3::Y * 4.0, Vec3::NEG_Y);
        Self { position, direction, up: Vec3::Z, size: [2.0; 2], color: Vec3::splat(12.0) }
    }
}

impl Light for Rectangle {
    /// Points behind it, in its plane, or at the chosen point get nothing; nor does anything if it has no area.
    fn illuminate(&self, context: &Context<'_>, points: Receivers<'_>, out: &mut Illumination) {
        let [right, up, forward] = aim(self.direction, self.up);
        let [width, height] = self.size.map(f32::abs);
        let edges = [right * width, up * height];
        context.token.run(Arrive { light: self, edges, forward, area: width * height, points, out });
    }

    fn position(&self, _context: &Context<'_>) -> Option<Vec3> {
        None
    }
}

struct Arrive<'a> {
    light: &'a Rectangle,
    edges: [Vec3; 2],
    forward: Vec3,
    area: f32,
    points: Receivers<'a>,
    out: &'a mut Illumination,
}

impl Task for Arrive<'_> {
    type Output = ();

    #[inline(always)]
    fn run<T: Token>(self, token: T) {
        let Self { light, edges, forward, area, points, out } = self;
        let half = token.splat(0.5);
        let middle = splat3(token, light.position.to_array());
        let [right, up] = edges.map(|edge| splat3(token, edge.to_array()));
        let forward = splat3(token, forward.to_array());
        let color = splat3(token, light.color.to_array());
        let positions = points.positions();
        for at in (0..points.len()).step_by(T::LANES) {
            let [u, v] = points.square(token, at);
            let chosen = add(middle, add(scale(right, u - half), scale(up, v - half)));
            emit(token, chosen, forward, token.splat(area), color, load3(token, &positions, at), out, at);
        }
    }
}
