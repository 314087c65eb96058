//! The fisheye camera: wider than what fits on a plane.

use glam::Vec3;
use mobula_core::Properties;

use crate::packet::{Packet, set_vec3};
use crate::stack::{Camera, Context};
use crate::view::View;

/// An equidistant projection: the angle with the view's direction grows with the distance from the middle of the image, up to half the
/// field of view at its upper and lower edge. The field may be up to 360 degrees; what would be farther than straight behind is that.
#[derive(Clone, Debug)]
pub struct Fisheye {
    eye: Vec3,
    basis: [Vec3; 3],
    /// Radians at half the height of the image.
    angle: f32,
}

impl Fisheye {
    /// Vertical field of view, degrees, where none is given.
    pub const DEFAULT_FOV: f32 = 180.0;

    /// A camera with this point of view.
    pub fn new(view: View) -> Self {
        let fov = if view.fov.is_finite() { view.fov.clamp(1e-3, 360.0) } else { Self::DEFAULT_FOV };
        Self { eye: view.eye, basis: view.basis(), angle: fov.to_radians() * 0.5 }
    }
}

impl Camera for Fisheye {
    fn make_rays(&self, _context: &Context<'_>, size: [u32; 2], packet: &mut Packet) {
        let [width, height] = size.map(|side| side as f32);
        let [right, up, forward] = self.basis;
        let (rays, [x, y]) = packet.rays_and_image();
        rays.set_common_origin(self.eye);
        let directions = &mut rays.directions_mut();
        for i in 0..directions[0].len() {
            let across = (x[i] * (2.0 / width) - 1.0) * (width / height);
            let upward = 1.0 - y[i] * (2.0 / height);
            let radius = (across * across + upward * upward).sqrt();
            let (sine, cosine) = libm::sincosf((radius * self.angle).min(std::f32::consts::PI));
            let side = if radius > 0.0 { (right * across + up * upward) * (sine / radius) } else { Vec3::ZERO };
            set_vec3(directions, i, side + forward * cosine);
        }
        rays.promise(Properties::NORMALIZED_DIRECTIONS);
        packet.cone_spread = 2.0 * self.angle / height;
    }
}
