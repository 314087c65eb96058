//! The ray tracer of the paper's Figure 6.

use crate::medium::composite;
use crate::packet::Packet;
use crate::pipeline::fault::scope;
use crate::shading::{see_through, shade};
use crate::stack::{Context, Renderer};

/// Intersects a packet, splits it into runs of one material, and hands each run to that material as a sub-packet, or to
/// the background. Materials call back for secondary rays. Then the medium is put before it all. At last the same is done behind hits
/// that are opaque in part, which the rays go on through.
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
        show(context, packet);
        see_through(context, packet, |behind| {
            let secondary = &context.statistics.secondary;
            secondary.set(secondary.get() + behind.len() as u64);
            context.scene.intersect(context, behind);
            show(context, behind);
        });
    }
}

/// Colours rays by what they hit, and by the medium before it.
fn show(context: &Context<'_>, packet: &mut Packet) {
    shade(context, packet);
    scope("medium", || composite(context, packet));
}
