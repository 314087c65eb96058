//! Files of volumes, of particles, or of meshes, whose names differ only in a number: the steps of time of one.
//!
//! | file | idea |
//! |---|---|
//! | `names` | the files that a pattern means; the number in which names differ |
//! | `source` | steps of particles that are read when they are wanted |

mod names;
mod source;

use std::any::Any;
use std::mem;
use std::path::{Path, PathBuf};
use std::sync::Arc;

pub use names::expand;
use names::{Part, differ_at, name, numbered};
use source::Files;

use super::{Load, Loaded, Options};
use crate::geometry::{Census, Mesh, MeshSequence};
use crate::particles::Particles;
use crate::scene::SceneDescription;
use crate::volume::Grid;

/// What was loaded, and from which files: several are the steps of time of one volume, or of the same particles.
#[derive(Clone, Debug)]
pub struct Joined {
    /// The files, in the order of their numbers.
    pub files: Vec<PathBuf>,
    /// What is in them.
    pub loaded: Loaded,
}

/// Files that are shown together, of which one after the other is loaded: those are joined that are the steps of time of one volume, or
/// of the same particles. Their names differ only in a number, and their grids have the same sides, places and types, or their particles
/// the same attributes. Others stay what they are.
#[derive(Debug)]
pub struct Gathering<'a> {
    options: &'a Options,
    load: Load,
    list: Vec<Series>,
}

/// Files of one series.
#[derive(Debug)]
struct Series {
    /// The parts of the first name.
    parts: Vec<Part>,
    /// Where names differ, once there are two.
    at: Option<usize>,
    files: Vec<(Vec<Part>, PathBuf, Option<Loaded>)>,
}

impl<'a> Gathering<'a> {
    /// Nothing yet. Files are loaded with these options, by `load`, as are those that are read later.
    pub fn new(options: &'a Options, load: Load) -> Self {
        Self { options, load, list: Vec::new() }
    }

    /// Need a file not be loaded? That is so where there is [no memory](Options::memory) left and its name is that of a further step of
    /// particles: then it is read when it is shown.
    pub fn defers(&mut self, file: &Path) -> bool {
        if !self.options.memory.is_full() {
            return false;
        }
        let parts = numbered(&file.to_string_lossy());
        let fits = |series: &mut Series| series.is_of_steps() && series.admits(&parts);
        let Some(at) = self.list.iter_mut().position(fits) else { return false };
        self.list[at].push(parts, file.to_owned(), None);
        true
    }

    /// Adds what is in a file.
    pub fn add(&mut self, file: PathBuf, loaded: Loaded) {
        // A scene file has counted its own.
        if loaded.scene.objects.is_empty() {
            let steps = loaded.scene.particles.iter().flat_map(Particles::read);
            self.options.memory.take(steps.map(|step| step.bytes_shown()).sum());
        }
        let parts = numbered(&file.to_string_lossy());
        let fits = |series: &mut Series| series.admits(&parts) && alike(series.first(), &loaded);
        let at = self.list.iter_mut().position(fits).unwrap_or(self.list.len());
        if at == self.list.len() {
            self.list.push(Series { parts: parts.clone(), at: None, files: Vec::new() });
        }
        self.list[at].push(parts, file, Some(loaded));
    }

    /// A scene for each series.
    pub fn join(self) -> Vec<Joined> {
        self.list.into_iter().map(|series| series.join(self.options, self.load)).collect()
    }
}

/// Are both one volume of the same samples, or particles with the same attributes, and nothing else?
fn alike(a: &Loaded, b: &Loaded) -> bool {
    let parts = |loaded: &Loaded| {
        let SceneDescription { geometry, volumes, particles, .. } = &loaded.scene;
        (geometry.len(), volumes.len(), particles.len())
    };
    // What a scene file puts together is more than that.
    if [a, b].iter().any(|one| !one.scene.shown.is_empty() || !one.scene.particle_looks.is_empty()) {
        return false;
    }
    match (parts(a), parts(b)) {
        ((0, 1, 0), (0, 1, 0)) => {
            let grid = |loaded: &Loaded| loaded.scene.volumes.first()?.steps.first().cloned();
            let samples = |grid: Arc<Grid>| (grid.dims(), *grid.place(), grid.voxels().type_name());
            grid(a).map(samples) == grid(b).map(samples)
        }
        ((0, 0, 1), (0, 0, 1)) => {
            let sample = |loaded: &Loaded| loaded.scene.particles.first()?.sample().cloned();
            sample(a).zip(sample(b)).is_some_and(|(a, b)| a.goes_with(&b))
        }
        // Of the same triangles. Parts of a machine may be alike, too, but are not at the same place.
        ((1, 0, 0), (1, 0, 0)) => {
            let [a_mesh, b_mesh] = [a, b].map(|loaded| loaded.scene.geometry[0].downcast_ref::<Mesh>());
            let same = |(a, b): (&Mesh, &Mesh)| a.triangles == b.triangles && a.materials == b.materials;
            a_mesh.zip(b_mesh).is_some_and(same) && overlap(a, b)
        }
        _ => false,
    }
}

/// Do the bounds of two files have a common part?
fn overlap(a: &Loaded, b: &Loaded) -> bool {
    a.report.bounds().zip(b.report.bounds()).is_some_and(|([low, high], [other_low, other_high])| {
        (0..3).all(|axis| low[axis].max(other_low[axis]) <= high[axis].min(other_high[axis]))
    })
}

/// Takes the only mesh out of what was loaded.
fn take_mesh(loaded: &mut Loaded) -> Option<Mesh> {
    let mut geometry = loaded.scene.geometry.pop()?;
    match Arc::get_mut(&mut geometry) {
        Some(own) => (own as &mut dyn Any).downcast_mut::<Mesh>().map(mem::take),
        // Somebody else has it, too.
        None => geometry.downcast_ref::<Mesh>().cloned(),
    }
}

impl Series {
    /// What was loaded first.
    fn first(&self) -> &Loaded {
        self.loaded().next().expect("a series starts with what was loaded")
    }

    fn loaded(&self) -> impl Iterator<Item = &Loaded> {
        self.files.iter().filter_map(|(_, _, loaded)| loaded.as_ref())
    }

    /// Is each file a step of particles?
    fn is_of_steps(&self) -> bool {
        self.loaded().all(|one| matches!(&one.scene.particles[..], [particles] if particles.steps.len() == 1))
    }

    /// Does a name differ from those of the files in their number only?
    fn admits(&self, parts: &[Part]) -> bool {
        differ_at(&self.parts, parts).is_some_and(|at| self.at.is_none_or(|there| there == at))
    }

    fn push(&mut self, parts: Vec<Part>, file: PathBuf, loaded: Option<Loaded>) {
        self.at = self.at.or(differ_at(&self.parts, &parts));
        self.files.push((parts, file, loaded));
    }

    /// One scene of all files, in the order of their numbers.
    fn join(mut self, options: &Options, load: Load) -> Joined {
        self.files.sort_by(|(a, ..), (b, ..)| a.cmp(b));
        let in_steps = self.is_of_steps();
        let files: Vec<PathBuf> = self.files.iter().map(|(_, file, _)| file.clone()).collect();
        let (mut steps, mut meshes) = (Vec::new(), Vec::new());
        let mut joined: Option<Loaded> = None;
        for (_, _, loaded) in self.files {
            let Some(mut loaded) = loaded else {
                steps.push(None);
                continue;
            };
            if let [particles] = &mut loaded.scene.particles[..] {
                steps.append(&mut particles.steps);
            }
            match &mut joined {
                None => joined = Some(loaded),
                Some(joined) => {
                    for (all, volume) in joined.scene.volumes.iter_mut().zip(loaded.scene.volumes.drain(..)) {
                        all.steps.extend(volume.steps);
                    }
                    if let Some(mesh) = take_mesh(&mut loaded) {
                        meshes.push(mesh);
                        // The same triangles as before, elsewhere.
                        let bounds = loaded.report.census.bounds;
                        loaded.report.census = Census::default().within(bounds);
                    }
                    joined.report.merge(loaded.report);
                }
            }
        }
        let mut loaded = joined.expect("a series starts with what was loaded");
        if !meshes.is_empty() {
            let all = take_mesh(&mut loaded).into_iter().chain(meshes).collect();
            loaded.scene.geometry.extend(MeshSequence::new(all).map(|meshes| Arc::new(meshes) as _));
        }
        let name = (files.len() > 1).then(|| name(&self.parts, self.at));
        if let [particles] = &mut loaded.scene.particles[..] {
            particles.steps = steps;
            particles.unify();
            if in_steps && files.len() > 1 {
                particles.source = Some(Arc::new(Files::new(files.clone(), particles, loaded.place, options, load)));
            }
        }
        if let Some(name) = name {
            loaded.scene.volumes.iter_mut().for_each(|volume| volume.name.clone_from(&name));
            loaded.scene.particles.iter_mut().for_each(|particles| particles.name.clone_from(&name));
            loaded.scene.name = name;
        }
        Joined { files, loaded }
    }
}
