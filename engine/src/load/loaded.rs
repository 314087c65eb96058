//! What was found in a file.

use std::any::Any;
use std::path::Path;
use std::sync::Arc;

use super::place::Place;
use super::text::{printable, quoted};
use crate::geometry::{Census, Mesh, NO_INDEX};
use crate::scene::SceneDescription;
use crate::texture::Maps;

/// A loaded file.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// What is in it.
    pub scene: SceneDescription,
    /// What was found on the way.
    pub report: Report,
    /// Where it was put.
    pub place: Place,
}

impl Loaded {
    /// Smooths meshes without normals, as [`Mesh::smooth`] does.
    pub(super) fn smooth(&mut self, degrees: f32) {
        for geometry in &mut self.scene.geometry {
            // Nobody else has what was just loaded.
            let Some(geometry) = Arc::get_mut(geometry) else { continue };
            let any: &mut dyn Any = geometry;
            let made = any.downcast_mut::<Mesh>().map_or(0, |mesh| mesh.smooth(degrees));
            if made > 0 {
                self.report.census.add(Mesh::MADE_NORMALS, made as u64);
            }
        }
    }

    /// Tells of meshes with textures that lie nowhere, if nobody has yet.
    pub(super) fn tell_of_lost_textures(&mut self) {
        let materials = &self.scene.materials;
        let textured: Vec<bool> = materials.iter().map(|named| *named.material.maps() != Maps::default()).collect();
        if !textured.contains(&true) {
            return;
        }
        for mesh in self.scene.geometry.iter().filter_map(|geometry| geometry.downcast_ref::<Mesh>()) {
            let bare = |&i: &usize| {
                let laid = mesh.triangle_texture_coordinates.get(i).is_some_and(|corners| !corners.contains(&NO_INDEX));
                !laid && textured.get(mesh.material_of(i) as usize) == Some(&true)
            };
            let mut found = (0..mesh.triangles.len()).filter(bare);
            let Some(first) = found.next() else { continue };
            let material = quoted(&materials[mesh.material_of(first) as usize].name);
            let triangles = match found.count() {
                0 => "a triangle has".to_owned(),
                others => format!("{} triangles have", others + 1),
            };
            let mesh = printable(&mesh.name);
            let warning = format!(
                "{mesh}: {triangles} no texture coordinates, but a material with a texture ({material}): all show one place of it"
            );
            if !self.report.warnings.contains(&warning) {
                self.report.warnings.push(warning);
            }
        }
    }
}

/// What was found in a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// Its format, for people.
    pub format: &'static str,
    /// What is in it: counts by name, what is left out, bounds.
    pub census: Census,
    /// What people should know, a line each.
    pub warnings: Vec<String>,
}

impl Report {
    /// Counts what is in a scene that no file holds.
    pub fn of_scene(scene: &SceneDescription) -> Self {
        let mut report = Self { format: "generated", ..Self::default() };
        scene.geometry.iter().for_each(|geometry| report.census.merge(&geometry.census()));
        report
    }

    /// Least and greatest corner of everything; `None` if there is nothing.
    pub fn bounds(&self) -> Option<[[f32; 3]; 2]> {
        let (low, high) = self.census.bounds;
        low.cmple(high).all().then(|| [low.into(), high.into()])
    }

    /// Adds what was found in another file.
    pub fn merge(&mut self, other: Self) {
        self.census.merge(&other.census);
        self.warnings.extend(other.warnings);
    }
}

/// A file's name without folder and extensions.
pub(super) fn display_name(file: &Path) -> String {
    if file == Path::new("-") {
        return "standard input".to_owned();
    }
    let name = file.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    let name = name.strip_suffix(".gz").unwrap_or(&name);
    name.rsplit_once('.').map_or(name, |(stem, _)| stem).to_owned()
}
