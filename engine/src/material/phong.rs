//! Highlights, mirrors and thin glass (Phong, "Illumination for Computer Generated Pictures", 1975; Schlick, "An
//! Inexpensive BRDF Model for Physically-based Rendering", 1994, for how mirroring grows towards grazing angles).

use glam::Vec3;

use super::lambertian::{diffuse, scatter};
use crate::math::{normalize, pow};
use crate::packet::{Column, Columns3, SubPacket, add_vec3, set_vec3, vec3};
use crate::scratch::lend;
use crate::shading::trace;
use crate::stack::{Context, Lit, Material};
use crate::texture::{Map, Maps};

/// Scatters, shines, mirrors, and lets through. Of all light that is not mirrored, a fraction comes from behind, unbent
/// (thin glass), and the rest from the surface itself.
/// Colours are linear RGB; numbers out of range count as the nearest that is within, NaN as 0. The names in brackets are those of MTL
/// files.
#[derive(Clone, Debug, PartialEq)]
pub struct Phong {
    /// Fraction of the light that is scattered (`Kd`).
    pub diffuse: Vec3,
    /// Strength of the highlight (`Ks`).
    pub specular: Vec3,
    /// Sharpness of the highlight (`Ns`), 0 to about 1000.
    pub shininess: f32,
    /// Fraction of the light that is mirrored, seen head on; it grows towards grazing angles. 0 for none at any angle. `illum 3` and
    /// above with a high `Ks` means some.
    pub reflection: f32,
    /// Fraction of the light that comes from behind, unbent (`1 - d`, `Tr`).
    pub transparency: f32,
    /// Index of refraction (`Ni`): how fast mirroring grows towards grazing angles where there is transparency.
    pub refractive_index: f32,
    /// Its textures; that of colours counts for `diffuse`.
    pub maps: Maps,
    /// Colours by which `specular` is multiplied (`map_Ks`).
    pub specular_map: Option<Map>,
}

impl Default for Phong {
    fn default() -> Self {
        Self {
            diffuse: Vec3::splat(0.7),
            specular: Vec3::ZERO,
            shininess: 30.0,
            reflection: 0.0,
            transparency: 0.0,
            refractive_index: 1.5,
            maps: Maps::default(),
            specular_map: None,
        }
    }
}

/// Transparent surfaces mirror only so many reflections and refractions deep: two rays a hit would double at each.
const DEEPEST_GLASS_MIRROR: u32 = 1;

impl Phong {
    /// The same without textures, with all numbers in range, and at least the reflection that goes with the index of refraction.
    fn sound(&self) -> Self {
        let clamp = |x: f32, most: f32| if x > 0.0 { x.min(most) } else { 0.0 };
        let clamp3 = |v: Vec3| Vec3::from(v.to_array().map(|x| clamp(x, f32::MAX)));
        let transparency = clamp(self.transparency, 1.0);
        let mut reflection = clamp(self.reflection, 1.0);
        if transparency > 0.0 {
            let n = if self.refractive_index > 0.0 { self.refractive_index } else { 1.0 };
            let r = (n - 1.0) / (n + 1.0);
            reflection = reflection.max(r * r);
        }
        Self {
            diffuse: clamp3(self.diffuse),
            specular: clamp3(self.specular),
            shininess: clamp(self.shininess, 10_000.0),
            reflection,
            transparency,
            refractive_index: self.refractive_index,
            // To share textures takes time, and nobody asks for them here.
            maps: Maps::default(),
            specular_map: None,
        }
    }
}

impl Material for Phong {
    fn shade(&self, context: &Context<'_>, hits: &mut SubPacket<'_>, lit: Lit<'_>) {
        let sound = self.sound();
        let light: &mut Columns3 = &mut lend(context.width);
        scatter(context, lit, light);
        let shine: &mut Columns3 = &mut lend(context.width);
        shine.iter_mut().for_each(|column| column[..lit.len()].fill(0.0));
        let lights = (sound.specular != Vec3::ZERO).then(|| lit.lights());
        for arriving in lights.into_iter().flatten() {
            let directions = &hits.directions();
            for i in 0..lit.len() {
                let radiance = vec3(&arriving.radiance, i);
                if radiance != Vec3::ZERO {
                    let (mirrored, _) = mirror(directions, lit, i);
                    let towards = mirrored.dot(vec3(&arriving.direction, i));
                    if towards > 0.0 {
                        add_vec3(shine, i, sound.specular * radiance * pow(towards, sound.shininess));
                    }
                }
            }
        }
        if let Some(map) = self.specular_map.as_ref().filter(|_| sound.specular != Vec3::ZERO) {
            hits.sample(map, |i, texel| {
                let shown = vec3(shine, i) * texel.truncate();
                set_vec3(shine, i, shown);
            });
        }
        // `light` becomes the colour: first of the surface itself.
        diffuse(hits, sound.diffuse, &self.maps, light);
        if sound.reflection > 0.0 || sound.transparency > 0.0 {
            sound.blend_secondary(context, hits, lit, light);
        }
        for ((out, light), shine) in hits.colors_mut().into_iter().zip(light).zip(shine) {
            for ((out, light), shine) in out.iter_mut().zip(light.iter()).zip(shine.iter()) {
                *out = light + shine;
            }
        }
    }

    fn maps(&self) -> &Maps {
        &self.maps
    }

    fn base_color(&self) -> Vec3 {
        self.sound().diffuse
    }

    /// Mirroring, which grows towards grazing angles, is left aside.
    fn opacity(&self) -> f32 {
        1.0 - self.sound().transparency
    }

    fn describe(&self) -> String {
        let Vec3 { x, y, z } = self.diffuse;
        let mut text = format!("diffuse ({x:.2}, {y:.2}, {z:.2}), highlight {:.0}", self.shininess);
        if self.reflection > 0.0 {
            text.push_str(&format!(", mirrors {:.2}", self.reflection));
        }
        if self.transparency > 0.0 {
            text.push_str(&format!(", lets through {:.2}", self.transparency));
        }
        text.push_str(self.maps.describe());
        text
    }
}

/// The mirrored unit direction at row `i`, and the cosine of the angle of incidence.
#[inline(always)]
fn mirror(directions: &[&[f32]; 3], lit: Lit<'_>, i: usize) -> (Vec3, f32) {
    let direction = normalize(vec3(directions, i));
    let normal = lit.normal(i);
    let cosine = -direction.dot(normal);
    (direction + normal * (2.0 * cosine), cosine.clamp(0.0, 1.0))
}

impl Phong {
    /// Adds what is mirrored and what shines through to `color`, the colour of the surface itself.
    fn blend_secondary(&self, context: &Context<'_>, hits: &SubPacket<'_>, lit: Lit<'_>, color: &mut Columns3) {
        let mirrors = self.reflection > 0.0 && (self.transparency == 0.0 || hits.depth() <= DEEPEST_GLASS_MIRROR);
        let mirrored: &mut Column<f32> = &mut lend(context.width);
        let behind: &mut Column<f32> = &mut lend(context.width);
        let directions = &hits.directions();
        for i in 0..lit.len() {
            mirrored[i] = 0.0;
            if mirrors {
                let (_, cosine) = mirror(directions, lit, i);
                let x = 1.0 - cosine;
                mirrored[i] = self.reflection + (1.0 - self.reflection) * (x * x * x * x * x);
            }
            behind[i] = (1.0 - mirrored[i]) * self.transparency;
            let own = (1.0 - mirrored[i]) * (1.0 - self.transparency);
            let kept = vec3(color, i) * own;
            set_vec3(color, i, kept);
        }
        if mirrors {
            let origin = |i| lit.offset(i, 1.0);
            trace(context, hits, mirrored, color, origin, |i| {
                let (direction, _) = mirror(directions, lit, i);
                // A shading normal may mirror into the surface: then along it instead.
                let geometric = lit.geometric_normal(i);
                let inwards = direction.dot(geometric).min(0.0);
                normalize(direction - geometric * inwards)
            });
        }
        if self.transparency > 0.0 {
            let origin = |i| lit.offset(i, -1.0);
            trace(context, hits, behind, color, origin, |i| normalize(vec3(directions, i)));
        }
    }
}
