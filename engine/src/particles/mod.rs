//! Particles: points with scalar attributes, in one or several steps of time.
//!
//! | file | idea |
//! |---|---|
//! | `tiling` | a periodic box, repeated along its edges |
//! | `spacing` | how far particles are apart, from which a radius can be guessed |
//! | `elements` | chemical elements: symbols, radii, colours |
//! | `attribute` | a number of each particle, in the type that it came in |
//! | `sample` | some of the particles of a step, which show how far all reach |

mod attribute;
pub(crate) mod elements;
mod sample;
mod spacing;
mod tiling;

use std::fmt::Debug;
use std::sync::Arc;

pub use attribute::{Attribute, Values};
pub use elements::element_colors;
pub use tiling::TilingError;

use crate::volume::Statistics;

/// Particles: one list a step of time.
#[derive(Clone, Debug)]
pub struct Particles {
    /// What people call them.
    pub name: String,
    /// The steps of time, at least one; `None`: one that `source` has.
    pub steps: Vec<Option<Arc<ParticleStep>>>,
    /// What reads steps that are not in memory; `None`: all are.
    pub source: Option<Arc<dyn Source>>,
}

/// Reads steps of time when they are wanted: where there is no memory for all.
pub trait Source: Debug + Send + Sync {
    /// Reads a step, from 0. It has what each particle of the other steps has.
    ///
    /// # Errors
    /// If it cannot be read: a line for people.
    fn read(&self, step: usize) -> Result<ParticleStep, String>;
}

/// The particles of one step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ParticleStep {
    /// Where they are.
    pub centers: Vec<[f32; 3]>,
    /// Their radii, one each; empty: they have none.
    pub radii: Vec<f32>,
    /// Numbers that each particle has, each as long as `centers`. A step without particles may have no attributes.
    pub attributes: Vec<Attribute>,
    /// The edges of the periodic box, where it is known.
    pub cell: Option<[[f32; 3]; 3]>,
}

impl ParticleStep {
    /// The attribute of a name.
    pub fn attribute(&self, name: &str) -> Option<&Attribute> {
        self.attributes.iter().find(|attribute| attribute.name == name)
    }

    /// Keeps the particles for which `keep` is true.
    pub fn retain(&mut self, keep: &[bool]) {
        attribute::retain(&mut self.centers, keep);
        attribute::retain(&mut self.radii, keep);
        self.attributes.iter_mut().for_each(|attribute| attribute.retain(keep));
    }

    /// Names and types of what each particle has.
    pub fn kinds(&self) -> Vec<(&str, &'static str)> {
        let radius = (!self.radii.is_empty()).then_some(("radius", "f32"));
        let attributes = self.attributes.iter().map(|attribute| (&*attribute.name, attribute.type_name()));
        radius.into_iter().chain(attributes).collect()
    }

    /// About the bytes that it takes once rays can find it: a fifth more than its numbers, and 4 bytes a particle.
    pub fn bytes_shown(&self) -> u64 {
        let values = self.attributes.iter().map(|attribute| match &attribute.values {
            Values::F32(values) => size_of_val(&**values),
            Values::U8(values) => values.len(),
        });
        let numbers = values.sum::<usize>() + 16 * self.centers.len();
        (numbers + numbers / 5 + 4 * self.centers.len()) as u64
    }

    /// The names of what each particle has, in alphabetical order.
    pub fn names(&self) -> Vec<&str> {
        let mut names: Vec<_> = self.kinds().into_iter().map(|(name, _)| name).collect();
        names.sort_unstable();
        names
    }

    /// Has each particle of this step what those of the other have? A step without particles goes with any.
    pub fn goes_with(&self, other: &Self) -> bool {
        self.centers.is_empty() || other.centers.is_empty() || self.names() == other.names()
    }
}

impl Particles {
    /// Particles all of whose steps are in memory.
    pub fn in_memory(name: impl Into<String>, steps: Vec<Arc<ParticleStep>>) -> Self {
        Self { name: name.into(), steps: steps.into_iter().map(Some).collect(), source: None }
    }

    /// The steps that are in memory.
    pub fn read(&self) -> impl Iterator<Item = &Arc<ParticleStep>> {
        self.steps.iter().flatten()
    }

    /// A step that has particles, and so says which attributes there are; else the first that is in memory.
    pub fn sample(&self) -> Option<&Arc<ParticleStep>> {
        self.read().find(|step| !step.centers.is_empty()).or(self.read().next())
    }

    /// Particles of all steps that are in memory.
    pub fn count(&self) -> usize {
        self.read().map(|step| step.centers.len()).sum()
    }

    /// Gives an attribute that has different types in different steps one type.
    pub fn unify(&mut self) {
        let Some(sample) = self.sample().cloned() else { return };
        for name in sample.attributes.iter().map(|attribute| &attribute.name) {
            let is_u8 = |step: &Arc<ParticleStep>| {
                step.attribute(name).is_none_or(|attribute| matches!(attribute.values, Values::U8(_)))
            };
            if self.read().all(is_u8) {
                continue;
            }
            for step in self.steps.iter_mut().flatten().filter(|step| step.attribute(name).is_some() && is_u8(step)) {
                let all = Arc::make_mut(step).attributes.iter_mut();
                for attribute in all.filter(|attribute| attribute.name == *name) {
                    attribute.values = Values::F32(attribute.values.to_f32().into_owned());
                }
            }
        }
    }

    /// Which values an attribute has in all steps in memory together, and how often; `None`: there is none of this name.
    pub fn statistics(&self, name: &str) -> Option<Statistics> {
        let all: Vec<&Values> = self.read().filter_map(|step| Some(&step.attribute(name)?.values)).collect();
        if all.is_empty() {
            return None;
        }
        let bytes = all.iter().map(|values| if let Values::U8(values) = values { Some(&**values) } else { None });
        if let Some(bytes) = bytes.collect::<Option<Vec<&[u8]>>>() {
            return Some(Statistics::of_values(&bytes));
        }
        Some(Statistics::of_values(&all.iter().map(|values| values.to_f32()).collect::<Vec<_>>()))
    }

    /// Which radii there are in all steps in memory together, and how often; `None`: there is none.
    pub fn radius_statistics(&self) -> Option<Statistics> {
        let radii: Vec<&[f32]> = self.read().map(|step| &*step.radii).filter(|radii| !radii.is_empty()).collect();
        (!radii.is_empty()).then(|| Statistics::of_values(&radii))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn step(count: usize, values: Values) -> Arc<ParticleStep> {
        let attributes = vec![Attribute { name: "kind".to_owned(), values }];
        Arc::new(ParticleStep { centers: vec![[0.0; 3]; count], attributes, ..ParticleStep::default() })
    }

    #[test]
    fn types_are_unified_and_values_counted_over_all_steps() {
        let (first, second) = (step(2, Values::U8(vec![1, 7])), step(2, Values::F32(vec![-0.5, f32::NAN])));
        let empty = Arc::new(ParticleStep::default());
        let steps = vec![empty.clone(), first.clone(), second.clone()];
        let mut particles = Particles::in_memory("", steps);
        assert!(
            first.goes_with(&second)
                && first.goes_with(&empty)
                && !first.goes_with(&step(1, Values::U8(vec![1])).renamed())
        );
        let found = particles.statistics("kind").unwrap();
        assert_eq!((found.range, found.not_numbers), (Some([-0.5, 7.0]), 1));
        particles.unify();
        assert_eq!(particles.read().nth(1).unwrap().attributes[0].values, Values::F32(vec![1.0, 7.0]));
        assert_eq!(particles.sample().unwrap().kinds(), [("kind", "f32")]);
        assert_eq!((particles.count(), particles.statistics("none")), (4, None));
        let bytes = Particles::in_memory("", vec![first.clone(), first]);
        assert_eq!(bytes.statistics("kind").unwrap().range, Some([1.0, 7.0]));
        assert_eq!(bytes.radius_statistics(), None);
    }

    impl ParticleStep {
        fn renamed(&self) -> Self {
            let mut other = self.clone();
            other.attributes[0].name = "other".to_owned();
            other
        }
    }
}
