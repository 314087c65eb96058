//! A light without extent.

use glam::Vec3;
use mobula_core::simd::{F32Lanes, Task, Token};

use crate::lanes::{dot, load3, scale, splat3, store3, sub};
use crate::stack::{Context, Illumination, Light, Receivers};

/// Light from a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Where it is.
    pub position: Vec3,
    /// Radiance that arrives; with falloff, at distance 1. Linear RGB.
    pub color: Vec3,
    /// Does it get weaker with the square of the distance?
    pub falloff: bool,
}

impl Point {
    /// The light of scenes that have none, at the origin: a little warm, as bright everywhere.
    pub const KEY: Self = Self { position: Vec3::ZERO, color: Vec3::new(0.95, 0.90, 0.82), falloff: false };
}

impl Default for Point {
    /// White, at the origin, as bright everywhere.
    fn default() -> Self {
        Self { position: Vec3::ZERO, color: Vec3::ONE, falloff: false }
    }
}

impl Light for Point {
    /// A point at the light itself gets nothing.
    fn illuminate(&self, context: &Context<'_>, points: Receivers<'_>, out: &mut Illumination) {
        context.token.run(Arrive { light: self, points: points.positions(), out });
    }

    fn position(&self, _context: &Context<'_>) -> Option<Vec3> {
        Some(self.position)
    }
}

struct Arrive<'a> {
    light: &'a Point,
    points: [&'a [f32]; 3],
    out: &'a mut Illumination,
}

impl Task for Arrive<'_> {
    type Output = ();

    #[inline(always)]
    fn run<T: Token>(self, token: T) {
        let Self { light, points, out } = self;
        let (zero, one) = (token.splat(0.0), token.splat(1.0));
        let position = splat3(token, light.position.to_array());
        let color = splat3(token, light.color.to_array());
        for at in (0..points[0].len()).step_by(T::LANES) {
            let v = sub(position, load3(token, &points, at));
            let square = dot(v, v);
            let distance = square.sqrt();
            let usable = square.gt(zero) & square.lt(token.splat(f32::INFINITY));
            store3(scale(v, (one / distance).select(usable, zero)), &mut out.direction, at);
            let weight = if light.falloff { one / square } else { one };
            store3(scale(color, weight.select(usable, zero)), &mut out.radiance, at);
            distance.store(&mut out.distance, at);
        }
    }
}
