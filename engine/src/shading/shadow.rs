//! Shadow rays: the one place that makes any-hit packets (paper 5.4: secondary rays are new packets).

use glam::Vec3;
use mobula_core::Properties;

use super::Points;
use crate::medium::attenuate;
use crate::packet::{AnyHitPacket, Column, set_vec3, transmittance, vec3};
use crate::pipeline::fault::scope;
use crate::scratch::lend;
use crate::stack::{Context, Illumination, Light};

/// A light is near if it is within so many times the size of the scene: then shadow rays start at it.
const NEAR: f32 = 64.0;

/// What of `light` reaches `points`, through the scene's medium and through surfaces that let light through. Rays whose surface faces away, or that something is in the way of, get no radiance;
/// so in the rows of others `out.radiance` may be used without a further test.
///
/// The rays of points that face the light are packed densely, in order, so that they stay as coherent as they were. From a
/// near point light they start at the light, which makes their origin common; else at the points. Directions are of unit
/// length in both cases. Shading points are offset from their surface (see [`Points::offset`]), so the whole interval up
/// to the point, or to the light, is tested.
///
/// Each primitive that lets light through and is in the way counts once: a sphere too, though light goes through its surface twice. A
/// ray that goes exactly through the common edge of two triangles meets both.
pub fn illuminate(context: &Context<'_>, light: &dyn Light, points: &Points, out: &mut Illumination) {
    scope("light", || light.illuminate(points.positions(), out));
    scope("medium", || attenuate(context, points.positions(), out));
    let facing: &mut Column<u16> = &mut lend(context.width);
    let mut count = 0;
    for i in 0..points.len() {
        let direction = vec3(&out.direction, i);
        if direction.dot(points.normal(i)) > 0.0 && direction.dot(points.geometric_normal(i)) > 0.0 {
            facing[count] = i as u16;
            count += 1;
        } else {
            set_vec3(&mut out.radiance, i, Vec3::ZERO);
        }
    }
    if !context.scene.shadows || count == 0 {
        return;
    }

    let facing = &facing[..count];
    let packet: &mut AnyHitPacket = &mut lend(context.width);
    packet.reset(count);
    let rays = packet.rays_mut();
    match light.position().filter(|&position| is_near(context, position)) {
        Some(position) => {
            rays.set_common_origin(position);
            let distances: &mut Column<f32> = &mut lend(context.width);
            let directions = &mut rays.directions_mut();
            for (k, &i) in facing.iter().enumerate() {
                let i = usize::from(i);
                let v = points.offset(i, 1.0, out.distance[i]) - position;
                distances[k] = v.length();
                set_vec3(directions, k, v * (1.0 / distances[k]));
            }
            rays.t_max_mut().copy_from_slice(&distances[..count]);
        }
        None => {
            let origins = &mut rays.origins_mut();
            facing.iter().enumerate().for_each(|(k, &i)| set_vec3(origins, k, points.offset(i.into(), 1.0, 0.0)));
            let directions = &mut rays.directions_mut();
            facing.iter().enumerate().for_each(|(k, &i)| set_vec3(directions, k, vec3(&out.direction, i.into())));
            rays.t_max_mut().iter_mut().zip(facing).for_each(|(t_max, &i)| *t_max = out.distance[usize::from(i)]);
        }
    }
    // Coordinates near the end of what a float can hold give directions that are not.
    let directions = rays.directions();
    if (0..count).all(|k| (vec3(&directions, k).length_squared() - 1.0).abs() < 1e-5) {
        rays.promise(Properties::NORMALIZED_DIRECTIONS);
    }

    let statistics = context.statistics;
    statistics.shadow.set(statistics.shadow.get() + count as u64);
    context.scene.occlude(context, packet);
    for ((&i, &t_max), &depth) in facing.iter().zip(packet.rays().t_max()).zip(packet.depths()) {
        let i = usize::from(i);
        if t_max == f32::NEG_INFINITY {
            set_vec3(&mut out.radiance, i, Vec3::ZERO);
        } else if depth > 0 {
            let radiance = vec3(&out.radiance, i) * transmittance(depth);
            set_vec3(&mut out.radiance, i, radiance);
        }
    }
}

/// From a light that is much further away than most of the scene is large, rays could not be aimed well enough, and boxes would be
/// widened by more than they are large. Depends on light and scene only, so that all packets do the same.
fn is_near(context: &Context<'_>, position: Vec3) -> bool {
    let (low, high) = context.scene.bulk;
    let size = (high - low).max_element();
    (position - low).abs().max((position - high).abs()).max_element() <= NEAR * size
}
