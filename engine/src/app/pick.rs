//! What is seen at a place of the picture.

use glam::Vec3;

use super::State;
use crate::geometry::{IsoSurfaces, Mesh, MeshSequence, Particles, Spheres};
use crate::image::Size;
use crate::packet::Packet;
use crate::stack::{Context, Statistics};

/// What a ray through the picture hits first.
#[derive(Clone, Debug, PartialEq)]
pub struct Picked {
    /// What people call the geometry.
    pub geometry: String,
    /// What its primitives are: `triangle`, `sphere`, ...
    pub kind: &'static str,
    /// Which of them.
    pub primitive: u32,
    /// What people call the material.
    pub material: String,
    /// Where, in coordinates of the scene.
    pub position: Vec3,
    /// How far from where the ray starts.
    pub distance: f32,
}

impl State {
    /// What is at a place of the first channel's picture of a size, in pixels; `None` if nothing is. Media are not hit.
    pub fn pick(&self, size: Size, [x, y]: [f32; 2]) -> Option<Picked> {
        let stack = &self.stack;
        let camera = stack.cameras.first()?;
        let statistics = Statistics::default();
        let context = Context {
            token: stack.token,
            width: stack.width.rays(),
            scene: &stack.scene,
            renderer: &*stack.renderer,
            statistics: &statistics,
            tone: stack.tone,
            eye: camera.eye(),
            frame: 0,
        };
        let mut packet = Packet::new(context.width);
        packet.reset(1);
        (packet.image[0][0], packet.image[1][0]) = (x, y);
        camera.make_rays(&context, [size.width() as u32, size.height() as u32], &mut packet);
        stack.scene.intersect(&context, &mut packet);
        let (geometry, material) = packet.runs().first()?.hit?;
        let rays = packet.rays();
        let ray = |columns: [&[f32]; 3]| Vec3::from(columns.map(|column| column[0]));
        let (origin, direction, t) = (ray(rays.origins()), ray(rays.directions()), rays.t_max()[0]);
        let hit = stack.scene.geometry.get(geometry);
        let kind = if hit.downcast_ref::<Mesh>().is_some() || hit.downcast_ref::<MeshSequence>().is_some() {
            "triangle"
        } else if hit.downcast_ref::<Spheres>().is_some() {
            "sphere"
        } else if hit.downcast_ref::<Particles>().is_some() {
            "particle"
        } else if hit.downcast_ref::<IsoSurfaces>().is_some() {
            "iso-surface cell"
        } else {
            "primitive"
        };
        let materials = &stack.scene.materials;
        Some(Picked {
            geometry: hit.name().to_owned(),
            kind,
            primitive: packet.primitives()[0],
            material: materials.list()[material.min(materials.last()) as usize].name.clone(),
            position: origin + direction * t,
            distance: t * direction.length(),
        })
    }
}

#[cfg(test)]
mod tests {
    use crate::app::{self, Settings};
    use crate::builtin;
    use crate::image::Size;

    #[test]
    fn what_is_seen_is_picked() {
        let size = Size::new(64, 48).unwrap();
        let mut pipeline =
            app::pipeline(&builtin::scene(), &Settings { size, threads: 1, ..Settings::default() }).unwrap();
        let state = pipeline.state();
        let picked = state.pick(size, [32.0, 24.0]).expect("something is in the middle");
        let view = state.chosen().view;
        assert!(((picked.position - view.eye).length() - picked.distance).abs() < 1e-3, "{picked:?}");
        assert!((picked.position - view.eye).normalize().dot(view.basis()[2]) > 0.999, "{picked:?}");
        assert!(["triangle", "sphere"].contains(&picked.kind) && !picked.material.is_empty(), "{picked:?}");
        assert_eq!(state.pick(size, [0.5, -4000.0]), None);
    }
}
