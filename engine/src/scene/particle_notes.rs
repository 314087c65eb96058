//! What people are told of particles: why they cannot be shown, and what was chosen where nobody said anything.

use crate::geometry::TooManyParticles;
use crate::particles::TilingError;
use crate::volume::TransferError;

/// Why particles cannot be shown as somebody asked for.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ParticleError {
    /// They have no such attribute.
    #[error("{particles} has no attribute {name}; there are {known}")]
    NoAttribute {
        /// The particles.
        particles: String,
        /// What was asked for.
        name: String,
        /// What there is.
        known: String,
    },
    /// There is no such step of time.
    #[error("{particles} has {}, from 0; there is no step {step}", counted(*steps))]
    Step {
        /// The particles.
        particles: String,
        /// How many steps they have.
        steps: usize,
        /// Which one was asked for.
        step: usize,
    },
    /// They cannot be repeated.
    #[error("{0} cannot be repeated: {1}")]
    Tiling(String, TilingError),
    /// A step cannot be read: a line that says why.
    #[error("{0}")]
    Read(String),
    /// There are too many.
    #[error("{0}: {1}")]
    TooMany(String, TooManyParticles),
    /// A colour map is none.
    #[error("{0}: {1}")]
    Map(String, TransferError),
    /// An opacity of all is none.
    #[error("{0}: an opacity is from 0 to 1, which {1} is not")]
    Opacity(String, f32),
}

/// What was chosen where nobody said anything.
#[derive(Clone, Debug, PartialEq)]
pub enum ParticleNote {
    /// A radius, in units of the scene.
    Guessed {
        /// The particles.
        particles: String,
        /// The radius.
        radius: f32,
    },
    /// Of an attribute that they are cropped by none has a value that is shown.
    NothingShown {
        /// The particles.
        particles: String,
        /// The attribute.
        attribute: String,
        /// Its least and its greatest value in all steps in memory.
        range: [f32; 2],
    },
    /// Not all steps are in memory.
    NotInMemory {
        /// The particles.
        particles: String,
        /// How many are.
        in_memory: usize,
        /// How many there are.
        steps: usize,
        /// The radius that was guessed of those in memory, in units of the scene.
        radius: Option<f32>,
        /// The attribute that decides about colours, and the values at the ends of the map.
        coloring: Option<(String, [f32; 2])>,
    },
    /// Colours.
    Colored {
        /// The particles.
        particles: String,
        /// The attribute that decides.
        attribute: String,
        /// The values at the ends of the map.
        range: [f32; 2],
        /// The name of the map.
        map: String,
    },
}

fn counted(steps: usize) -> String {
    format!("{steps} step{} of time", if steps == 1 { "" } else { "s" })
}
