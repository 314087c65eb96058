//! What is in a scene, as plain data: what loaders and the built-in scene produce. Its parts are the components themselves.
//!
//! A description may be wrong in every way that a file can be wrong: indices out of range, NaN, zero area. Building a scene from it
//! counts what it has to leave out, and never panics.

use std::sync::Arc;

use crate::background::{Background, Gradient};
use crate::geometry::Geometry;
use crate::light::{AmbientLight, Hemisphere, Light};
use crate::material::{Material, NamedMaterial};
use crate::medium::Medium;
use crate::particles::Particles;
use crate::view::{Up, View};
use crate::volume::Volume;

/// Everything that a picture needs, but the image size.
#[derive(Clone, Debug)]
pub struct SceneDescription {
    /// What people call it: usually a file's name.
    pub name: String,
    /// What is seen.
    pub geometry: Vec<Arc<dyn Geometry>>,
    /// Volumes, of which iso-surfaces and media are made.
    pub volumes: Vec<Volume>,
    /// Particles, of which geometry is made.
    pub particles: Vec<Particles>,
    /// What the geometries' material indices refer to.
    pub materials: Vec<NamedMaterial>,
    /// Where light comes from; none gives the default lights, placed around the geometry.
    pub lights: Vec<Arc<dyn Light>>,
    /// Light that comes from everywhere.
    pub ambient: Arc<dyn AmbientLight>,
    /// What is seen where nothing is.
    pub background: Arc<dyn Background>,
    /// What is between surfaces.
    pub media: Vec<Arc<dyn Medium>>,
    /// Which way is up; `None` guesses from the bounds.
    pub up: Option<Up>,
    /// Where to look from; `None` frames everything.
    pub view: Option<View>,
}

impl Default for SceneDescription {
    /// Nothing under a pale sky.
    fn default() -> Self {
        Self {
            name: String::new(),
            geometry: Vec::new(),
            volumes: Vec::new(),
            particles: Vec::new(),
            materials: Vec::new(),
            lights: Vec::new(),
            ambient: Arc::new(Hemisphere::default()),
            background: Arc::new(Gradient::default()),
            media: Vec::new(),
            up: None,
            view: None,
        }
    }
}

impl SceneDescription {
    /// Adds a material and returns its index.
    pub fn add_material(&mut self, name: impl Into<String>, material: impl Material) -> u32 {
        self.materials.push(NamedMaterial { name: name.into(), material: Arc::new(material) });
        (self.materials.len() - 1) as u32
    }

    /// Adds a geometry.
    pub fn add(&mut self, geometry: impl Geometry) {
        self.geometry.push(Arc::new(geometry));
    }

    /// Adds a light.
    pub fn add_light(&mut self, light: impl Light) {
        self.lights.push(Arc::new(light));
    }

    /// Adds everything of `other`, whose material indices it shifts; keeps its own name, background, up and view
    /// where it has them.
    pub fn merge(&mut self, mut other: SceneDescription) {
        let shift = self.materials.len() as u32;
        self.geometry.extend(other.geometry.into_iter().map(|geometry| geometry.shift_materials(shift)));
        self.volumes.append(&mut other.volumes);
        self.particles.append(&mut other.particles);
        self.materials.append(&mut other.materials);
        self.lights.append(&mut other.lights);
        self.media.append(&mut other.media);
        self.up = self.up.or(other.up);
        self.view = self.view.or(other.view);
        if self.name.is_empty() {
            self.name = other.name;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{DEFAULT_MATERIAL, Mesh};
    use crate::material::Flat;

    #[test]
    fn joined_scenes_keep_their_materials() {
        let scene = |name: &str| {
            let mut scene = SceneDescription::default();
            let material = scene.add_material(name, Flat::default());
            scene.add(Mesh { material, ..Mesh::default() });
            scene.add(Mesh { materials: vec![material, DEFAULT_MATERIAL], ..Mesh::default() });
            scene
        };
        let mut all = scene("one");
        all.merge(scene("two"));
        let materials = |number: usize| {
            let mut out = [9; 2];
            (all.geometry[number].materials(&[0, 1], &mut out), out)
        };
        assert_eq!([0, 2].map(|number| materials(number).0), [Some(0), Some(1)]);
        assert_eq!([1, 3].map(|number| materials(number).1), [[0, DEFAULT_MATERIAL], [1, DEFAULT_MATERIAL]]);
        assert_eq!(all.materials.iter().map(|named| named.name.as_str()).collect::<Vec<_>>(), ["one", "two"]);
    }
}
