//! A light at the eye.

use glam::Vec3;

use super::Point;
use crate::stack::{Context, Illumination, Light, Receivers};

/// Light from where the camera is, wherever that goes: what is seen is lit, and shadows are hidden behind what throws them. With several
/// viewpoints each has its own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Head {
    /// Radiance that arrives, at any distance, linear RGB.
    pub color: Vec3,
}

impl Default for Head {
    /// As bright as the usual light.
    fn default() -> Self {
        Self { color: Point::KEY.color }
    }
}

impl Light for Head {
    /// Nothing arrives from a camera that has no place.
    fn illuminate(&self, context: &Context<'_>, points: Receivers<'_>, out: &mut Illumination) {
        let color = if context.eye.is_some() { self.color } else { Vec3::ZERO };
        let position = context.eye.unwrap_or_default();
        Point { position, color, falloff: false }.illuminate(context, points, out);
    }

    fn position(&self, context: &Context<'_>) -> Option<Vec3> {
        context.eye
    }
}
