//! What rough surfaces mirror, of lights, of the scene and of what comes from everywhere; hit by hit.

use glam::Vec3;

use super::albedo::albedo;
use super::microfacet::{LEAST_COSINE, reflected, schlick, tangents, unhidden, visible_normal};
use crate::math::normalize;
use crate::packet::{Column, Columns3, SubPacket, add_vec3, columns3, set_vec3, vec3};
use crate::scratch::{ForWidth, lend};
use crate::sequence::{Set, Shape, points};
use crate::shading::trace_weighted;
use crate::stack::{Context, Lit};

/// What surfaces mirror at hits: one row a hit.
pub(super) struct Gloss {
    /// Reflectance, linear RGB: along the normal, and what is added towards grazing angles, by [`schlick`]. With what light gets from
    /// facet to facet.
    reflectance: [Columns3; 2],
    /// 0 to 1.
    roughness: Column<f32>,
}

impl ForWidth for Gloss {
    fn for_width(width: usize) -> Self {
        Self { reflectance: [columns3(width), columns3(width)], roughness: Column::new(width) }
    }
}

/// Point lights, which have no size, are seen in mirrors as if they had one: at least this rough.
const SHARPEST: f32 = 0.08;
/// What is rougher than the first reflects the light that comes from everywhere, in place of what is around; from the second on,
/// nothing else.
const BLURRED: [f32; 2] = [0.6, 0.9];

impl Gloss {
    /// Describes hit `i`, that is seen at an angle with `cosine`: several layers, each with a part of the surface and with what it reflects
    /// along the normal. Returns the part of all light that each reflects.
    #[inline(always)]
    pub(super) fn set<const N: usize>(
        &mut self,
        i: usize,
        cosine: f32,
        roughness: f32,
        layers: [(f32, Vec3); N],
    ) -> [Vec3; N] {
        let [all, grazing] = albedo(cosine, roughness);
        let lost = 1.0 / all - 1.0;
        let [mut head_on, mut more] = [Vec3::ZERO; 2];
        let parts = layers.map(|(part, color)| {
            // What is lost between facets that reflect `color` comes back with as much of it.
            let again = Vec3::ONE + color * lost;
            head_on += color * again * part;
            more += (Vec3::ONE - color) * again * part;
            (color * all + (Vec3::ONE - color) * grazing) * again
        });
        set_vec3(&mut self.reflectance[0], i, head_on);
        set_vec3(&mut self.reflectance[1], i, more);
        self.roughness[i] = roughness;
        parts
    }

    /// The reflectance of row `i` of facets at an angle with this cosine.
    #[inline(always)]
    fn reflectance(&self, i: usize, cosine: f32) -> Vec3 {
        vec3(&self.reflectance[0], i) + vec3(&self.reflectance[1], i) * schlick(cosine)
    }

    /// Adds what is mirrored of lights.
    pub(super) fn add_lights(&self, hits: &SubPacket<'_>, lit: Lit<'_>, out: &mut Columns3) {
        let directions = &hits.directions();
        for arriving in lit.lights() {
            for i in 0..lit.len() {
                let radiance = vec3(&arriving.radiance, i);
                if radiance == Vec3::ZERO {
                    continue;
                }
                let roughness = self.roughness[i].max(SHARPEST);
                let view = -normalize(vec3(directions, i));
                let light = vec3(&arriving.direction, i);
                let (weight, cosine) = reflected(lit.normal(i), view, light, roughness * roughness);
                add_vec3(out, i, self.reflectance(i, cosine) * radiance * weight);
            }
        }
    }

    /// Adds what is mirrored of the scene and its background: one ray for each hit. Of surfaces that are very rough the light that comes from
    /// everywhere stands for it.
    pub(super) fn add_surroundings(
        &self,
        context: &Context<'_>,
        hits: &SubPacket<'_>,
        lit: Lit<'_>,
        out: &mut Columns3,
    ) {
        let (weights, mirrored): (&mut Columns3, &mut Columns3) = (&mut lend(context.width), &mut lend(context.width));
        let [x, y]: [&mut Column<f32>; 2] = [&mut lend(context.width), &mut lend(context.width)];
        let count = lit.len();
        let set = Set::scattering(hits.depth());
        points(context.token, hits.samples(), set, Shape::Disk, [&mut x[..count], &mut y[..count]]);
        let (directions, ambient) = (&hits.directions(), lit.ambient());
        for i in 0..count {
            let (normal, roughness) = (lit.normal(i), self.roughness[i]);
            let view = -normalize(vec3(directions, i));
            let [start, end] = BLURRED;
            let sharp = ((end - roughness) * (1.0 / (end - start))).clamp(0.0, 1.0);
            let mut weight = Vec3::ZERO;
            if sharp < 1.0 {
                let [all, grazing] = albedo(normal.dot(view), roughness);
                let part = vec3(&self.reflectance[0], i) * all + vec3(&self.reflectance[1], i) * grazing;
                add_vec3(out, i, part * vec3(&ambient, i) * (1.0 - sharp));
            }
            if sharp > 0.0 {
                let ([a, b], alpha) = (tangents(normal), roughness * roughness);
                let local = Vec3::new(view.dot(a), view.dot(b), view.dot(normal).max(LEAST_COSINE));
                let facet = visible_normal(local, alpha, [x[i], y[i]]);
                let cosine = local.dot(facet);
                let towards = facet * (2.0 * cosine) - local;
                if towards.z > 0.0 {
                    let direction = a * towards.x + b * towards.y + normal * towards.z;
                    set_vec3(mirrored, i, outward(direction, lit.geometric_normal(i)));
                    weight = self.reflectance(i, cosine) * (unhidden(local.z, towards.z.min(1.0), alpha) * sharp);
                }
            }
            set_vec3(weights, i, weight);
        }
        let origin = |i| lit.offset(i, 1.0);
        trace_weighted(context, hits, |i| vec3(weights, i), out, origin, |i| vec3(mirrored, i));
    }
}

/// A unit vector on the side of a unit normal: shading normals may mirror into a surface that is not as round as they say; then along it.
#[inline(always)]
pub(super) fn outward(direction: Vec3, geometric: Vec3) -> Vec3 {
    let inwards = direction.dot(geometric).min(0.0);
    normalize(direction - geometric * inwards)
}
