//! The pinhole camera: all rays start at the eye.

use glam::Vec3;
use mobula_core::Properties;
use mobula_core::simd::{F32Lanes, Task, Token};

use crate::packet::{Packet, Rays};
use crate::stack::{Camera, Context};
use crate::view::View;

/// All rays start at the eye; the ray of image coordinates (x, y) has direction `norm(f + sx r + sy u)`, where
/// `sx = (2x/width - 1) tan(fov/2) width/height` and `sy = (1 - 2y/height) tan(fov/2)`.
#[derive(Clone, Debug)]
pub struct Pinhole {
    view: View,
    basis: [Vec3; 3],
    slope: f32,
}

impl Pinhole {
    /// A camera with this point of view.
    pub fn new(view: View) -> Self {
        Self { basis: view.basis(), slope: view.slope(), view }
    }

    /// Its point of view.
    pub fn view(&self) -> &View {
        &self.view
    }
}

impl Camera for Pinhole {
    fn make_rays(&self, context: &Context<'_>, size: [u32; 2], packet: &mut Packet) {
        let (rays, image) = packet.rays_and_image();
        rays.set_common_origin(self.view.eye);
        context.token.run(Directions { camera: self, size, image, rays });
        rays.promise(Properties::NORMALIZED_DIRECTIONS);
        packet.cone_spread = 2.0 * self.slope / size[1] as f32;
    }

    fn eye(&self) -> Option<Vec3> {
        Some(self.view.eye)
    }
}

/// Fills the directions, a vector at a time. Nothing is fused, so that all levels agree.
struct Directions<'a> {
    camera: &'a Pinhole,
    size: [u32; 2],
    image: [&'a [f32]; 2],
    rays: &'a mut dyn Rays,
}

impl Task for Directions<'_> {
    type Output = ();
    #[inline(always)]
    fn run<T: Token>(self, token: T) {
        let Self { camera, size, image, rays } = self;
        let [width, height] = size.map(|side| side as f32);
        let slope = camera.slope;
        let [right, up, forward] = camera.basis;
        let across = token.splat(slope * (width / height));
        let down = token.splat(slope);
        let (per_x, per_y) = (token.splat(2.0 / width), token.splat(2.0 / height));
        let one = token.splat(1.0);
        let mut out = rays.directions_mut();
        for at in (0..out[0].len()).step_by(T::LANES) {
            let sx = (token.load(image[0], at) * per_x - one) * across;
            let sy = (one - token.load(image[1], at) * per_y) * down;
            let axis = |i: usize| token.splat(forward[i]) + sx * token.splat(right[i]) + sy * token.splat(up[i]);
            let d = [axis(0), axis(1), axis(2)];
            let scale = one / (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
            for (column, d) in out.iter_mut().zip(d) {
                (d * scale).store(column, at);
            }
        }
    }
}
