//! The ray tracer of the paper's Figure 6.

use crate::medium::composite;
use crate::packet::Packet;
use crate::pipeline::fault::scope;
use crate::stack::{Context, Renderer};

/// Intersects a packet, splits it into runs of one material, and hands each run to that material as a sub-packet, or to
/// the background. Materials call back for secondary rays. At last the medium is put before it all.
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

impl Renderer for Raytracer {
    fn trace(&self, context: &Context<'_>, packet: &mut Packet) {
        if packet.depth <= self.max_depth {
            context.statistics.count_rays(packet);
            context.scene.intersect(context, packet);
        }
        context.scene.shade(context, packet);
        scope("medium", || composite(context, packet));
    }
}
