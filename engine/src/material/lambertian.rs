//! Surfaces that look the same from all directions (Lambert 1760).

use glam::Vec3;
use mobula_core::rays::{set_vec3, vec3};
use mobula_core::{Columns3, SubPacket};

use super::{Points, for_each_color};
use crate::light::shadow;
use crate::scratch::lend;
use crate::stack::{Context, Illumination, Material};

/// Scatters light evenly. Both sides of a surface look the same.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lambertian {
    /// Fraction of the light that is scattered, linear RGB.
    pub diffuse: Vec3,
}

impl<const N: usize> Material<N> for Lambertian {
    fn shade(&self, context: &Context<'_, N>, hits: &mut SubPacket<'_, N>) {
        let points: &mut Points<N> = &mut lend();
        let light: &mut Columns3<N> = &mut lend();
        points.fill(context, hits);
        ambient(context, points, light);
        let arriving: &mut Illumination<N> = &mut lend();
        for source in &context.scene.lights {
            shadow::illuminate(context, &**source, points, arriving);
            for i in points.range() {
                add(light, i, scattered(points, arriving, i));
            }
        }
        for_each_color(context, hits, |i, own| {
            let color = self.diffuse * own * vec3(light, i);
            set_vec3(light, i, color);
        });
        points.range().for_each(|i| hits.set_color(i, vec3(light, i)));
    }

    fn base_color(&self) -> Vec3 {
        self.diffuse
    }
}

/// Sets the rows of `points` to what arrives from everywhere.
pub(super) fn ambient<const N: usize>(context: &Context<'_, N>, points: &Points<N>, light: &mut Columns3<N>) {
    for i in points.range() {
        set_vec3(light, i, context.scene.ambient.at(points.normal(i)));
    }
}

/// What a perfectly white surface at point `i` scatters of what arrives there.
#[inline(always)]
pub(super) fn scattered<const N: usize>(points: &Points<N>, arriving: &Illumination<N>, i: usize) -> Vec3 {
    arriving.radiance(i) * arriving.direction(i).dot(points.normal(i)).max(0.0)
}

#[inline(always)]
pub(super) fn add<const N: usize>(columns: &mut Columns3<N>, i: usize, value: Vec3) {
    let sum = vec3(columns, i) + value;
    set_vec3(columns, i, sum);
}
