//! Surfaces that look the same from all directions (Lambert 1760).

use glam::Vec3;
use mobula_core::simd::{F32Lanes, Task, Token};

use crate::lanes::{add, dot, load3, scale, store3};
use crate::lighting::Arriving;
use crate::packet::{Columns3, SubPacket, part_mut, set_vec3, vec3};
use crate::scratch::lend;
use crate::stack::{Context, Lit, Material};
use crate::texture::Maps;

/// Scatters light evenly. Both sides of a surface look the same.
#[derive(Clone, Debug, PartialEq)]
pub struct Lambertian {
    /// Fraction of the light that is scattered, linear RGB (MTL `Kd`).
    pub diffuse: Vec3,
    /// Its textures.
    pub maps: Maps,
}

impl Lambertian {
    /// Without textures.
    pub fn new(diffuse: Vec3) -> Self {
        Self { diffuse, maps: Maps::default() }
    }
}

impl Default for Lambertian {
    /// A light grey.
    fn default() -> Self {
        Self::new(Vec3::splat(0.7))
    }
}

impl Material for Lambertian {
    fn shade(&self, context: &Context<'_>, hits: &mut SubPacket<'_>, lit: Lit<'_>) {
        let light: &mut Columns3 = &mut lend(context.width);
        scatter(context, lit, light);
        diffuse(hits, self.diffuse, &self.maps, light);
        hits.set_colors(light);
    }

    fn maps(&self) -> &Maps {
        &self.maps
    }

    fn base_color(&self) -> Vec3 {
        self.diffuse
    }

    fn describe(&self) -> String {
        let Vec3 { x, y, z } = self.diffuse;
        format!("matt ({x:.2}, {y:.2}, {z:.2}){}", self.maps.describe())
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

/// Turns the light at the hits into what a surface of this colour, times those of its texture and of the geometry, scatters of it.
pub(super) fn diffuse(hits: &mut SubPacket<'_>, color: Vec3, maps: &Maps, light: &mut Columns3) {
    let count = hits.len();
    if let Some(map) = &maps.color {
        hits.sample(map, |i, texel| {
            let scattered = texel.truncate() * vec3(light, i);
            set_vec3(light, i, scattered);
        });
    }
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
