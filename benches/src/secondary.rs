//! Secondary rays: from what the primary rays hit, a little above the surface on the viewer's side, in the same order.

use crate::rays::{Found, Kind, NOTHING, RaySet, cross, dot, normalize, sub};
use crate::scenes::{Primitives, View};

/// The rays of a kind for every primary ray that hit something; the primary rays themselves for [`Kind::Primary`].
pub fn rays(kind: Kind, view: &View, primitives: &Primitives, primary: &RaySet, hits: &Found) -> RaySet {
    if kind == Kind::Primary {
        return primary.clone();
    }
    let mut rays = RaySet { common_origin: kind == Kind::ShadowFromLight, ..RaySet::default() };
    let sun = normalize(view.sun);
    for i in 0..primary.len() {
        let primitive = hits.primitive[i];
        if primitive == NOTHING {
            continue;
        }
        let (origin, direction) = primary.ray(i);
        let point = [0, 1, 2].map(|k| origin[k] + hits.t[i] * direction[k]);
        let mut normal = normalize(primitives.normal(primitive as usize, point));
        if dot(normal, direction) > 0.0 {
            normal = normal.map(|x| -x);
        }
        let start = [0, 1, 2].map(|k| point[k] + view.offset * normal[k]);
        match kind {
            Kind::Primary => {}
            Kind::ShadowPoint => {
                let to_light = sub(view.light, start);
                rays.push(start, normalize(to_light), 0.9999 * dot(to_light, to_light).sqrt());
            }
            // To where the rays towards the light start: that is above the surface.
            Kind::ShadowFromLight => {
                let to_surface = sub(start, view.light);
                rays.push(view.light, normalize(to_surface), dot(to_surface, to_surface).sqrt());
            }
            Kind::ShadowDirectional => rays.push(start, sun, f32::INFINITY),
            Kind::Occlusion => rays.push(start, cosine(normal, i), view.reach),
            Kind::Diffuse => rays.push(start, cosine(normal, i), f32::INFINITY),
        }
    }
    rays
}

/// A direction around `normal`, distributed by the cosine, from two random numbers of the ray's index.
fn cosine(normal: [f32; 3], index: usize) -> [f32; 3] {
    cosine_weighted(normal, [unit(2 * index as u32), unit(2 * index as u32 + 1)])
}

/// A direction around `normal`, distributed by the cosine, for a point of the unit square.
pub fn cosine_weighted(normal: [f32; 3], [u, v]: [f32; 2]) -> [f32; 3] {
    let (sin, cos) = (std::f32::consts::TAU * u).sin_cos();
    let radius = v.sqrt();
    let other = if normal[0].abs() < 0.5 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
    let tangent = normalize(cross(normal, other));
    let bitangent = cross(normal, tangent);
    let height = (1.0 - v).max(0.0).sqrt();
    normalize([0, 1, 2].map(|k| radius * (cos * tangent[k] + sin * bitangent[k]) + height * normal[k]))
}

/// A number in `[0, 1)` from an integer (the output function of PCG RXS-M-XS 32).
pub fn unit(index: u32) -> f32 {
    let state = index.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (((word >> 22) ^ word) >> 8) as f32 * (1.0 / 16_777_216.0)
}
