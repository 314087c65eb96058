//! Surfaces that look the same from all directions (Lambert 1760).

use glam::Vec3;
use mobula_core::simd::{F32Lanes, Task, Token};

use crate::lanes::{add, dot, load3, scale, store3};
use crate::lighting::Arriving;
use crate::packet::{Columns3, SubPacket, part_mut, set_vec3, vec3};
use crate::scratch::lend;
use crate::stack::{Context, Lit, Material};

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
    fn shade(&self, context: &Context<'_>, hits: &mut SubPacket<'_>, lit: Lit<'_>) {
        let light: &mut Columns3 = &mut lend(context.width);
        scatter(context, lit, light);
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

/// Sets the first rows of `out` to what a perfectly white surface scatters of all that arrives.
pub(super) fn scatter(context: &Context<'_>, lit: Lit<'_>, out: &mut Columns3) {
    let mut out = part_mut(out, 0..lit.len());
    out.iter_mut().zip(lit.ambient()).for_each(|(out, ambient)| out.copy_from_slice(ambient));
    for arriving in lit.lights() {
        context.token.run(Scatter { normals: lit.normals(), arriving, out: &mut out });
    }
}

struct Scatter<'a, 'b> {
    normals: [&'a [f32]; 3],
    arriving: Arriving<'a>,
    out: &'a mut [&'b mut [f32]; 3],
}

impl Task for Scatter<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<T: Token>(self, token: T) {
        let Self { normals, arriving, out } = self;
        for at in (0..normals[0].len()).step_by(T::LANES) {
            let cosine = dot(load3(token, &arriving.direction, at), load3(token, &normals, at)).max(token.splat(0.0));
            let scattered = scale(load3(token, &arriving.radiance, at), cosine);
            store3(add(load3(token, out, at), scattered), out, at);
        }
    }
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
