//! Shadow rays: the one place that makes any-hit packets (paper 5.4: secondary rays are new packets on the stack).

use glam::Vec3;
use mobula_core::{AnyHitPacket, Properties};

use crate::material::Points;
use crate::pipeline::fault::scope;
use crate::scratch::lend;
use crate::stack::{Context, Illumination, Light};

/// A light is near if it is within so many times the size of the scene: then shadow rays start at it.
const NEAR: f32 = 64.0;

/// What of `light` reaches `points`. Rays whose surface faces away, or that something is in the way of, get no radiance;
/// so in the rows of others `out.radiance` may be used without a further test.
///
/// The rays of points that face the light are packed densely, in order, so that they stay as coherent as they were. From a
/// near point light they start at the light, which makes their origin common; else at the points. Directions are of unit
/// length in both cases. Shading points are offset from their surface (see [`Points::offset`]), so the whole interval up
/// to the point, or to the light, is tested.
pub fn illuminate<const N: usize>(
    context: &Context<'_, N>,
    light: &dyn Light<N>,
    points: &Points<N>,
    out: &mut Illumination<N>,
) {
    scope("light", || light.illuminate(&points.position, points.range(), out));
    let mut facing = [0_u16; N];
    let mut count = 0;
    for i in points.range() {
        let direction = out.direction(i);
        if direction.dot(points.normal(i)) > 0.0 && direction.dot(points.geometric_normal(i)) > 0.0 {
            facing[count] = i as u16;
            count += 1;
        } else {
            out.set_radiance(i, Vec3::ZERO);
        }
    }
    if !context.scene.shadows || count == 0 {
        return;
    }

    let facing = &facing[..count];
    let packet: &mut AnyHitPacket<N> = &mut lend();
    packet.reset(0..count);
    match light.position().filter(|&position| is_near(context, position)) {
        Some(position) => {
            for (k, &i) in facing.iter().enumerate() {
                let i = usize::from(i);
                let v = points.offset(i, 1.0, out.distance[i]) - position;
                let distance = v.length();
                packet.set_ray(k, position, v * (1.0 / distance));
                packet.set_interval(k, 0.0, distance);
            }
            packet.set_common_origin(position);
        }
        None => {
            for (k, &i) in facing.iter().enumerate() {
                let i = usize::from(i);
                packet.set_ray(k, points.offset(i, 1.0, 0.0), out.direction(i));
                packet.set_interval(k, 0.0, out.distance[i]);
            }
        }
    }
    // Coordinates near the end of what a float can hold give directions that are not.
    if (0..count).all(|k| (packet.ray(k).1.length_squared() - 1.0).abs() < 1e-5) {
        packet.promise(Properties::NORMALIZED_DIRECTIONS);
    }

    let statistics = context.statistics;
    statistics.shadow.set(statistics.shadow.get() + count as u64);
    context.scene.occlude(context, packet);
    for (k, &i) in facing.iter().enumerate() {
        if packet.occluded(k) {
            out.set_radiance(usize::from(i), Vec3::ZERO);
        }
    }
}

/// From a light that is much further away than the scene is large, rays could not be aimed well enough. Depends on light
/// and scene only, so that all packets do the same.
fn is_near<const N: usize>(context: &Context<'_, N>, position: Vec3) -> bool {
    let (low, high) = context.scene.geometry().bounds();
    let size = (high - low).max_element();
    (position - low).abs().max((position - high).abs()).max_element() <= NEAR * size
}
