//! The built-in scene: a ray over its reef. Triangles, spheres, all materials, from no file.
//!
//! Everything is computed with plain IEEE operations and [`libm`], so it is the same scene on every machine.

mod manta;
mod reef;
mod sheet;

use std::sync::Arc;

use glam::Vec3;

use crate::background::Gradient;
use crate::light::{Hemisphere, Point};
use crate::material::{Lambertian, Phong};
use crate::scene::SceneDescription;
use crate::view::{Up, View};

/// The scene that is shown when no other is asked for: some 45 000 primitives.
pub fn scene() -> SceneDescription {
    let mut scene = SceneDescription {
        name: "built-in".to_owned(),
        ambient: Arc::new(Hemisphere { above: Vec3::new(0.30, 0.40, 0.48), below: Vec3::new(0.16, 0.14, 0.11) }),
        background: Arc::new(Gradient {
            zenith: Vec3::new(0.006, 0.05, 0.15),
            horizon: Vec3::new(0.15, 0.42, 0.52),
            nadir: Vec3::new(0.015, 0.075, 0.13),
        }),
        up: Some(Up::Y),
        view: Some(View { eye: Vec3::new(4.4, 4.4, 10.6), at: Vec3::new(0.0, 1.05, 0.0), up: Vec3::Y, fov: 32.0 }),
        ..SceneDescription::default()
    };
    scene.add_light(Point { position: Vec3::new(-5.6, 7.6, 5.0), color: Vec3::new(1.05, 0.98, 0.86), falloff: false });
    let mut glossy = |name: &str, diffuse: [f32; 3], specular: f32, shininess: f32, reflection: f32| {
        let (diffuse, specular) = (diffuse.into(), Vec3::splat(specular));
        scene.add_material(name, Phong { diffuse, specular, shininess, reflection, ..Phong::default() })
    };
    let back = glossy("back", [0.022, 0.035, 0.060], 0.35, 30.0, 0.03);
    let belly = glossy("belly", [0.78, 0.80, 0.80], 0.15, 20.0, 0.0);
    let coral = glossy("coral", [1.0, 1.0, 1.0], 0.25, 40.0, 0.0);
    let chrome = glossy("chrome", [0.10, 0.10, 0.11], 0.9, 600.0, 0.80);
    let bubble = scene.add_material(
        "bubble",
        Phong {
            diffuse: Vec3::splat(0.9),
            specular: Vec3::splat(0.8),
            shininess: 400.0,
            transparency: 0.93,
            refractive_index: 1.33,
            ..Phong::default()
        },
    );
    let sand = scene.add_material("sand", Lambertian::new(Vec3::new(0.60, 0.47, 0.31)));
    let rock = scene.add_material("rock", Lambertian::new(Vec3::new(0.20, 0.17, 0.15)));
    reef::ground(sand, rock).into_iter().for_each(|mesh| scene.add(mesh));
    scene.add(reef::corals(coral));
    scene.add(reef::ball(chrome));
    scene.add(reef::bubbles(bubble));
    manta::manta(back, belly).into_iter().for_each(|mesh| scene.add(mesh));
    scene
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_of_it_is_left_out() {
        let mut census = crate::geometry::Census::default();
        scene().geometry.iter().for_each(|geometry| census.merge(&geometry.census()));
        assert_eq!(census.left_out(), 0, "{census:?}");
        assert!((10_000..50_000).contains(&(census.count("triangles") + census.count("spheres"))), "{census:?}");
        assert!(census.count("spheres") > 500, "{census:?}");
    }
}
