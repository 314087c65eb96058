//! Materials that no light changes.

use glam::Vec3;
use mobula_core::rays::{set_vec3, vec3};
use mobula_core::{Columns3, SubPacket};

use super::for_each_color;
use crate::scratch::lend;
use crate::stack::{Context, Material};

/// The same colour everywhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flat {
    /// The colour, linear RGB.
    pub color: Vec3,
}

impl<const N: usize> Material<N> for Flat {
    fn shade(&self, context: &Context<'_, N>, hits: &mut SubPacket<'_, N>) {
        let colors: &mut Columns3<N> = &mut lend();
        for_each_color(context, hits, |i, own| set_vec3(colors, i, self.color * own));
        hits.range().for_each(|i| hits.set_color(i, vec3(colors, i)));
    }

    fn base_color(&self) -> Vec3 {
        self.color
    }
}

/// The shading normal as a colour: `(n + 1) / 2`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NormalColor;

impl<const N: usize> Material<N> for NormalColor {
    fn shade(&self, context: &Context<'_, N>, hits: &mut SubPacket<'_, N>) {
        hits.normals(context.scene.surface());
        for i in hits.range() {
            let (_, normal) = hits.derived(i);
            hits.set_color(i, normal * 0.5 + 0.5);
        }
    }

    fn base_color(&self) -> Vec3 {
        Vec3::splat(0.5)
    }
}
