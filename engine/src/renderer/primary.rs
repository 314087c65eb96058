//! Primary rays and nothing else: what a structure and its kernels can do.

use glam::Vec3;

use crate::packet::{Packet, part_mut};
use crate::stack::{Context, Renderer};

/// Shows the base colour of each material, unlit, and black where nothing is.
#[derive(Clone, Copy, Debug, Default)]
pub struct Primary;

impl Renderer for Primary {
    fn trace(&self, context: &Context<'_>, packet: &mut Packet) {
        let scene = context.scene;
        context.statistics.count_rays(packet);
        scene.intersect(context, packet);
        let (runs, colors) = packet.runs_and_colors();
        for run in runs {
            let color = run.hit.map_or(Vec3::ZERO, |(_, material)| scene.materials.get(material).base_color());
            for (column, channel) in part_mut(colors, run.rays.clone()).into_iter().zip(color.to_array()) {
                column.fill(channel);
            }
        }
    }
}
