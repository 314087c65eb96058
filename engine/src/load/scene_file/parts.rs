//! The files that objects name: found, loaded with one place for all, and joined where they are steps of time.

use std::collections::HashMap;
use std::ops::Range;
use std::path::{Path, PathBuf};

use toml::Spanned;

use super::object_keys::Files;
use super::text::{Text, shortened};
use crate::load::place::Place;
use crate::load::series::{self, Gathering};
use crate::load::{Load, LoadError, Loaded, Options, Raw, RawParticles, Report, input};
use crate::{builtin, generate};

/// So many objects may name the same files: what each makes of them takes memory.
const MOST_TIMES: usize = 16;

/// What a scene file says of files of nothing but numbers.
#[derive(Clone, Debug, Default)]
pub(super) struct RawFiles {
    pub(super) voxels: Option<Raw>,
    pub(super) particles: Option<RawParticles>,
}

/// What is loaded, and how.
pub(super) struct Parts<'a> {
    text: Text<'a>,
    options: &'a Options,
    /// Loads a file that is no scene file itself.
    load: Load,
    place: Option<Place>,
    /// What several objects name, and how many still will.
    kept: HashMap<Vec<String>, (usize, Option<Vec<Loaded>>)>,
}

impl<'a> Parts<'a> {
    pub(super) fn new(text: Text<'a>, options: &'a Options, load: Load) -> Self {
        Self { text, options, load, place: options.place, kept: HashMap::new() }
    }

    /// Where the files were put.
    pub(super) fn place(&self) -> Place {
        self.place.unwrap_or_default()
    }

    /// An object will ask for these.
    pub(super) fn expect(&mut self, names: &Spanned<Files>) -> Result<(), LoadError> {
        let (count, _) = self.kept.entry(names.get_ref().0.clone()).or_default();
        *count += 1;
        let remedy = "put what belongs together in one";
        let wrong =
            || self.text.error(names.span(), format!("more than {MOST_TIMES} objects name these files"), remedy);
        (*count <= MOST_TIMES).then_some(()).ok_or_else(wrong)
    }

    /// What is in the files that names mean, steps of time of one volume joined.
    pub(super) fn get(&mut self, names: &Spanned<Files>, raw: &RawFiles) -> Result<Vec<Loaded>, LoadError> {
        if raw.voxels.is_some() || raw.particles.is_some() {
            // What is in them may differ each time.
            return self.open(names, raw);
        }
        if let Some((left, found)) = self.kept.get_mut(&names.get_ref().0) {
            *left = left.saturating_sub(1);
            if let Some(found) = if *left == 0 { found.take() } else { found.clone() } {
                return Ok(found);
            }
        }
        let opened = self.open(names, raw)?;
        if let Some((1.., found)) = self.kept.get_mut(&names.get_ref().0) {
            *found = Some(opened.clone());
        }
        Ok(opened)
    }

    fn open(&mut self, names: &Spanned<Files>, raw: &RawFiles) -> Result<Vec<Loaded>, LoadError> {
        let RawFiles { voxels: raw, particles: raw_particles } = raw.clone();
        let options = Options { raw, raw_particles, ..self.options.clone() };
        let mut all = Gathering::new(&options, self.load);
        for name in &names.get_ref().0 {
            if name.starts_with(generate::PREFIX) {
                let part = self.generated(name, names.span())?;
                self.place.get_or_insert(part.place);
                all.add(name.into(), part);
                continue;
            }
            for path in self.find(name, names.span())? {
                if all.defers(&path) {
                    continue;
                }
                let options = Options { place: self.place, ..options.clone() };
                let part = (self.load)(&path, &options)?;
                self.place.get_or_insert(part.place);
                all.add(path, part);
            }
        }
        Ok(all.join().into_iter().map(|joined| joined.loaded).collect())
    }

    /// The files that a name means: regular ones only, since a name could be that of a pipe or a device.
    fn find(&self, name: &str, span: Range<usize>) -> Result<Vec<PathBuf>, LoadError> {
        let missing = || {
            let problem = format!("there is no file \"{}\"", shortened(name));
            self.text.error(span.clone(), problem, "name it as seen from the folder of the scene file")
        };
        if name.is_empty() || name.contains('\0') {
            return Err(missing());
        }
        let path = self.text.file.parent().unwrap_or(Path::new("")).join(name);
        let found = series::expand(&path).map_err(|_| missing())?;
        if found.iter().all(|path| input::is_regular(path)) { Ok(found) } else { Err(missing()) }
    }

    /// A scene that is no file.
    fn generated(&self, name: &str, span: Range<usize>) -> Result<Loaded, LoadError> {
        let scene = match name {
            BUILT_IN => Some(builtin::scene()),
            name if generate::has_memory(name) => generate::generate(name),
            _ => {
                let remedy = "leave it out, or free some memory";
                return Err(self.text.error(span, "there is no memory for this scene", remedy));
            }
        };
        let known: Vec<_> = generate::SCENES.iter().map(|(name, _)| *name).chain([BUILT_IN]).collect();
        let scene = scene
            .ok_or_else(|| self.text.unknown_name(&Spanned::new(span, name.to_owned()), "generated scene", &known))?;
        Ok(Loaded { report: Report::of_scene(&scene), scene, place: Place::default() })
    }
}

/// What scene files call the scene that is shown where no other is asked for.
pub const BUILT_IN: &str = "gen:built-in";
