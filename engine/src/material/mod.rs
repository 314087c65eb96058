//! Materials: what colours the rays that hit something.

mod lambertian;
mod phong;
mod points;
mod secondary;
mod unlit;

use std::sync::Arc;

use glam::Vec3;
use mobula_core::SubPacket;

pub use lambertian::Lambertian;
pub use phong::Phong;
pub use points::Points;
pub use unlit::{Flat, NormalColor};

use crate::scene::MaterialDescription;
use crate::stack::{Context, Material};

/// The material that a description describes.
pub fn build<const N: usize>(description: &MaterialDescription) -> Arc<dyn Material<N>> {
    match description {
        MaterialDescription::Flat { color } => Arc::new(Flat { color: *color }),
        MaterialDescription::Lambertian { diffuse } => Arc::new(Lambertian { diffuse: *diffuse }),
        MaterialDescription::Phong(phong) => Arc::new(Phong::new(phong)),
        MaterialDescription::NormalColor => Arc::new(NormalColor),
    }
}

/// Calls `f` with each row of `hits` and the own colour of the primitive that it hit.
#[inline(always)]
fn for_each_color<const N: usize>(context: &Context<'_, N>, hits: &SubPacket<'_, N>, mut f: impl FnMut(usize, Vec3)) {
    let geometry = context.scene.geometry();
    let mut near = 0;
    for i in hits.range() {
        let color = if geometry.has_colors() { geometry.color(hits.hits.primitive[i], &mut near) } else { Vec3::ONE };
        f(i, color);
    }
}
