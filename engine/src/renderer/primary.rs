//! Primary rays and nothing else: what a structure and its kernels can do.

use glam::Vec3;

use crate::packet::{Columns3, Packet};
use crate::scratch::lend;
use crate::stack::{Context, Renderer};

/// Shows the base colour of each material, unlit, and black where nothing is.
#[derive(Clone, Copy, Debug, Default)]
pub struct Primary;

impl Renderer for Primary {
    fn trace(&self, context: &Context<'_>, packet: &mut Packet) {
        let scene = context.scene;
        context.statistics.count_rays(packet);
        scene.intersect(context, packet);
        let albedo: &mut Columns3 = &mut lend(context.width);
        for run in 0..packet.runs().len() {
            match packet.runs()[run].hit {
                Some((geometry, material)) => {
                    let hits = &mut packet.sub_packet(run, Some(scene.geometry.get(geometry)));
                    scene.materials.get(material).albedo(hits, albedo);
                    hits.set_colors(albedo);
                }
                None => packet.sub_packet(run, None).fill_color(Vec3::ZERO),
            }
        }
    }
}
