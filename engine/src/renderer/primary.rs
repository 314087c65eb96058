//! Primary rays and nothing else: what a structure and its kernels can do.

use glam::Vec3;
use mobula_core::RayPacket;
use mobula_core::rays::set_vec3;

use crate::stack::{Context, Renderer};

/// Shows the base colour of each material, unlit, and black where nothing is.
#[derive(Clone, Copy, Debug, Default)]
pub struct Primary;

impl<const N: usize> Renderer<N> for Primary {
    fn trace(&self, context: &Context<'_, N>, packet: &mut RayPacket<N>) {
        packet.reset_hits();
        context.statistics.count_rays(packet);
        context.scene.intersect(context, packet);
        for i in packet.range() {
            let hit = packet.was_hit(i);
            let color = if hit { context.scene.material(packet.hits.material[i]).base_color() } else { Vec3::ZERO };
            set_vec3(&mut packet.color, i, color);
        }
    }
}
