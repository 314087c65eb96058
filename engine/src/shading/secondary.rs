//! Rays that go on from a hit: gathered into new packets, traced, and blended in (paper 5.4).

use glam::Vec3;
use mobula_core::Properties;

use crate::packet::{Column, Columns3, Packet, SubPacket, add_vec3, set_vec3, vec3};
use crate::scratch::lend;
use crate::stack::Context;

/// Rays below this weight are not worth tracing: they change no byte of a picture by more than one.
pub(super) const LEAST_WEIGHT: f32 = 1.0 / 512.0;

/// Traces one ray for each row of `hits` whose `weight` is worth it, from `origin(i)` along the unit vector `direction(i)`, and
/// adds the weighted colours to `out`.
///
/// The new packet is packed densely. It has no common origin, and is as coherent as the surface is smooth.
pub fn trace(
    context: &Context<'_>,
    hits: &SubPacket<'_>,
    weight: &[f32],
    out: &mut Columns3,
    origin: impl Fn(usize) -> Vec3,
    direction: impl Fn(usize) -> Vec3,
) {
    trace_weighted(context, hits, |i| Vec3::splat(weight[i]), out, origin, direction);
}

/// As [`trace`], with a weight for each colour: of rays that surfaces tint.
pub fn trace_weighted(
    context: &Context<'_>,
    hits: &SubPacket<'_>,
    weight: impl Fn(usize) -> Vec3,
    out: &mut Columns3,
    origin: impl Fn(usize) -> Vec3,
    direction: impl Fn(usize) -> Vec3,
) {
    let rows: &mut Column<u16> = &mut lend(hits.width());
    let mut count = 0;
    for i in 0..hits.len() {
        if weight(i).max_element() >= LEAST_WEIGHT {
            rows[count] = i as u16;
            count += 1;
        }
    }
    if count == 0 {
        return;
    }
    let rows = &rows[..count];
    let packet: &mut Packet = &mut lend(hits.width());
    packet.reset(count);
    packet.depth = hits.depth() + 1;
    packet.channel = hits.channel();
    let origins = &mut packet.rays_mut().origins_mut();
    rows.iter().enumerate().for_each(|(k, &i)| set_vec3(origins, k, origin(usize::from(i))));
    let directions = &mut packet.rays_mut().directions_mut();
    rows.iter().enumerate().for_each(|(k, &i)| set_vec3(directions, k, direction(usize::from(i))));
    for (to, from) in packet.image.iter_mut().zip(hits.image()) {
        to.iter_mut().zip(rows).for_each(|(to, &i)| *to = from[usize::from(i)]);
    }
    for (to, from) in packet.samples.iter_mut().zip(hits.samples()) {
        to.iter_mut().zip(rows).for_each(|(to, &i)| *to = from[usize::from(i)]);
    }
    (packet.cone_spread, packet.cone_part) = (hits.cone_spread(), hits.cone_part());
    rows.iter().enumerate().for_each(|(k, &i)| packet.cone_widths[k] = hits.cone_width(usize::from(i)));
    packet.rays_mut().promise(Properties::NORMALIZED_DIRECTIONS);
    context.renderer.trace(context, packet);
    for (k, &i) in rows.iter().enumerate() {
        let i = usize::from(i);
        add_vec3(out, i, vec3(&packet.color, k) * weight(i));
    }
}
