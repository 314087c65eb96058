//! The particles of one step of time, made ready for rays: spheres in a tree, with the ranges of their attributes.

use glam::Vec3;
use mobula_core::bvh::Quality;
use mobula_core::cloud;

use super::census::{Census, Item};
use crate::accel::{AccelerationKind, Build, Pool};
use crate::particles::{Attribute, ParticleStep};

/// The particles of one step, which nothing else holds: what is shown of them, and how, may change at any time.
#[derive(Debug)]
pub struct Cloud {
    pub(super) spheres: cloud::Cloud,
    /// The names of the attributes.
    names: Vec<String>,
    census: Census,
    /// Is every sphere tried, without the tree?
    pub(super) all: bool,
}

const PARTICLES: Item = Item::primitives("particles", "particle", "particles");
const LEFT_OUT: Item = Item::left_out(
    "bad_particles",
    "particle that is not finite or has a radius below 1e-18 or above 9e18",
    "particles that are not finite or have a radius below 1e-18 or above 9e18",
);

/// More particles in a step than there are numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0} particles in a step of time: more than there are numbers")]
pub struct TooManyParticles(pub usize);

impl Cloud {
    /// Of a step; particles that have no radius get one.
    ///
    /// # Errors
    /// If there are too many.
    pub fn new(step: ParticleStep, radius: f32, build: &Build) -> Result<Self, TooManyParticles> {
        let ParticleStep { centers, radii, attributes, .. } = step;
        let count = centers.len();
        if count >= u32::MAX as usize - 4 {
            return Err(TooManyParticles(count));
        }
        let sphere = |i: usize| {
            let [x, y, z] = centers[i];
            [x, y, z, radii.get(i).copied().unwrap_or(radius)]
        };
        let quality = if build.kind == AccelerationKind::Bvh { Quality::Good } else { Quality::Fast };
        let (names, values) = attributes.into_iter().map(|Attribute { name, values }| (name, values)).unzip();
        let join = Pool(&build.progress);
        let spheres = Pool::enter(|| cloud::Cloud::build(count, quality, &join, sphere, values));
        let mut census = Census::default();
        census.add(PARTICLES, count as u64);
        if spheres.len() < count {
            census.add(LEFT_OUT, (count - spheres.len()) as u64);
        }
        if let Some(bounds) = spheres.bounds() {
            for [x, y, z, _] in [bounds.low, bounds.high] {
                census.include(Vec3::new(x, y, z), 0.0);
            }
        }
        let all = build.kind == AccelerationKind::Brute;
        Ok(Self { spheres, names, census, all })
    }

    /// Without particles.
    pub fn empty() -> Self {
        Self::new(ParticleStep::default(), 1.0, &AccelerationKind::Bvh.into()).expect("no particles are not too many")
    }

    /// What was counted and left out.
    pub fn census(&self) -> &Census {
        &self.census
    }

    /// The names of the attributes.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The number of the attribute of a name.
    pub fn attribute(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|known| known == name)
    }

    /// The least and the greatest finite value of an attribute.
    pub fn range(&self, attribute: usize) -> Option<[f32; 2]> {
        self.spheres.range(attribute)
    }

    /// Bytes that it occupies.
    pub fn bytes(&self) -> usize {
        self.spheres.bytes()
    }

    /// Centre and radius of a sphere.
    #[inline(always)]
    pub(super) fn sphere(&self, place: usize) -> Option<(Vec3, f32)> {
        self.spheres.sphere(place).map(|[x, y, z, radius]| (Vec3::new(x, y, z), radius))
    }
}
