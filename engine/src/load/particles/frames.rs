//! The frames of a file become the steps of particles: put where rays can be traced, without what is not finite.

use std::io::BufRead;
use std::path::Path;
use std::sync::Arc;

use glam::Vec3;

use super::columns::Columns;
use super::names;
use super::periodic::Cell;
use crate::geometry::{Census, Item};
use crate::load::input::Input;
use crate::load::lines::{Fault, Lines, Stop};
use crate::load::loaded::{Loaded, Report, display_name};
use crate::load::{LoadError, Options, Place};
use crate::particles::{Attribute, ParticleStep, Particles, Values};
use crate::scene::SceneDescription;

/// Particles of all steps.
const PARTICLES: Item = Item::primitives("particles", "particle", "particles");
const NOT_FINITE: Item =
    Item::left_out("non_finite_particles", "particle that is not finite", "particles that are not finite");
/// More steps are in no file.
const MOST_STEPS: usize = 100_000;
/// So many particles say where they are put.
const SAMPLES: usize = 4096;

/// What a file says of one step.
#[derive(Debug)]
pub(in crate::load) struct Frame {
    pub(in crate::load) columns: Columns,
    /// The edges of the periodic box.
    pub(in crate::load) cell: Option<Cell>,
    /// Radii that follow from something else; empty: none do.
    pub(in crate::load) radii: Vec<f32>,
}

/// The frames of a file, as far as they were read.
pub(in crate::load) struct Frames<'a> {
    file: &'a Path,
    options: &'a Options,
    place: Option<Place>,
    steps: Vec<Arc<ParticleStep>>,
    /// The first step that has particles.
    first: Option<Arc<ParticleStep>>,
    census: Census,
    warnings: Vec<String>,
}

/// Longer lines are in no file of particles.
const LONGEST_LINE: usize = 1 << 20;

/// The lines of a file.
pub(super) type TextLines<'a> = Lines<&'a mut Box<dyn BufRead>>;

/// Loads a file of text, whose frames `read` reads. `names` are those of the format, and of it as gzip.
pub(super) fn load(
    file: &Path,
    mut input: Input,
    options: &Options,
    names: [&'static str; 2],
    read: impl FnOnce(&mut TextLines<'_>, &mut Frames<'_>) -> Result<(), Stop>,
) -> Result<Loaded, LoadError> {
    let mut lines = Lines::no_longer_than(LONGEST_LINE, &mut input.reader);
    let mut frames = Frames::new(file, options);
    let read = read(&mut lines, &mut frames);
    let line = lines.number;
    read.map_err(|stop| stop.into_error(file, line, input.gzip))?;
    frames.finish(names[usize::from(input.gzip)], input.warning(file))
}

impl<'a> Frames<'a> {
    pub(in crate::load) fn new(file: &'a Path, options: &'a Options) -> Self {
        let census = Census::default();
        let (steps, warnings) = (Vec::new(), Vec::new());
        Self { file, options, place: options.place, steps, first: None, census, warnings }
    }

    /// What people should know.
    pub(in crate::load) fn warn(&mut self, what: &str) {
        self.warnings.push(format!("{}{what}", self.file.display()));
    }

    /// Steps so far.
    pub(super) fn len(&self) -> usize {
        self.steps.len()
    }

    /// Adds a frame.
    pub(in crate::load) fn add(&mut self, frame: Frame) -> Result<(), Fault> {
        if self.steps.len() >= MOST_STEPS {
            return Err(Fault::new(format!("there are more than {MOST_STEPS} steps of time"), "split the file"));
        }
        let count = frame.columns.len();
        let place = self.place_of(&frame.columns);
        let step = step(frame, &place);
        self.census.add(PARTICLES, count as u64);
        if step.centers.len() < count {
            self.census.add(NOT_FINITE, (count - step.centers.len()) as u64);
        }
        for (i, &center) in step.centers.iter().enumerate() {
            let radius = step.radii.get(i).copied().filter(|radius| radius.is_finite() && *radius > 0.0).unwrap_or(0.0);
            self.census.include(center.into(), radius);
        }
        if self.first.as_ref().is_some_and(|first| !first.goes_with(&step)) {
            let problem = "the particles of this step have other columns than those of the first";
            return Err(Fault::new(problem, "split the file"));
        }
        let step = Arc::new(step);
        if self.first.is_none() && !step.centers.is_empty() {
            self.first = Some(Arc::clone(&step));
        }
        self.steps.push(step);
        Ok(())
    }

    /// Where all is put: the first frame with particles says so, if no other file does.
    fn place_of(&mut self, columns: &Columns) -> Place {
        let count = columns.len();
        if count == 0 || self.first.is_some() {
            return self.place.unwrap_or_default();
        }
        let positions: Vec<_> = (0..count).step_by(count.div_ceil(SAMPLES)).map(|i| columns.position(i)).collect();
        let all: Vec<u32> = (0..positions.len() as u32).collect();
        let place = self.place.unwrap_or_else(|| Place::of(&positions, &all));
        if self.options.place.is_none() {
            if let Some(text) = place.warning() {
                self.warn(&format!(": {text}"));
            }
        } else if place.blurs(&positions, &all) {
            self.warn(": it is so far from the first file that its details are lost; show it alone, or name it first");
        }
        *self.place.insert(place)
    }

    /// The scene of all frames. `gzip` and `warning` say what is known of the file once all is read.
    pub(in crate::load) fn finish(
        mut self,
        format: &'static str,
        warning: Option<String>,
    ) -> Result<Loaded, LoadError> {
        let (count, left_out) = (self.census.count(PARTICLES.key), self.census.left_out());
        if count == 0 {
            return Err(LoadError::new(self.file, "there is no particle in it", "leave it out"));
        }
        if count == left_out {
            let problem = "no particle is at a finite position";
            return Err(LoadError::new(self.file, problem, "check how it was written"));
        }
        self.warnings.extend(warning);
        // What is shared would be copied when types are unified.
        self.first = None;
        let mut particles = Particles::in_memory(display_name(self.file), self.steps);
        particles.unify();
        let scene = SceneDescription {
            name: particles.name.clone(),
            particles: vec![particles],
            ..SceneDescription::default()
        };
        let report = Report { format, census: self.census, warnings: self.warnings };
        Ok(Loaded { scene, report, place: self.place.unwrap_or_default() })
    }
}

/// A frame as a step: put, without what is not finite, and with the length of velocities.
fn step(frame: Frame, place: &Place) -> ParticleStep {
    let Frame { columns, cell, radii } = frame;
    let count = columns.len();
    let centers: Vec<[f32; 3]> = (0..count).map(|i| place.put(columns.position(i))).collect();
    let (mut all, mut values) = columns.into_others();
    let scaled = |radius: f64| (radius * place.scale) as f32;
    let radii = match names::radius(&all) {
        Some((at, factor)) => {
            all.remove(at);
            let radii = values.remove(at);
            radii.to_f32().iter().map(|&radius| scaled(f64::from(radius) * factor)).collect()
        }
        None => radii.into_iter().map(|radius| scaled(radius.into())).collect(),
    };
    let speed = names::velocities(&all).filter(|_| !all.iter().any(|name| name.eq_ignore_ascii_case("speed")));
    let speed = speed.map(|v| {
        let length = |i: usize| Vec3::from(v.map(|at| values[at].get(i))).length();
        Attribute { name: "speed".to_owned(), values: Values::F32((0..count).map(length).collect()) }
    });
    let attributes = all.into_iter().zip(values).map(|(name, values)| Attribute { name, values });
    let attributes = if count == 0 { Vec::new() } else { attributes.chain(speed).collect() };
    let cell = cell.map(|cell| cell.map(|edge| edge.map(|x| (x * place.scale) as f32)));
    let mut step = ParticleStep { centers, radii, attributes, cell };
    let keep: Vec<bool> = step.centers.iter().map(|&center| Vec3::from(center).is_finite()).collect();
    if keep.contains(&false) {
        step.retain(&keep);
    }
    step
}
