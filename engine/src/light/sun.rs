//! A disk that is infinitely far away.

use glam::Vec3;
use mobula_core::simd::{F32Lanes, Task, Token};

use crate::lanes::{splat3, store3};
use crate::math::normalize_or;
use crate::stack::{Context, Illumination, Light, Receivers};
use crate::warp::{above, cap};

/// The sun: nearly parallel light, whose shadows are the softer the farther away what throws them is. Directions are chosen evenly from its
/// disk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sun {
    /// Towards its middle, of any length; from above along y if it has none.
    pub direction: Vec3,
    /// Radiance that arrives, as that of a [directional](super::Directional) light, however large the disk is; linear RGB.
    pub color: Vec3,
    /// How large it is seen: its diameter in degrees, 0 to 180.
    pub angle: f32,
}

impl Sun {
    /// The diameter of the sun, seen from the earth, in degrees.
    pub const ANGLE: f32 = 0.53;
}

impl Default for Sun {
    /// White, from the upper left.
    fn default() -> Self {
        Self { direction: Vec3::new(-0.4, 1.0, 0.6), color: Vec3::splat(0.9), angle: Self::ANGLE }
    }
}

impl Light for Sun {
    fn illuminate(&self, context: &Context<'_>, points: Receivers<'_>, out: &mut Illumination) {
        context.token.run(Arrive { light: self, points, out });
    }

    fn position(&self, _context: &Context<'_>) -> Option<Vec3> {
        None
    }
}

struct Arrive<'a> {
    light: &'a Sun,
    points: Receivers<'a>,
    out: &'a mut Illumination,
}

impl Task for Arrive<'_> {
    type Output = ();

    #[inline(always)]
    fn run<T: Token>(self, token: T) {
        let Self { light, points, out } = self;
        let axis = normalize_or(light.direction.to_array().map(f64::from), Vec3::Y);
        let axis = splat3(token, axis.to_array());
        let angle = if light.angle > 0.0 { light.angle.min(180.0) } else { 0.0 };
        let half_sine = libm::sinf(angle.to_radians() * 0.25);
        let height = token.splat(2.0 * half_sine * half_sine);
        let color = splat3(token, light.color.to_array());
        for at in (0..points.len()).step_by(T::LANES) {
            let about = cap(token, points.square(token, at), height);
            store3(above(token, axis, about), &mut out.direction, at);
            store3(color, &mut out.radiance, at);
            token.splat(f32::INFINITY).store(&mut out.distance, at);
        }
    }
}
