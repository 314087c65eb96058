//! The steps of particles made ready for rays, as they are to be shown: all of them, or those that there is memory for.

use std::sync::Arc;

use glam::Vec3;
use mobula_core::kernel::sphere::RADII;

use super::particle_look::ParticleLook;
use super::particle_notes::ParticleError;
use crate::accel::Build;
use crate::geometry::{Cloud, CloudSeries};
use crate::particles::{Attribute, ParticleStep, Particles};

/// So many particles show how far all reach, before they are repeated.
const SAMPLE: usize = 10_000;

/// The steps of particles: those in memory that fit into it, among them the one that is shown; others are made when they are wanted.
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
        let cloud = maker.cloud_of(Arc::unwrap_or_clone(step.unwrap_or_default()))?;
        bytes += cloud.bytes() as u64;
        clouds.push(Some(Arc::new(cloud)));
    }
    if clouds.is_empty() {
        clouds.push(Some(Arc::new(Cloud::empty())));
    }
    Ok(match source.filter(|_| clouds.iter().any(Option::is_none)) {
        Some(source) => {
            let make = move |step| maker.cloud_of(source.read(step)?).map_err(|error| error.to_string());
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
    /// The cloud of a step.
    pub(super) fn cloud_of(&self, step: ParticleStep) -> Result<Cloud, ParticleError> {
        let cloud = Cloud::new(self.ready(step)?, self.radius, &self.build);
        cloud.map_err(|error| ParticleError::TooMany(self.name.clone(), error))
    }

    /// Some of the particles of all steps in memory: they show how far these reach.
    pub(super) fn reach(&self, all: &Particles) -> Result<Vec<(Vec3, f32)>, ParticleError> {
        let each = (SAMPLE / all.read().count().max(1)).max(100);
        let mut reach = Vec::new();
        for step in all.read() {
            let some = self.ready(step.sampled(each))?;
            let radius = |i: usize| some.radii.get(i).copied().unwrap_or(self.radius);
            reach.extend(some.centers.iter().enumerate().map(|(i, &center)| (center.into(), radius(i))));
        }
        reach.retain(|(center, radius): &(Vec3, f32)| center.is_finite() && RADII.contains(radius));
        Ok(reach)
    }

    /// With the radii that are asked for, and repeated as often.
    fn ready(&self, mut step: ParticleStep) -> Result<ParticleStep, ParticleError> {
        let ParticleLook { radius, radius_by, tile, cell, .. } = &self.look;
        if let Some(attribute) = radius_by {
            let factor = radius.unwrap_or(1.0);
            let radius = |attribute: &Attribute| attribute.values.to_f32().iter().map(|x| x * factor).collect();
            step.radii = step.attribute(attribute).map(radius).unwrap_or_default();
        } else if radius.is_some() {
            step.radii.clear();
        }
        step.cell = cell.or(step.cell);
        let Some(times) = *tile else { return Ok(step) };
        step.tiled(times).map_err(|error| ParticleError::Tiling(self.name.clone(), error))
    }
}
