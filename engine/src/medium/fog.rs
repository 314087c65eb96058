//! Fog: the same everywhere.

use glam::Vec3;

use crate::math::exp_minus;
use crate::packet::vec3;
use crate::stack::{Context, Medium, Segments};

/// A homogeneous medium that fills all space (the law of Bouguer, Lambert and Beer): over a distance of d it lets `exp(-density d)` of
/// the light through, and shines with what is missing of its colour. Light from infinitely far away does not get through it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fog {
    /// What an endless depth of it looks like, linear RGB.
    pub color: Vec3,
    /// Part of the light that is lost in a unit of length, for short lengths. 0, less, and NaN mean none.
    pub density: f32,
}

impl Fog {
    /// Pale grey fog.
    pub fn new(density: f32) -> Self {
        Self { color: Vec3::new(0.62, 0.66, 0.70), density }
    }
}

impl Medium for Fog {
    fn march(&self, _: &Context<'_>, segments: &Segments<'_>, radiance: [&mut [f32]; 3], transmittance: &mut [f32]) {
        self.lets_through(segments, transmittance);
        self.shines(transmittance, radiance);
    }

    fn transmittance(&self, _: &Context<'_>, segments: &Segments<'_>, out: &mut [f32]) {
        self.lets_through(segments, out);
    }
}

impl Fog {
    fn shines(&self, transmittance: &[f32], radiance: [&mut [f32]; 3]) {
        for (radiance, color) in radiance.into_iter().zip(self.color.to_array()) {
            radiance.iter_mut().zip(transmittance).for_each(|(radiance, through)| *radiance = color * (1.0 - through));
        }
    }

    fn lets_through(&self, segments: &Segments<'_>, out: &mut [f32]) {
        for (i, out) in out.iter_mut().enumerate() {
            let direction = vec3(&segments.directions, i);
            let length = (segments.t1[i] - segments.t0[i]) * direction.dot(direction).sqrt();
            *out = exp_minus(self.density * length);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_is_lost_with_the_length_of_the_way() {
        let segments = Segments {
            origins: [&[0.0; 4]; 3],
            directions: [&[1.0, 2.0, 0.0, 1.0], &[0.0; 4], &[0.0, 0.0, 1.0, 0.0]],
            t0: &[0.0, 1.0, 0.0, 0.0],
            t1: &[2.0, 2.0, f32::INFINITY, 0.0],
        };
        let (mut radiance, mut through) = ([[9.0; 4]; 3], [9.0; 4]);
        let fog = Fog { color: Vec3::new(1.0, 0.5, 0.0), density: 0.5 };
        let [r, g, b] = &mut radiance;
        fog.lets_through(&segments, &mut through);
        fog.shines(&through, [r, g, b]);
        let half = (-1.0_f32).exp();
        for (got, expected) in through.into_iter().zip([half, half, 0.0, 1.0]) {
            assert!((got - expected).abs() < 1e-6, "{got} for {expected}");
        }
        for (i, through) in through.into_iter().enumerate() {
            assert_eq!([radiance[0][i], radiance[1][i], radiance[2][i]], [1.0, 0.5, 0.0].map(|c| c * (1.0 - through)));
        }
        for density in [0.0, -1.0, f32::NAN] {
            Fog { density, ..fog }.lets_through(&segments, &mut through);
            assert_eq!(through, [1.0; 4]);
        }
    }
}
