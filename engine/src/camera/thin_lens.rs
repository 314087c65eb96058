//! A camera with a lens: what is nearer or farther than its focus is blurred.

use glam::Vec3;
use mobula_core::Properties;

use crate::math::normalize;
use crate::packet::{Column, Packet, set_vec3};
use crate::scratch::lend;
use crate::sequence::{Set, Shape, points};
use crate::stack::{Camera, Context};
use crate::view::{Lens, View};

/// Rays start on a disk around the eye and meet, those of each image coordinates, in the plane of focus, which is perpendicular to the view
/// (Cook, Porter and Carpenter, "Distributed Ray Tracing", 1984). There the image is that of a pinhole camera. Where on the lens a ray
/// starts is chosen for each sample: several samples a pixel make it a blur.
#[derive(Clone, Debug)]
pub struct ThinLens {
    view: View,
    basis: [Vec3; 3],
    slope: f32,
    /// Radius of the lens.
    radius: f32,
    /// Distance of the plane of focus.
    focus: f32,
}

/// The radius of lenses of which none is given, as a part of the distance of focus.
const USUAL: f32 = 1.0 / 40.0;

/// Squares of greater lengths are no numbers.
const MOST: f32 = 1e15;

impl ThinLens {
    /// A camera with this point of view. Numbers that are not finite or below 0 count as not given.
    pub fn new(view: View, lens: Lens) -> Self {
        let given = |x: Option<f32>| x.filter(|x| x.is_finite() && *x >= 0.0).map(|x| x.min(MOST));
        let focus = given(lens.focus).filter(|&focus| focus > 0.0).unwrap_or(view.distance());
        let focus = if focus > 0.0 { focus.min(MOST) } else { 1.0 };
        let radius = given(lens.aperture).unwrap_or(focus * USUAL);
        Self { basis: view.basis(), slope: view.slope(), view, radius, focus }
    }
}

impl Camera for ThinLens {
    fn make_rays(&self, context: &Context<'_>, size: [u32; 2], packet: &mut Packet) {
        let count = packet.len();
        let [x, y]: [&mut Column<f32>; 2] = [&mut lend(context.width), &mut lend(context.width)];
        let [seeds, numbers] = &packet.samples;
        let samples = [&seeds[..count], &numbers[..count]];
        points(context.token, samples, Set::LENS, Shape::Disk, [&mut x[..count], &mut y[..count]]);
        let [width, height] = size.map(|side| side as f32);
        let [right, up, forward] = self.basis;
        let (rays, image) = packet.rays_and_image();
        for i in 0..count {
            let across = (image[0][i] * (2.0 / width) - 1.0) * (self.slope * (width / height));
            let down = (1.0 - image[1][i] * (2.0 / height)) * self.slope;
            let start = (right * x[i] + up * y[i]) * self.radius;
            // Both relative to the eye, however far it is from the origin.
            let end = (forward + right * across + up * down) * self.focus;
            set_vec3(&mut rays.origins_mut(), i, self.view.eye + start);
            set_vec3(&mut rays.directions_mut(), i, normalize(end - start));
        }
        rays.promise(Properties::NORMALIZED_DIRECTIONS);
        packet.cone_spread = 2.0 * self.slope / height;
    }

    fn eye(&self) -> Option<Vec3> {
        Some(self.view.eye)
    }
}
