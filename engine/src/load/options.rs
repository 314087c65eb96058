//! How a file is loaded, beside what it says itself.

use std::path::Path;

use super::error::LoadError;
use super::loaded::Loaded;
use super::memory::Memory;
use super::place::Place;
use super::volume::VoxelType;
use crate::progress::Progress;

/// What loads a file.
pub type Load = fn(&Path, &Options) -> Result<Loaded, LoadError>;

/// How a file is loaded.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// The place of another file that is shown with it; `None`: where it finds best.
    pub place: Option<Place>,
    /// Of which voxels a file is full whose name is that of no format.
    pub raw: Option<Raw>,
    /// Of which particles such a file is full.
    pub raw_particles: Option<RawParticles>,
    /// Meshes without normals are [smoothed](crate::geometry::Mesh::smooth) where triangles meet at less than this many degrees; 0: they
    /// keep their facets; `None`: as a scene file says, else [`CREASE_ANGLE`](crate::geometry::CREASE_ANGLE).
    pub smooth: Option<f32>,
    /// How much memory steps of particles may take: see [`Gathering`](super::series::Gathering).
    pub memory: Memory,
    /// Where the bytes are counted that have been read.
    pub progress: Progress,
}

/// What a file of nothing but voxels does not say.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Raw {
    /// Samples along each index of space, the first fastest.
    pub dims: [u64; 3],
    /// Steps of time, one after the other.
    pub steps: u64,
    /// Their type.
    pub kind: VoxelType,
    /// Do voxels start with their most significant byte?
    pub big_endian: bool,
    /// Distances between neighbouring samples.
    pub spacing: [f64; 3],
}

/// What a file of nothing but the numbers of particles does not say.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RawParticles {
    /// The numbers of each particle, by name; `None`: one that is left out.
    pub columns: Vec<Option<String>>,
    /// Their type.
    pub kind: VoxelType,
    /// Do numbers start with their most significant byte?
    pub big_endian: bool,
}

/// Names are not those of the numbers of particles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoLayout {
    /// A name is empty, or has control characters.
    #[error("a name is empty or cannot be printed")]
    Name,
    /// A coordinate is missing.
    #[error("there is no {0}")]
    Axis(&'static str),
}

impl RawParticles {
    /// The columns of these names; `_` is one that is left out.
    ///
    /// # Errors
    /// If a name is none, or x, y or z is missing.
    pub fn columns<'a>(names: impl Iterator<Item = &'a str> + Clone) -> Result<Vec<Option<String>>, NoLayout> {
        if names.clone().any(|name| name.is_empty() || name.contains(char::is_control)) {
            return Err(NoLayout::Name);
        }
        match ["x", "y", "z"].into_iter().find(|axis| !names.clone().any(|name| name == *axis)) {
            Some(axis) => Err(NoLayout::Axis(axis)),
            None => Ok(names.map(|name| (name != "_").then(|| name.to_owned())).collect()),
        }
    }
}
