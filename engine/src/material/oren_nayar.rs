//! Rough diffuse surfaces, such as clay, plaster and the moon: flatter than Lambert's, and as bright as they where they are white.

use std::f32::consts::PI;

use glam::Vec3;

use super::principled::unit;
use crate::math::normalize;
use crate::packet::{Columns3, SubPacket, add_vec3, set_vec3, vec3};
use crate::scratch::lend;
use crate::stack::{Context, Lit, Material};

/// The model of Oren and Nayar ("Generalization of Lambert's Reflectance Model", 1994) in the form of Fujii, with the light that goes from
/// facet to facet: EON, of Portsmouth, Kutz and Hill ("EON: A Practical Energy-Preserving Rough Diffuse BRDF", JCGT 2025).
/// Both sides of a surface look the same.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrenNayar {
    /// Fraction of the light that is scattered by each facet, linear RGB from 0 to 1.
    pub color: Vec3,
    /// From 0, as `lambertian`, to 1.
    pub roughness: f32,
}

impl Default for OrenNayar {
    /// Clay.
    fn default() -> Self {
        Self { color: Vec3::new(0.7, 0.55, 0.45), roughness: 0.7 }
    }
}

/// `1/2 - 2 / (3 pi)`.
const FLAT: f32 = 0.5 - 2.0 / (3.0 * PI);
/// `2/3 - 28 / (15 pi)`.
const MEAN: f32 = 2.0 / 3.0 - 28.0 / (15.0 * PI);
/// `G / pi` of the paper as a polynomial in one minus the cosine, from the first power on.
const GRAZING: [f32; 4] = [0.057_108_53, 0.491_881_87, -0.332_181_44, 0.071_443];

/// A surface of some roughness.
#[derive(Clone, Copy)]
struct Facets {
    roughness: f32,
    /// What facets scatter that lie flat.
    flat: f32,
    /// One minus what all facets scatter of light from everywhere, by one of them.
    lost: f32,
}

impl Facets {
    fn new(roughness: f32) -> Self {
        let flat = 1.0 / (1.0 + FLAT * roughness);
        Self { roughness, flat, lost: 1.0 - flat * (1.0 + MEAN * roughness) }
    }

    /// What white facets scatter, by one of them, of all light that comes at an angle with this cosine.
    #[inline(always)]
    fn albedo(self, cosine: f32) -> f32 {
        let x = 1.0 - cosine;
        let [a, b, c, d] = GRAZING;
        self.flat * (1.0 + self.roughness * (x * (a + x * (b + x * (c + x * d)))))
    }

    /// `pi` times how white facets scatter light from one direction to another: by one of them, and by several.
    #[inline(always)]
    fn scattered(self, normal: Vec3, view: Vec3, light: Vec3) -> [f32; 2] {
        let (to_view, to_light) = (normal.dot(view), normal.dot(light));
        let s = view.dot(light) - to_view * to_light;
        let s = if s > 0.0 { s / to_view.max(to_light) } else { s };
        let several = (1.0 - self.albedo(to_view)) * (1.0 - self.albedo(to_light)) / self.lost.max(1e-7);
        [self.flat * (1.0 + self.roughness * s), several]
    }

    /// What is left of a colour after several facets, over all light that gets to them.
    fn again(self, color: f32) -> f32 {
        color * color * (1.0 - self.lost) / (1.0 - color * self.lost)
    }
}

impl Material for OrenNayar {
    fn shade(&self, context: &Context<'_>, hits: &mut SubPacket<'_>, lit: Lit<'_>) {
        let facets = Facets::new(unit(self.roughness));
        let [once, more]: [&mut Columns3; 2] = [&mut lend(context.width), &mut lend(context.width)];
        let directions = &hits.directions();
        let view = |i| -normalize(vec3(directions, i));
        for i in 0..lit.len() {
            let by_one = facets.albedo(view(i).dot(lit.normal(i)).clamp(0.0, 1.0));
            let ambient = vec3(&lit.ambient(), i);
            set_vec3(once, i, ambient * by_one);
            set_vec3(more, i, ambient * (1.0 - by_one));
        }
        for arriving in lit.lights() {
            for i in 0..lit.len() {
                let (radiance, light) = (vec3(&arriving.radiance, i), vec3(&arriving.direction, i));
                let normal = lit.normal(i);
                if radiance != Vec3::ZERO && normal.dot(light) > 0.0 {
                    let [by_one, by_several] = facets.scattered(normal, view(i), light);
                    let radiance = radiance * normal.dot(light);
                    add_vec3(once, i, radiance * by_one);
                    add_vec3(more, i, radiance * by_several);
                }
            }
        }
        let color = Vec3::from(self.color.to_array().map(unit));
        for i in 0..lit.len() {
            let color = hits.own_colors().map_or(color, |own| color * vec3(&own, i));
            let again = Vec3::from(color.to_array().map(|channel| facets.again(channel)));
            let scattered = color * vec3(once, i) + again * vec3(more, i);
            set_vec3(once, i, scattered);
        }
        hits.set_colors(once);
    }

    fn base_color(&self) -> Vec3 {
        self.color
    }

    fn describe(&self) -> String {
        let Vec3 { x, y, z } = self.color;
        format!("rough matt ({x:.2}, {y:.2}, {z:.2}), roughness {:.2}", self.roughness)
    }
}
