//! A disk that shines.

use std::f32::consts::PI;

use glam::Vec3;
use mobula_core::simd::{Task, Token};

use super::area::{aim, emit};
use crate::lanes::{add, load3, scale, splat3};
use crate::stack::{Context, Illumination, Light, Receivers};
use crate::warp::disk;

/// Light from one side of a disk. It is not seen itself. Points of it are chosen by area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disk {
    /// The middle.
    pub position: Vec3,
    /// Where it shines, of any length; downwards along y if it has none.
    pub direction: Vec3,
    /// The radius.
    pub radius: f32,
    /// Radiance that leaves it, the same in all directions, linear RGB.
    pub color: Vec3,
}

impl Default for Disk {
    /// Of radius 1 at a height of 4, shining down, about as bright below as the usual point light.
    fn default() -> Self {
        Self { position: Vec3::Y * 4.0, direction: Vec3::NEG_Y, radius: 1.0, color: Vec3::splat(16.0) }
    }
}

impl Light for Disk {
    /// Points behind it, in its plane, or at the chosen point get nothing; nor does anything if it has no radius.
    fn illuminate(&self, context: &Context<'_>, points: Receivers<'_>, out: &mut Illumination) {
        let [right, up, forward] = aim(self.direction, Vec3::Y);
        context.token.run(Arrive { light: self, axes: [right, up], forward, points, out });
    }

    fn position(&self, _context: &Context<'_>) -> Option<Vec3> {
        None
    }
}

struct Arrive<'a> {
    light: &'a Disk,
    axes: [Vec3; 2],
    forward: Vec3,
    points: Receivers<'a>,
    out: &'a mut Illumination,
}

impl Task for Arrive<'_> {
    type Output = ();

    #[inline(always)]
    fn run<T: Token>(self, token: T) {
        let Self { light, axes, forward, points, out } = self;
        let radius = light.radius.abs();
        let area = token.splat(PI * radius * radius);
        let middle = splat3(token, light.position.to_array());
        let [right, up] = axes.map(|axis| splat3(token, (axis * radius).to_array()));
        let forward = splat3(token, forward.to_array());
        let color = splat3(token, light.color.to_array());
        let positions = points.positions();
        for at in (0..points.len()).step_by(T::LANES) {
            let [x, y] = disk(token, points.square(token, at));
            let chosen = add(middle, add(scale(right, x), scale(up, y)));
            emit(token, chosen, forward, area, color, load3(token, &positions, at), out, at);
        }
    }
}
