//! Steps of time that are read when they are wanted.

use std::fmt::Debug;

use super::ParticleStep;

/// Reads steps of time when they are wanted: where there is no memory for all.
pub trait Source: Debug + Send + Sync {
    /// Reads a step, from 0. It has what each particle of the other steps has.
    ///
    /// # Errors
    /// If it cannot be read: a line for people.
    fn read(&self, step: usize) -> Result<ParticleStep, String>;
}
