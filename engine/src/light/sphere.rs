//! A sphere that shines.

use glam::Vec3;
use mobula_core::simd::{F32Lanes, Task, Token};

use crate::lanes::{dot, load3, scale, splat3, store3, sub};
use crate::stack::{Context, Illumination, Light, Receivers};
use crate::warp::{above, cap};

/// Light from a sphere: a bulb, a moon. It is not seen itself. Directions to it are chosen evenly from the cone that it fills (Shirley, Wang
/// and Zimmerman, "Monte Carlo Techniques for Direct Lighting Calculations", 1996, section 3.2).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// The middle.
    pub position: Vec3,
    /// The radius.
    pub radius: f32,
    /// Radiance that leaves it, the same in all directions, linear RGB.
    pub color: Vec3,
}

impl Default for Sphere {
    /// Of radius 1 at a height of 4, about as bright below as the usual point light.
    fn default() -> Self {
        Self { position: Vec3::Y * 4.0, radius: 1.0, color: Vec3::splat(16.0) }
    }
}

impl Light for Sphere {
    /// Points inside of it, or on it, get nothing; nor does anything if it has no radius.
    fn illuminate(&self, context: &Context<'_>, points: Receivers<'_>, out: &mut Illumination) {
        context.token.run(Arrive { light: self, points, out });
    }

    fn position(&self, _context: &Context<'_>) -> Option<Vec3> {
        None
    }
}

struct Arrive<'a> {
    light: &'a Sphere,
    points: Receivers<'a>,
    out: &'a mut Illumination,
}

impl Task for Arrive<'_> {
    type Output = ();

    #[inline(always)]
    fn run<T: Token>(self, token: T) {
        let Self { light, points, out } = self;
        let (zero, one, two) = (token.splat(0.0), token.splat(1.0), token.splat(2.0));
        let middle = splat3(token, light.position.to_array());
        let radius_square = token.splat(light.radius * light.radius);
        let color = splat3(token, light.color.to_array());
        let positions = points.positions();
        for at in (0..points.len()).step_by(T::LANES) {
            let v = sub(middle, load3(token, &positions, at));
            let square = dot(v, v);
            let distance = square.sqrt();
            // Of the angle between the middle and the rim: the square of the sine, and 1 less the cosine.
            let sine_square = radius_square / square;
            let height = sine_square / (one + (one - sine_square).max(zero).sqrt());
            let usable = sine_square.gt(zero) & sine_square.lt(one) & square.lt(token.splat(f32::INFINITY));
            let axis = scale(v, one / distance);
            let about = cap(token, points.square(token, at), height);
            let direction = above(token, axis, about);
            // Where the ray meets the sphere first.
            let along = distance * about[2];
            let across = about[0] * about[0] + about[1] * about[1];
            let near = along - (radius_square - square * across).max(zero).sqrt();
            store3(direction.map(|x| x.select(usable, zero)), &mut out.direction, at);
            // The cone's solid angle over pi.
            store3(scale(color, (two * height).select(usable, zero)), &mut out.radiance, at);
            near.max(zero).store(&mut out.distance, at);
        }
    }
}
