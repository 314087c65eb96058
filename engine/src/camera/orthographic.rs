//! The orthographic camera: all rays are parallel.

use glam::Vec3;
use mobula_core::Properties;

use crate::packet::{Packet, set_vec3};
use crate::stack::{Camera, Context};
use crate::view::View;

/// All rays go where the eye looks, from a plane through the eye. The image is as high as what a pinhole camera of the same view shows
/// at the distance of the point that is looked at.
#[derive(Clone, Debug)]
pub struct Orthographic {
    view: View,
    basis: [Vec3; 3],
    /// Half the height of the image.
    half: f32,
}

impl Orthographic {
    /// A camera with this point of view.
    pub fn new(view: View) -> Self {
        Self { basis: view.basis(), half: view.slope() * view.distance(), view }
    }
}

impl Camera for Orthographic {
    fn make_rays(&self, _context: &Context<'_>, size: [u32; 2], packet: &mut Packet) {
        let [width, height] = size.map(|side| side as f32);
        let [right, up, forward] = self.basis;
        let (rays, [x, y]) = packet.rays_and_image();
        let origins = &mut rays.origins_mut();
        for i in 0..origins[0].len() {
            let across = (x[i] * (2.0 / width) - 1.0) * (self.half * (width / height));
            let down = (1.0 - y[i] * (2.0 / height)) * self.half;
            set_vec3(origins, i, self.view.eye + right * across + up * down);
        }
        for (column, value) in rays.directions_mut().into_iter().zip(forward.to_array()) {
            column.fill(value);
        }
        rays.promise(Properties::NORMALIZED_DIRECTIONS);
        packet.cone_widths.fill(2.0 * self.half / height);
    }

    fn eye(&self) -> Option<Vec3> {
        Some(self.view.eye)
    }
}
