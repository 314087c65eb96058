//! Particles from files, good and broken: what is loaded, and what is said about the rest.

#[path = "support/files.rs"]
mod files;
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
#[path = "load_particles/streamed.rs"]
mod streamed;
#[path = "load_particles/tables.rs"]
mod tables;

use std::sync::Arc;

use mobula::load::Loaded;
use mobula::particles::{ParticleStep, Particles};

use files::{Folder, gzip};

impl Folder {
    /// The particles of a sound file, about which nothing is said.
    fn particles(&self, name: &str, bytes: impl AsRef<[u8]>) -> Particles {
        let loaded = self.load(name, bytes).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(loaded.report.warnings, [""; 0]);
        only_particles(&loaded).clone()
    }

    /// The only step of a sound file.
    fn step(&self, name: &str, bytes: impl AsRef<[u8]>) -> Arc<ParticleStep> {
        let [step] = steps(&self.particles(name, bytes));
        step
    }
}

fn only_particles(loaded: &Loaded) -> &Particles {
    assert!(loaded.scene.geometry.is_empty() && loaded.scene.volumes.is_empty());
    let [particles] = &loaded.scene.particles[..] else { panic!("{:?}", loaded.scene.particles) };
    let census = &loaded.report.census;
    assert_eq!(particles.count() as u64, census.count("particles") - census.left_out());
    for step in particles.read() {
        let count = step.centers.len();
        assert!(step.radii.is_empty() || step.radii.len() == count);
        assert!(step.attributes.iter().all(|attribute| attribute.values.len() == count));
        assert!(step.centers.iter().flatten().all(|x| x.is_finite()));
    }
    particles
}

/// All steps, which are so many.
fn steps<const N: usize>(particles: &Particles) -> [Arc<ParticleStep>; N] {
    let all: Vec<_> = particles.read().cloned().collect();
    all.try_into().expect("so many steps")
}

/// Names and types of all attributes.
fn kinds(step: &ParticleStep) -> Vec<(&str, &'static str)> {
    step.kinds()
}

/// The values of an attribute.
fn values(step: &ParticleStep, name: &str) -> Vec<f32> {
    step.attribute(name).unwrap_or_else(|| panic!("no {name}: {:?}", kinds(step))).values.to_f32().into_owned()
}
