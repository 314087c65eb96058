//! Renderers that show one quantity of each hit as a colour, to look at geometry.

use glam::Vec3;
use mobula_core::rays::{set_vec3, vec3};
use mobula_core::{RayPacket, SubPacket};

use super::runs::next_run;
use crate::math::{hash, unit};
use crate::stack::{Context, Renderer};

/// What [`Inspect`] shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// The unit shading normal n: `(n + 1) / 2`.
    Normal,
    /// Distance: `s / (s + t)`, where s is the size of the scene. Near is white.
    Depth,
    /// Texture coordinates: red and green, their fractional parts.
    TextureCoordinates,
    /// A colour for each primitive id.
    Primitive,
}

/// Shows one quantity of what primary rays hit; black where nothing is.
#[derive(Clone, Copy, Debug)]
pub struct Inspect(pub Quantity);

impl<const N: usize> Renderer<N> for Inspect {
    fn trace(&self, context: &Context<'_, N>, packet: &mut RayPacket<N>) {
        packet.reset_hits();
        context.statistics.count_rays(packet);
        context.scene.intersect(context, packet);
        let mut at = packet.range().start;
        while let Some((material, range)) = next_run(packet, at) {
            at = range.end;
            match material {
                Some(_) => self.show(context, &mut packet.sub_packet(range)),
                None => range.for_each(|i| set_vec3(&mut packet.color, i, Vec3::ZERO)),
            }
        }
    }
}

impl Inspect {
    fn show<const N: usize>(&self, context: &Context<'_, N>, hits: &mut SubPacket<'_, N>) {
        let scene = context.scene;
        match self.0 {
            Quantity::Normal => {
                hits.normals(scene.surface());
                for i in hits.range() {
                    let (_, normal) = hits.derived(i);
                    hits.set_color(i, normal * 0.5 + 0.5);
                }
            }
            Quantity::Depth => {
                let (low, high) = scene.geometry().bounds();
                let size = (high - low).length();
                for i in hits.range() {
                    hits.set_color(i, Vec3::splat(size / (size + hits.t_max[i])));
                }
            }
            Quantity::TextureCoordinates => {
                for i in hits.range() {
                    let at = vec3(hits.texture_coordinates(scene.surface()), i);
                    hits.set_color(i, at - at.floor());
                }
            }
            Quantity::Primitive => {
                for i in hits.range() {
                    let h = hash(hits.hits.primitive[i].wrapping_add(1));
                    let channels = [h, h << 8, h << 16];
                    hits.set_color(i, Vec3::from(channels.map(|c| 0.1 + 0.8 * unit(c))));
                }
            }
        }
    }
}
