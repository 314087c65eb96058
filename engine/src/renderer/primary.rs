//! Primary rays and nothing else: what a structure and its kernels can do.

use glam::Vec3;
use mobula_core::RayPacket;
use mobula_core::rays::set_vec3;

use crate::stack::{Context, Renderer};

/// No index: the scene clamps indices to the materials that it has.
const NO_MATERIAL: u32 = u32::MAX;

/// Shows the base colour of each material, unlit, and black where nothing is.
#[derive(Clone, Copy, Debug, Default)]
pub struct Primary;

impl<const N: usize> Renderer<N> for Primary {
    fn trace(&self, context: &Context<'_, N>, packet: &mut RayPacket<N>) {
        packet.reset_hits();
        context.statistics.count_rays(packet);
        context.scene.intersect(context, packet);
        // Neighbours mostly hit the same material, which is asked once.
        let mut last = (NO_MATERIAL, Vec3::ZERO);
        for i in packet.range() {
            let material = if packet.was_hit(i) { packet.hits.material[i] } else { NO_MATERIAL };
            if material != last.0 {
                let color =
                    if material == NO_MATERIAL { Vec3::ZERO } else { context.scene.material(material).base_color() };
                last = (material, color);
            }
            set_vec3(&mut packet.color, i, last.1);
        }
    }
}
