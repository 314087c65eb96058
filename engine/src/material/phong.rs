//! Highlights, mirrors and thin glass (Phong, "Illumination for Computer Generated Pictures", 1975; Schlick, "An
//! Inexpensive BRDF Model for Physically-based Rendering", 1994, for how mirroring grows towards grazing angles).

use glam::Vec3;
use mobula_core::rays::{set_vec3, vec3};
use mobula_core::{Column, Columns3, SubPacket};

use super::lambertian::{add, ambient, scattered};
use super::{Points, for_each_color, secondary};
use crate::light::shadow;
use crate::math::{normalize, pow};
use crate::scene::PhongDescription;
use crate::scratch::lend;
use crate::stack::{Context, Illumination, Material};

/// Scatters, shines, mirrors, and lets through. Of all light that is not mirrored, a fraction comes from behind, unbent
/// (thin glass), and the rest from the surface itself.
#[derive(Clone, Debug, PartialEq)]
pub struct Phong {
    diffuse: Vec3,
    specular: Vec3,
    shininess: f32,
    /// Mirrored fraction seen head on; 0 for none at any angle.
    reflection: f32,
    transparency: f32,
}

/// Transparent surfaces mirror only so many reflections and refractions deep: two rays a hit would double at each.
const DEEPEST_GLASS_MIRROR: u32 = 1;

impl Phong {
    /// The material of a description. Numbers out of range are clamped to it; NaN counts as 0.
    pub fn new(description: &PhongDescription) -> Self {
        let clamp = |x: f32, most: f32| if x > 0.0 { x.min(most) } else { 0.0 };
        let clamp3 = |v: Vec3| Vec3::from(v.to_array().map(|x| clamp(x, f32::MAX)));
        let transparency = clamp(description.transparency, 1.0);
        let mut reflection = clamp(description.reflection, 1.0);
        if transparency > 0.0 {
            let n = if description.refractive_index > 0.0 { description.refractive_index } else { 1.0 };
            let r = (n - 1.0) / (n + 1.0);
            reflection = reflection.max(r * r);
        }
        Self {
            diffuse: clamp3(description.diffuse),
            specular: clamp3(description.specular),
            shininess: clamp(description.shininess, 10_000.0),
            reflection,
            transparency,
        }
    }
}

impl<const N: usize> Material<N> for Phong {
    fn shade(&self, context: &Context<'_, N>, hits: &mut SubPacket<'_, N>) {
        let points: &mut Points<N> = &mut lend();
        let light: &mut Columns3<N> = &mut lend();
        points.fill(context, hits);
        ambient(context, points, light);
        let shine: &mut Columns3<N> = &mut lend();
        points.range().for_each(|i| set_vec3(shine, i, Vec3::ZERO));
        let arriving: &mut Illumination<N> = &mut lend();
        for source in &context.scene.lights {
            shadow::illuminate(context, &**source, points, arriving);
            for i in points.range() {
                let radiance = arriving.radiance(i);
                if radiance != Vec3::ZERO {
                    add(light, i, scattered(points, arriving, i));
                    let (mirrored, _) = self.mirror(hits, points, i);
                    let towards = mirrored.dot(arriving.direction(i));
                    if towards > 0.0 && self.specular != Vec3::ZERO {
                        add(shine, i, self.specular * radiance * pow(towards, self.shininess));
                    }
                }
            }
        }
        // `light` becomes the colour: first of the surface itself.
        for_each_color(context, hits, |i, own| {
            let color = self.diffuse * own * vec3(light, i);
            set_vec3(light, i, color);
        });
        if self.reflection > 0.0 || self.transparency > 0.0 {
            self.blend_secondary(context, hits, points, light);
        }
        points.range().for_each(|i| hits.set_color(i, vec3(light, i) + vec3(shine, i)));
    }

    fn base_color(&self) -> Vec3 {
        self.diffuse
    }
}

impl Phong {
    /// The mirrored unit direction at row `i`, and the cosine of the angle of incidence.
    #[inline(always)]
    fn mirror<const N: usize>(&self, hits: &SubPacket<'_, N>, points: &Points<N>, i: usize) -> (Vec3, f32) {
        let (_, direction) = hits.ray(i);
        let direction = normalize(direction);
        let normal = points.normal(i);
        let cosine = -direction.dot(normal);
        (direction + normal * (2.0 * cosine), cosine.clamp(0.0, 1.0))
    }

    /// Adds what is mirrored and what shines through to `color`, the colour of the surface itself.
    fn blend_secondary<const N: usize>(
        &self,
        context: &Context<'_, N>,
        hits: &SubPacket<'_, N>,
        points: &Points<N>,
        color: &mut Columns3<N>,
    ) {
        let mirrors = self.reflection > 0.0 && (self.transparency == 0.0 || hits.depth <= DEEPEST_GLASS_MIRROR);
        let mirrored: &mut Column<f32, N> = &mut lend();
        let behind: &mut Column<f32, N> = &mut lend();
        for i in points.range() {
            mirrored[i] = 0.0;
            if mirrors {
                let (_, cosine) = self.mirror(hits, points, i);
                let x = 1.0 - cosine;
                mirrored[i] = self.reflection + (1.0 - self.reflection) * (x * x * x * x * x);
            }
            behind[i] = (1.0 - mirrored[i]) * self.transparency;
            let own = (1.0 - mirrored[i]) * (1.0 - self.transparency);
            let kept = vec3(color, i) * own;
            set_vec3(color, i, kept);
        }
        if mirrors {
            secondary::trace(context, hits, mirrored, color, |i| {
                let (direction, _) = self.mirror(hits, points, i);
                // A shading normal may mirror into the surface: then along it instead.
                let geometric = points.geometric_normal(i);
                let inwards = direction.dot(geometric).min(0.0);
                (points.offset(i, 1.0, 0.0), normalize(direction - geometric * inwards))
            });
        }
        if self.transparency > 0.0 {
            secondary::trace(context, hits, behind, color, |i| {
                let (_, direction) = hits.ray(i);
                (points.offset(i, -1.0, 0.0), normalize(direction))
            });
        }
    }
}
