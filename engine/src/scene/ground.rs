//! A ground under a scene, which is no part of it: views, lights and counts go by what stands on it.

use std::f32::consts::TAU;
use std::sync::Arc;

use glam::Vec3;

use crate::geometry::{Geometry, Mesh};
use crate::material::{Lambertian, Material};
use crate::packet::{Columns3, SubPacket, part_mut, set_vec3, vec3};
use crate::scratch::lend;
use crate::stack::{Context, Lit};
use crate::view::Up;

/// A level ground. It ends far away, where it has become the background.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ground {
    /// A point that it goes through; `None`: it is just below the scene.
    pub at: Option<Vec3>,
    /// The fraction of light that it scatters, linear RGB.
    pub color: Vec3,
}

impl Default for Ground {
    /// Just below the scene, grey.
    fn default() -> Self {
        Self { at: None, color: Vec3::splat(0.4) }
    }
}

/// The ground is so many times as large as the scene: far enough that its end is less than two degrees below the horizon of an eye that looks at
/// the scene, near enough that the numbers stay good.
const REACH: f32 = 32.0;
/// From this part of the way to its end on, it becomes the background.
const FADES: f32 = 0.08;
/// It is below the scene by this part of its size, so that what is level at the bottom does not lie in it.
const BELOW: f32 = 1.0 / 4096.0;
/// The corners of its rim.
const CORNERS: u32 = 64;

impl Ground {
    /// What rays hit, and what it looks like, under a scene with these bounds. `material` is the index that this will have.
    pub(super) fn build(
        &self,
        (low, high): (Vec3, Vec3),
        up: Up,
        material: u32,
    ) -> Option<(Arc<dyn Geometry>, Arc<dyn Material>)> {
        let size = (high * 0.5 - low * 0.5).length() * 2.0;
        let there = size.is_finite() && low.cmple(high).all();
        let (low, high, size) = if there { (low, high, size) } else { (Vec3::ZERO, Vec3::ZERO, 1.0) };
        let up = up.vector();
        let size = if size > 0.0 { size } else { low.abs().max_element().max(1.0) };
        let height = self.at.map_or(low.dot(up) - size * BELOW, |at| at.dot(up));
        let middle = low * 0.5 + high * 0.5;
        let middle = middle + up * (height - middle.dot(up));
        let radius = size * REACH;
        // Counter-clockwise, seen from above.
        let (right, forward) = if up == Vec3::Y { (Vec3::X, Vec3::NEG_Z) } else { (Vec3::X, Vec3::Y) };
        let corner = |i: u32| {
            let angle = TAU * i as f32 / CORNERS as f32;
            middle + (right * libm::cosf(angle) + forward * libm::sinf(angle)) * radius
        };
        let positions: Vec<[f32; 3]> =
            [middle].into_iter().chain((0..CORNERS).map(corner)).map(|corner| corner.to_array()).collect();
        if !positions.iter().flatten().all(|x| x.is_finite()) {
            return None;
        }
        let triangles = (0..CORNERS).map(|i| [0, 1 + i, 1 + (i + 1) % CORNERS]).collect();
        let mesh = Mesh { name: "ground".to_owned(), positions, triangles, material, ..Mesh::default() };
        let surface = Surface { color: self.color, middle, radius: radius * libm::cosf(TAU * 0.5 / CORNERS as f32) };
        Some((Arc::new(mesh), Arc::new(surface)))
    }
}

/// Matt, and becomes the background with the distance from the middle.
#[derive(Clone, Copy, Debug)]
struct Surface {
    color: Vec3,
    middle: Vec3,
    /// From here on it is the background.
    radius: f32,
}

impl Surface {
    /// How much of a place is background.
    fn faded(&self, position: Vec3) -> f32 {
        let way = (position - self.middle).length() / self.radius;
        let part = ((way - FADES) / (1.0 - FADES)).clamp(0.0, 1.0);
        // Soft at both ends, and early: seen from near the ground, most of it is far away.
        let left = 1.0 - part;
        1.0 - left * left * left
    }
}

impl Material for Surface {
    fn shade(&self, context: &Context<'_>, hits: &mut SubPacket<'_>, lit: Lit<'_>) {
        Lambertian::new(self.color).shade(context, hits, lit);
        let count = hits.len();
        let near: &mut Columns3 = &mut lend(context.width);
        let mut near = part_mut(near, 0..count);
        near.iter_mut().zip(hits.colors_mut()).for_each(|(to, from)| to.copy_from_slice(from));
        context.scene.background.shade(context, hits);
        let positions: &mut Columns3 = &mut lend(context.width);
        let mut positions = part_mut(positions, 0..count);
        positions.iter_mut().zip(hits.positions()).for_each(|(to, from)| to.copy_from_slice(from));
        let mut colors = hits.colors_mut();
        for i in 0..count {
            let (near, far) = (vec3(&near, i), vec3(&colors, i));
            set_vec3(&mut colors, i, near + (far - near) * self.faded(vec3(&positions, i)));
        }
    }

    fn base_color(&self) -> Vec3 {
        self.color
    }

    fn describe(&self) -> String {
        format!("ground ({:.2}, {:.2}, {:.2})", self.color.x, self.color.y, self.color.z)
    }
}
