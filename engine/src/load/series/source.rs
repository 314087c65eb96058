//! Steps of particles that are read when they are wanted: a file each.

use std::path::PathBuf;
use std::sync::Arc;

use crate::load::{Load, Memory, Options, Place, input};
use crate::particles::{ParticleStep, Particles, Source};
use crate::progress::Progress;

/// Files, each of which is a step of the same particles.
#[derive(Debug)]
pub(super) struct Files {
    files: Vec<PathBuf>,
    /// The names of what each particle has.
    names: Vec<String>,
    options: Options,
    load: Load,
}

impl Files {
    /// Those of which some have been loaded, with these options, and put somewhere.
    pub(super) fn new(files: Vec<PathBuf>, particles: &Particles, place: Place, options: &Options, load: Load) -> Self {
        let names =
            particles.sample().map(|step| step.names().into_iter().map(str::to_owned).collect()).unwrap_or_default();
        let (memory, progress) = (Memory::default(), Progress::default());
        let options = Options { place: Some(place), memory, progress, ..options.clone() };
        Self { files, names, options, load }
    }
}

impl Source for Files {
    fn read(&self, step: usize) -> Result<ParticleStep, String> {
        let file = &self.files[step];
        let wrong = |problem: &str| format!("{}: {problem}", file.display());
        // What was a file may have become a pipe, for which one would wait for ever.
        if !input::is_regular(file) {
            return Err(wrong("there is no such file any more"));
        }
        let loaded = (self.load)(file, &self.options).map_err(|error| error.to_string())?;
        let mut steps = loaded.scene.particles.into_iter().flat_map(|particles| particles.steps);
        let (Some(Some(step)), None) = (steps.next(), steps.next()) else {
            return Err(wrong("this is not one step of particles, as the other files are"));
        };
        if !step.centers.is_empty() && step.names() != self.names {
            return Err(wrong("the particles of this step have other columns than those of the first"));
        }
        Ok(Arc::unwrap_or_clone(step))
    }
}
