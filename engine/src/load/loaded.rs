//! What was found in a file.

use std::any::Any;
use std::path::Path;
use std::sync::Arc;

use super::place::Place;
use crate::geometry::{Census, Mesh};
use crate::scene::SceneDescription;

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
