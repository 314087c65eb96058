//! Rays that go on from a hit: gathered into new packets on the stack, traced, and blended in (paper 5.4).

use glam::Vec3;
use mobula_core::rays::vec3;
use mobula_core::{Column, Columns3, Properties, RayPacket, SubPacket};

use super::lambertian::add;
use crate::scratch::lend;
use crate::stack::Context;

/// Rays below this weight are not worth tracing: they change no byte of a picture by more than one.
const LEAST_WEIGHT: f32 = 1.0 / 512.0;

/// Traces one ray for each row of `hits` whose `weight` is worth it, from `ray(i)` (origin and unit direction), and
/// adds the weighted colours to `out`.
///
/// The new packet is packed densely. It has no common origin, and is as coherent as the surface is smooth.
#[inline(never)]
pub(super) fn trace<const N: usize>(
    context: &Context<'_, N>,
    hits: &SubPacket<'_, N>,
    weight: &Column<f32, N>,
    out: &mut Columns3<N>,
    ray: impl Fn(usize) -> (Vec3, Vec3),
) {
    let mut rows = [0_u16; N];
    let mut count = 0;
    for i in hits.range().filter(|&i| weight[i] >= LEAST_WEIGHT) {
        rows[count] = i as u16;
        count += 1;
    }
    if count == 0 {
        return;
    }
    let packet: &mut RayPacket<N> = &mut lend();
    packet.reset(0..count);
    packet.depth = hits.depth + 1;
    packet.channel = hits.channel;
    for (k, &i) in rows[..count].iter().enumerate() {
        let (origin, direction) = ray(usize::from(i));
        packet.set_ray(k, origin, direction);
        packet.image[0][k] = hits.image[0][usize::from(i)];
        packet.image[1][k] = hits.image[1][usize::from(i)];
    }
    packet.promise(Properties::NORMALIZED_DIRECTIONS);
    context.renderer.trace(context, packet);
    for (k, &i) in rows[..count].iter().enumerate() {
        let i = usize::from(i);
        add(out, i, vec3(&packet.color, k) * weight[i]);
    }
}
