//! Particles from files, good and broken: what is loaded, and what is said about the rest.

#[path = "load_particles/hostile.rs"]
mod hostile;
#[path = "load_particles/mesh.rs"]
mod mesh;
#[path = "load_particles/ply.rs"]
mod ply;
#[path = "load_particles/raw.rs"]
mod raw;
#[path = "load_particles/real.rs"]
mod real;
#[path = "load_particles/tables.rs"]
mod tables;

use std::fs;
use std::io::Write as _;
use std::path::PathBuf;
use std::sync::Arc;

use mobula::load::{LoadError, Loaded, load};
use mobula::particles::{ParticleStep, Particles};

/// A folder of its own for each test, removed at its end.
struct Folder(PathBuf);

impl Folder {
    fn new(test: &str) -> Self {
        // In memory where there is such a file system: thousands of small files are written.
        let memory = PathBuf::from("/dev/shm");
        let base = if memory.is_dir() { memory } else { std::env::temp_dir() };
        let path = base.join(format!("mobula-particles-{test}-{}", std::process::id()));
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.join(name);
        fs::write(&path, bytes).unwrap();
        path
    }

    fn load(&self, name: &str, bytes: impl AsRef<[u8]>) -> Result<Loaded, LoadError> {
        load(&self.write(name, bytes))
    }

    /// The particles of a sound file, about which nothing is said.
    fn particles(&self, name: &str, bytes: impl AsRef<[u8]>) -> Particles {
        let loaded = self.load(name, bytes).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(loaded.report.warnings, [""; 0]);
        only_particles(&loaded).clone()
    }

    /// The only step of a sound file.
    fn step(&self, name: &str, bytes: impl AsRef<[u8]>) -> Arc<ParticleStep> {
        let [step] = &self.particles(name, bytes).steps[..] else { panic!("several steps") };
        Arc::clone(step)
    }

    /// The error of a broken file, without its folder.
    fn complaint(&self, name: &str, bytes: impl AsRef<[u8]>) -> String {
        let text = self.load(name, bytes).map(|loaded| loaded.report).expect_err("loaded").to_string();
        assert!(!text.contains('\n'), "more than a line: {text}");
        text.strip_prefix(&format!("{}/", self.0.display())).expect("no path").to_owned()
    }

    /// What people are told of a file that loads.
    fn warning(&self, name: &str, bytes: impl AsRef<[u8]>) -> String {
        let warnings = self.load(name, bytes).unwrap().report.warnings;
        let [warning] = &warnings[..] else { panic!("{warnings:?}") };
        warning.strip_prefix(&format!("{}/", self.0.display())).expect("no path").to_owned()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn only_particles(loaded: &Loaded) -> &Particles {
    assert!(loaded.scene.geometry.is_empty() && loaded.scene.volumes.is_empty());
    let [particles] = &loaded.scene.particles[..] else { panic!("{:?}", loaded.scene.particles) };
    let census = &loaded.report.census;
    assert_eq!(particles.count() as u64, census.count("particles") - census.left_out());
    for step in &particles.steps {
        let count = step.centers.len();
        assert!(step.radii.is_empty() || step.radii.len() == count);
        assert!(step.attributes.iter().all(|attribute| attribute.values.len() == count));
        assert!(step.centers.iter().flatten().all(|x| x.is_finite()));
    }
    particles
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut packer = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
    packer.write_all(bytes).unwrap();
    packer.finish().unwrap()
}

/// Names and types of all attributes.
fn kinds(step: &ParticleStep) -> Vec<(&str, &'static str)> {
    step.kinds()
}

/// The values of an attribute.
fn values(step: &ParticleStep, name: &str) -> Vec<f32> {
    step.attribute(name).unwrap_or_else(|| panic!("no {name}: {:?}", kinds(step))).values.to_f32().into_owned()
}
