//! What transactions change of the colours of particles.

use std::sync::Arc;

use super::State;
use crate::geometry::{Coloring, Particles};
use crate::scene::{Map, color_map};

/// How particles of a scene are shown: the first whose colours an attribute decides about, or else the first.
#[derive(Clone, Debug, PartialEq)]
pub struct ShownParticles {
    /// Their attributes that have finite values.
    pub attributes: Vec<ShownAttribute>,
    /// Which of them decides about colours.
    pub color_by: Option<usize>,
}

/// An attribute, and between which values particles are shown.
#[derive(Clone, Debug, PartialEq)]
pub struct ShownAttribute {
    /// Its name.
    pub name: String,
    /// Its least and its greatest value in all steps.
    pub range: [f32; 2],
    /// From which to which value particles are shown; `None`: there are several ranges.
    pub shown: Option<[f32; 2]>,
}

impl State {
    /// How particles are shown, if there are any.
    pub fn particles(&self) -> Option<ShownParticles> {
        let list = self.stack.scene.geometry.list();
        let all = || list.iter().filter_map(|one| one.downcast_ref::<Particles>());
        let first = all().find(|one| one.coloring.is_some()).or_else(|| all().next())?;
        let attribute = |name: &String| {
            let range = first.range(name)?;
            let cropped = first.crops.iter().find(|crop| crop.attribute == *name);
            let shown = match cropped.map(|crop| &crop.ranges[..]) {
                None => Some(range),
                Some(&[only]) => Some(only),
                Some(_) => None,
            };
            Some(ShownAttribute { name: name.clone(), range, shown })
        };
        let attributes: Vec<_> = first.cloud().names().iter().filter_map(attribute).collect();
        let by = first.coloring.as_ref();
        let color_by = by.and_then(|by| attributes.iter().position(|one| one.name == by.attribute));
        Some(ShownParticles { attributes, color_by })
    }

    /// Colours all particles that have an attribute by it, from its least value to its greatest; without a map, as goes with it. Nothing
    /// has to be built.
    pub fn color_particles(&mut self, attribute: &str, map: Option<&Map>) {
        self.change_geometry(|particles: &Particles| {
            let range = particles.range(attribute)?;
            let whole = particles.kinds(attribute).is_some();
            let map = color_map(attribute, whole, map.cloned(), None, || range).ok()?;
            let mut colored = particles.clone();
            colored.coloring = Some(Coloring { attribute: attribute.to_owned(), map: Arc::new(map) });
            Some(colored)
        });
    }
}
