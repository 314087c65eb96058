//! The colours of a packet's rays: what lights its hits, and then what each material, or the background, makes of its own rays (paper
//! Figure 6).

use glam::Vec3;

use crate::lighting::{Lighting, Receivers};
use crate::packet::{Column, Packet, SubPacket, part_mut};
use crate::pipeline::fault::scope;
use crate::scratch::lend;
use crate::shading::{illuminate, opacities, openness, tilt_normals};
use crate::stack::{Context, Material};

/// Colours the rays of a packet, run by run: by their materials, or by the background.
pub fn shade(context: &Context<'_>, packet: &mut Packet) {
    let scene = context.scene;
    let lighting: &mut Lighting = &mut lend(context.width);
    light(context, packet, lighting);
    let mut seen = 0;
    for run in 0..packet.runs().len() {
        let Some((geometry, material)) = packet.runs()[run].hit else {
            scope("background", || scene.background.shade(context, &mut packet.sub_packet(run, None)));
            continue;
        };
        let (name, material) = (scene.materials.scope(material), scene.materials.get(material));
        let hits = &mut packet.sub_packet(run, Some(scene.geometry.get(geometry)));
        scope(name, || {
            by_opacity(context, material, hits, |part, opacities| {
                if is_seen(opacities) {
                    let rows = seen..seen + if material.is_lit() { part.len() } else { 0 };
                    seen = rows.end;
                    material.shade(context, part, lighting.lit(rows));
                } else {
                    part.fill_color(Vec3::ZERO);
                }
                opacities.into_iter().for_each(|opacities| part.fade(opacities));
            });
        });
    }
}

/// Finds what reaches all hits that light changes, in their order.
fn light(context: &Context<'_>, packet: &mut Packet, lighting: &mut Lighting) {
    let scene = context.scene;
    lighting.points.clear();
    for run in 0..packet.runs().len() {
        let Some((geometry, material)) = packet.runs()[run].hit else { continue };
        if !scene.materials.get(material).is_lit() {
            continue;
        }
        let (name, material) = (scene.materials.scope(material), scene.materials.get(material));
        let hits = &mut packet.sub_packet(run, Some(scene.geometry.get(geometry)));
        scope(name, || {
            tilt_normals(material, hits);
            by_opacity(context, material, hits, |part, opacities| {
                if is_seen(opacities) {
                    lighting.points.append(part);
                }
            });
        });
    }
    let count = lighting.points.len();
    if count == 0 {
        return;
    }
    let (points, lights) = lighting.of_lights(scene.lights.len());
    for (number, (source, arriving)) in scene.lights.iter().zip(lights).enumerate() {
        illuminate(context, &**source, points, Receivers::of_points(points, number, packet.depth), arriving);
    }
    scope("ambient light", || {
        let out = part_mut(&mut lighting.ambient, 0..count);
        scene.ambient.illuminate(context.token, scene.up.vector(), lighting.points.normals(), out);
        if let Some(occlusion) = scene.occlusion {
            let open: &mut Column<f32> = &mut lend(context.width);
            openness(context, occlusion, &lighting.points, packet.depth, open);
            for column in &mut lighting.ambient {
                column[..count].iter_mut().zip(open.iter()).for_each(|(light, open)| *light *= open);
            }
        }
    });
}

/// Are hits that [`by_opacity`] hands on opaque at all?
fn is_seen(opacities: Option<&[f32]>) -> bool {
    opacities.is_none_or(|opacities| opacities[0] > 0.0)
}

/// Hands on the rays of a sub-packet in parts: those that are [opaque](crate::packet::Surface::opacities) at all, and those that are not,
/// each with their opacities; all at once, without, if they are opaque.
fn by_opacity(
    context: &Context<'_>,
    material: &dyn Material,
    hits: &mut SubPacket<'_>,
    mut take: impl FnMut(&mut SubPacket<'_>, Option<&[f32]>),
) {
    let kept: &mut Column<f32> = &mut lend(context.width);
    let kept = &mut kept[..hits.len()];
    if !opacities(material, hits, kept) {
        return take(hits, None);
    }
    let mut start = 0;
    for alike in kept.chunk_by(|a, b| (*a > 0.0) == (*b > 0.0)) {
        take(&mut hits.sub_packet(start..start + alike.len()), Some(alike));
        start += alike.len();
    }
}
