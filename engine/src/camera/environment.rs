//! All around: the whole sphere of directions as a map.

use glam::Vec3;
use mobula_core::Properties;

use crate::math::normalize_or;
use crate::packet::{Packet, set_vec3};
use crate::stack::{Camera, Context};
use crate::view::View;

/// An equirectangular picture: across it goes once around the up axis, with what the eye looks at in the middle; from top to bottom it goes
/// from straight up to straight down. Pictures twice as wide as high have square pixels at the horizon. The field of view does not count.
#[derive(Clone, Debug)]
pub struct Environment {
    eye: Vec3,
    /// Right, up and forward; up is the axis of the map, and forward is level.
    basis: [Vec3; 3],
}

impl Environment {
    /// A camera with this point of view.
    pub fn new(view: View) -> Self {
        let up = normalize_or(view.up.to_array().map(f64::from), Vec3::Y);
        // Where the eye looks along the axis, as much of the picture is ahead as a pinhole camera has above.
        let level = View { up, ..view }.basis();
        let [right, ..] = level;
        Self { eye: view.eye, basis: [right, up, up.cross(right)] }
    }
}

impl Camera for Environment {
    fn make_rays(&self, _context: &Context<'_>, size: [u32; 2], packet: &mut Packet) {
        let [per_x, per_y] = size.map(|side| 1.0 / side as f32);
        let [right, up, forward] = self.basis;
        let (rays, [x, y]) = packet.rays_and_image();
        rays.set_common_origin(self.eye);
        let directions = &mut rays.directions_mut();
        for i in 0..directions[0].len() {
            let (sine, cosine) = libm::sincosf((x[i] * per_x - 0.5) * std::f32::consts::TAU);
            // From the top: beyond the poles it goes down again on the other side, where filters look.
            let (level, upward) = libm::sincosf(y[i] * per_y * std::f32::consts::PI);
            set_vec3(directions, i, (right * sine + forward * cosine) * level + up * upward);
        }
        rays.promise(Properties::NORMALIZED_DIRECTIONS);
        packet.cone_spread = per_y * std::f32::consts::PI;
    }
}
