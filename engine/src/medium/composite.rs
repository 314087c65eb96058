//! Media between the eye and surfaces, and between surfaces and lights.

use super::several::{march, transmittance};
use crate::packet::{Column, Columns3, Packet, part, part_mut};
use crate::scratch::lend;
use crate::stack::{Context, Illumination, Segments};

/// Puts the scene's media before what the rays of a packet see: from where they start to what they hit, or to the ends of their
/// intervals. Rays that go on from surfaces, as reflected ones, have stretches of their own.
pub fn composite(context: &Context<'_>, packet: &mut Packet) {
    let media = &context.scene.media;
    if media.is_empty() {
        return;
    }
    let count = packet.len();
    let radiance: &mut Columns3 = &mut lend(context.width);
    let through: &mut Column<f32> = &mut lend(context.width);
    let rays = packet.rays();
    let (origins, directions, t0, t1) = (rays.origins(), rays.directions(), rays.t_min(), rays.t_max());
    let segments = Segments { origins, directions, t0, t1 };
    march(media, context, &segments, part_mut(radiance, 0..count), &mut through[..count]);
    for (color, radiance) in packet.color.iter_mut().zip(radiance) {
        let rows = color[..count].iter_mut().zip(radiance.iter()).zip(through.iter());
        rows.for_each(|((color, radiance), through)| *color = radiance + through * *color);
    }
    if packet.through().is_some() {
        packet.through_mut().iter_mut().zip(through.iter()).for_each(|(behind, through)| *behind *= through);
    }
}

/// Weakens what arrives at points by the scene's media.
pub fn attenuate(context: &Context<'_>, points: [&[f32]; 3], arriving: &mut Illumination) {
    let media = &context.scene.media;
    if media.is_empty() {
        return;
    }
    let count = points[0].len();
    let through: &mut Column<f32> = &mut lend(context.width);
    let t0: &mut Column<f32> = &mut lend(context.width);
    t0[..count].fill(0.0);
    let segments = Segments {
        origins: points,
        directions: part(&arriving.direction, 0..count),
        t0: &t0[..count],
        t1: &arriving.distance[..count],
    };
    transmittance(media, context, &segments, &mut through[..count]);
    for radiance in &mut arriving.radiance {
        radiance[..count].iter_mut().zip(through.iter()).for_each(|(radiance, through)| *radiance *= through);
    }
}
