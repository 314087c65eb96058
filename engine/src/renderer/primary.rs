//! Primary rays and nothing else: what a structure and its kernels can do.

use glam::Vec3;

use crate::packet::Packet;
use crate::stack::{Context, Renderer};

/// Shows the base colour of each material, unlit, and black where nothing is.
#[derive(Clone, Copy, Debug, Default)]
pub struct Primary;

impl Renderer for Primary {
    fn trace(&self, context: &Context<'_>, packet: &mut Packet) {
        let scene = context.scene;
        context.statistics.count_rays(packet);
        scene.intersect(context, packet);
        for run in 0..packet.runs().len() {
            match packet.runs()[run].hit {
                Some((geometry, material)) => {
                    let hits = &mut packet.sub_packet(run, Some(scene.geometry.get(geometry)));
                    scene.materials.get(material).show_base_color(hits);
                }
                None => packet.sub_packet(run, None).fill_color(Vec3::ZERO),
            }
        }
    }
}
