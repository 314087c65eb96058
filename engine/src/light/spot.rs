//! A light without extent that shines into a cone.

use glam::Vec3;
use mobula_core::simd::{F32Lanes, Task, Token};

use crate::lanes::{dot, load3, scale, splat3, store3, sub};
use crate::math::normalize_or;
use crate::stack::{Context, Illumination, Light, Receivers};

/// Light from a point into a cone, with a soft rim.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spot {
    /// Where it is.
    pub position: Vec3,
    /// Where it shines, of any length; downwards along y if it has none.
    pub direction: Vec3,
    /// Radiance that arrives in the middle; with falloff, at distance 1. Linear RGB.
    pub color: Vec3,
    /// Up to this angle from the direction it is as bright as in the middle: degrees.
    pub inner: f32,
    /// From this angle on it is dark: degrees, up to 180.
    pub outer: f32,
    /// Does it get weaker with the square of the distance?
    pub falloff: bool,
}

impl Default for Spot {
    /// White, at a height of 4, down into a cone 60 degrees wide, as bright at any distance.
    fn default() -> Self {
        let (position, direction) = (Vec3::Y * 4.0, Vec3::NEG_Y);
        Self { position, direction, color: Vec3::ONE, inner: 20.0, outer: 30.0, falloff: false }
    }
}

impl Light for Spot {
    /// A point at the light itself gets nothing.
    fn illuminate(&self, context: &Context<'_>, points: Receivers<'_>, out: &mut Illumination) {
        context.token.run(Arrive { light: self, points, out });
    }

    fn position(&self, _context: &Context<'_>) -> Option<Vec3> {
        Some(self.position)
    }
}

struct Arrive<'a> {
    light: &'a Spot,
    points: Receivers<'a>,
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
        let direction = normalize_or(light.direction.to_array().map(f64::from), Vec3::NEG_Y);
        let backward = splat3(token, (-direction).to_array());
        // A NaN is no angle.
        let sound = |degrees: f32| if degrees > 0.0 { degrees.min(180.0) } else { 0.0 };
        let cosine = |degrees: f32| libm::cosf(sound(degrees).to_radians());
        let outer = cosine(light.outer);
        let rim = (cosine(light.inner) - outer).max(1e-6);
        let (outer, rim) = (token.splat(outer), token.splat(rim));
        let positions = points.positions();
        for at in (0..points.len()).step_by(T::LANES) {
            let v = sub(position, load3(token, &positions, at));
            let square = dot(v, v);
            let distance = square.sqrt();
            let towards = scale(v, one / distance);
            let usable = square.gt(zero) & square.lt(token.splat(f32::INFINITY));
            // A cubic step between the two cones.
            let step = ((dot(towards, backward) - outer) / rim).max(zero).min(one);
            let step = step * step * (token.splat(3.0) - step - step);
            let weight = if light.falloff { step / square } else { step };
            store3(towards.map(|x| x.select(usable, zero)), &mut out.direction, at);
            store3(scale(color, weight.select(usable, zero)), &mut out.radiance, at);
            distance.store(&mut out.distance, at);
        }
    }
}
