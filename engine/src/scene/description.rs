//! What is in a scene, as plain data: what loaders and the built-in scene produce. Its parts are the components themselves.
//!
//! A description may be wrong in every way that a file can be wrong: indices out of range, NaN, zero area. Building a scene from it
//! counts what it has to leave out, and never panics.

use std::sync::Arc;

use super::ground::Ground;
use super::particle_look::ParticleLook;
use super::rendering::Rendering;
use super::shown::Shown;
use crate::background::{Background, Gradient};
use crate::geometry::{Geometry, MeshSequence};
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
    /// What volumes are shown as, as far as it is said: there may be fewer of these than volumes.
    pub shown: Vec<Option<Shown>>,
    /// What particles are shown as, likewise.
    pub particle_looks: Vec<Option<ParticleLook>>,
    /// What the geometries' material indices refer to.
    pub materials: Vec<NamedMaterial>,
    /// Where light comes from, beside a background that lights; none gives such a background alone, or the default light, placed around
    /// the geometry.
    pub lights: Vec<Arc<dyn Light>>,
    /// Light that comes from everywhere; a background that lights has its own.
    pub ambient: Arc<dyn AmbientLight>,
    /// What is seen where nothing is.
    pub background: Arc<dyn Background>,
    /// What is between surfaces.
    pub media: Vec<Arc<dyn Medium>>,
    /// What it stands on, if anything: no part of it.
    pub ground: Option<Ground>,
    /// Which way is up; `None` guesses from the bounds.
    pub up: Option<Up>,
    /// Where to look from; `None` frames everything.
    pub view: Option<View>,
    /// How to render it.
    pub rendering: Rendering,
    /// What it was put together from, if that is known.
    pub objects: Vec<Object>,
}

/// A part of a scene: one or several files, or what a scene file says itself.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Object {
    /// What it is: `mesh`, `volume`, ...
    pub kind: &'static str,
    /// Its files, or else what it is called.
    pub names: Vec<String>,
    /// The material that all of it has, where the scene says so.
    pub material: Option<String>,
    /// How many of the scene's volumes it is.
    pub volumes: usize,
}

impl Default for SceneDescription {
    /// Nothing under a pale sky.
    fn default() -> Self {
        Self {
            name: String::new(),
            geometry: Vec::new(),
            volumes: Vec::new(),
            particles: Vec::new(),
            shown: Vec::new(),
            particle_looks: Vec::new(),
            materials: Vec::new(),
            lights: Vec::new(),
            ambient: Arc::new(Hemisphere::default()),
            background: Arc::new(Gradient::default()),
            media: Vec::new(),
            ground: None,
            up: None,
            view: None,
            rendering: Rendering::default(),
            objects: Vec::new(),
        }
    }
}

impl SceneDescription {
    /// The steps of time of that volume, mesh, or those particles, that have most of them.
    pub fn steps(&self) -> usize {
        let volumes = self.volumes.iter().map(|volume| volume.steps.len());
        let particles = self.particles.iter().map(|particles| particles.steps.len());
        let meshes = self.geometry.iter().filter_map(|one| one.downcast_ref::<MeshSequence>());
        volumes.chain(particles).chain(meshes.map(|one| one.steps().len())).max().unwrap_or(0)
    }

    /// Shows meshes that change with time at a step; behind the last comes the first.
    pub fn show_meshes_at(&mut self, step: usize) {
        for geometry in &mut self.geometry {
            if let Some(meshes) = geometry.downcast_ref::<MeshSequence>() {
                *geometry = Arc::new(meshes.at(step));
            }
        }
    }

    /// Has it meshes that change with time?
    pub fn has_moving_meshes(&self) -> bool {
        self.geometry.iter().any(|geometry| geometry.downcast_ref::<MeshSequence>().is_some())
    }

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
    /// where it has them, and so for each thing that it says of how to render it.
    pub fn merge(&mut self, mut other: SceneDescription) {
        let shift = self.materials.len() as u32;
        self.geometry.extend(other.geometry.into_iter().map(|geometry| geometry.shift_materials(shift)));
        self.shown.resize(self.volumes.len(), None);
        other.shown.iter_mut().flatten().for_each(|shown| shown.shift_materials(shift));
        self.volumes.append(&mut other.volumes);
        self.particle_looks.resize(self.particles.len(), None);
        other.particle_looks.iter_mut().flatten().for_each(|look| look.shift_materials(shift));
        self.particles.append(&mut other.particles);
        self.particle_looks.append(&mut other.particle_looks);
        self.shown.append(&mut other.shown);
        self.materials.append(&mut other.materials);
        self.lights.append(&mut other.lights);
        self.media.append(&mut other.media);
        self.ground = self.ground.or(other.ground);
        self.up = self.up.or(other.up);
        self.view = self.view.or(other.view);
        self.rendering.merge(other.rendering);
        self.objects.append(&mut other.objects);
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
