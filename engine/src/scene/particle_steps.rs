//! The steps of particles made ready for rays, as they are to be shown: all of them, or those that there is memory for.

use std::sync::Arc;

use super::particle_look::ParticleLook;
use super::particles::ParticleError;
use crate::accel::Build;
use crate::geometry::{Cloud, CloudSeries};
use crate::particles::{Attribute, ParticleStep, Particles, Source, TilingError};

/// The steps of particles: those in memory that fit into it, others are made when they are wanted.
pub(super) fn series(all: Particles, maker: Maker, shown: usize, memory: u64) -> Result<CloudSeries, ParticleError> {
    let Particles { steps, source, .. } = all;
    let mut clouds = Vec::with_capacity(steps.len());
    let mut bytes = 0;
    for (at, step) in steps.into_iter().enumerate() {
        let fits = source.is_none() || (step.is_some() && bytes < memory);
        if !fits && at != shown {
            clouds.push(None);
            continue;
        }
        let cloud = maker.cloud_of(step, source.as_deref(), at)?;
        bytes += cloud.bytes() as u64;
        clouds.push(Some(Arc::new(cloud)));
    }
    if clouds.is_empty() {
        clouds.push(Some(Arc::new(Cloud::empty())));
    }
    Ok(match source.filter(|_| clouds.iter().any(Option::is_none)) {
        Some(source) => {
            let make = move |step| maker.cloud_of(None, Some(&*source), step).map_err(|error| error.to_string());
            CloudSeries::made_when_wanted(clouds, Box::new(make), memory)
        }
        None => CloudSeries::new(clouds.into_iter().flatten().collect()),
    })
}

/// Makes steps ready for rays.
pub(super) struct Maker {
    pub(super) look: ParticleLook,
    /// What people call the particles.
    pub(super) name: String,
    /// Of those that have none.
    pub(super) radius: f32,
    pub(super) build: Build,
}

impl Maker {
    /// The cloud of a step, which is read if it is not in memory.
    pub(super) fn cloud_of(
        &self,
        step: Option<Arc<ParticleStep>>,
        source: Option<&dyn Source>,
        at: usize,
    ) -> Result<Cloud, ParticleError> {
        let mut step = match (step, source) {
            (Some(step), _) => Arc::unwrap_or_clone(step),
            (None, Some(source)) => source.read(at).map_err(ParticleError::Read)?,
            (None, None) => ParticleStep::default(),
        };
        let look = &self.look;
        if let Some(attribute) = &look.radius_by {
            let factor = look.radius.unwrap_or(1.0);
            let radius = |attribute: &Attribute| attribute.values.to_f32().iter().map(|x| x * factor).collect();
            step.radii = step.attribute(attribute).map(radius).unwrap_or_default();
        } else if look.radius.is_some() {
            step.radii.clear();
        }
        let step = tiled(step, look).map_err(|error| ParticleError::Tiling(self.name.clone(), error))?;
        Cloud::new(step, self.radius, &self.build).map_err(|error| ParticleError::TooMany(self.name.clone(), error))
    }
}

fn tiled(mut step: ParticleStep, look: &ParticleLook) -> Result<ParticleStep, TilingError> {
    step.cell = look.cell.or(step.cell);
    match look.tile {
        None => Ok(step),
        Some(times) => step.tiled(times),
    }
}
