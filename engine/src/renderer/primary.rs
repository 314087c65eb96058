//! Primary rays and nothing else: what a structure and its kernels can do.

use glam::Vec3;
use mobula_core::RayPacket;

use super::runs::next_run;
use crate::stack::{Context, Renderer};

/// Shows the base colour of each material, unlit, and black where nothing is.
#[derive(Clone, Copy, Debug, Default)]
pub struct Primary;

impl<const N: usize> Renderer<N> for Primary {
    fn trace(&self, context: &Context<'_, N>, packet: &mut RayPacket<N>) {
        packet.reset_hits();
        context.statistics.count_rays(packet);
        context.scene.intersect(context, packet);
        let mut at = packet.range().start;
        while let Some((material, range)) = next_run(packet, at) {
            at = range.end;
            let color = material.map_or(Vec3::ZERO, |material| context.scene.material(material).base_color());
            for (column, channel) in packet.color.iter_mut().zip(color.to_array()) {
                column[range.clone()].fill(channel);
            }
        }
    }
}
