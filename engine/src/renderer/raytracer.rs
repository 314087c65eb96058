//! The ray tracer of the paper's Figure 6.

use mobula_core::RayPacket;

use super::runs::next_run;
use crate::stack::{Context, Renderer};

/// Intersects a packet, splits it into runs of one material, and hands each run to that material as a sub-packet, or to
/// the background. Materials call back for secondary rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Raytracer {
    /// Rays with more reflections and refractions than this behind them see the background only.
    pub max_depth: u32,
}

impl Default for Raytracer {
    fn default() -> Self {
        Self { max_depth: 6 }
    }
}

impl<const N: usize> Renderer<N> for Raytracer {
    fn trace(&self, context: &Context<'_, N>, packet: &mut RayPacket<N>) {
        let scene = context.scene;
        packet.reset_hits();
        if packet.depth <= self.max_depth {
            context.statistics.count_rays(packet);
            scene.intersect(context, packet);
        }
        let mut at = packet.range().start;
        while let Some((material, range)) = next_run(packet, at) {
            at = range.end;
            scene.shade(context, material, &mut packet.sub_packet(range));
        }
    }
}
