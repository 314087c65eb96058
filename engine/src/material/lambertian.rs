//! Surfaces that look the same from all directions (Lambert 1760).

use glam::Vec3;

use crate::packet::{Columns3, SubPacket, add_vec3, part_mut, set_vec3, vec3};
use crate::scratch::lend;
use crate::shading::{Points, illuminate};
use crate::stack::{Context, Illumination, Material};

/// Scatters light evenly. Both sides of a surface look the same.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lambertian {
    /// Fraction of the light that is scattered, linear RGB (MTL `Kd`).
    pub diffuse: Vec3,
}

impl Default for Lambertian {
    /// A light grey.
    fn default() -> Self {
        Self { diffuse: Vec3::splat(0.7) }
    }
}

impl Material for Lambertian {
    fn shade(&self, context: &Context<'_>, hits: &mut SubPacket<'_>) {
        let points: &mut Points = &mut lend(context.width);
        let light: &mut Columns3 = &mut lend(context.width);
        points.fill(hits);
        ambient(context, points, light);
        let arriving: &mut Illumination = &mut lend(context.width);
        for source in &context.scene.lights {
            illuminate(context, &**source, points, arriving);
            for i in 0..points.len() {
                add_vec3(light, i, scattered(points, arriving, i));
            }
        }
        diffuse(hits, self.diffuse, light);
        hits.set_colors(light);
    }

    fn base_color(&self) -> Vec3 {
        self.diffuse
    }

    fn describe(&self) -> String {
        format!("matt ({:.2}, {:.2}, {:.2})", self.diffuse.x, self.diffuse.y, self.diffuse.z)
    }
}

/// Sets the rows of `points` to what arrives from everywhere.
pub(super) fn ambient(context: &Context<'_>, points: &Points, light: &mut Columns3) {
    let scene = context.scene;
    scene.ambient.illuminate(scene.up.vector(), points.normals(), part_mut(light, 0..points.len()));
}

/// What a perfectly white surface at point `i` scatters of what arrives there.
#[inline(always)]
pub(super) fn scattered(points: &Points, arriving: &Illumination, i: usize) -> Vec3 {
    vec3(&arriving.radiance, i) * vec3(&arriving.direction, i).dot(points.normal(i)).max(0.0)
}

/// Turns the light at the hits into what a surface of this colour, times the geometry's own, scatters of it.
pub(super) fn diffuse(hits: &mut SubPacket<'_>, color: Vec3, light: &mut Columns3) {
    let count = hits.len();
    match hits.own_colors() {
        Some(own) => (0..count).for_each(|i| {
            let scattered = color * vec3(&own, i) * vec3(light, i);
            set_vec3(light, i, scattered);
        }),
        None => {
            for (light, color) in light.iter_mut().zip(color.to_array()) {
                light[..count].iter_mut().for_each(|light| *light *= color);
            }
        }
    }
}
