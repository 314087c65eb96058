//! Objects of particles: what is asked for, and the one place where it becomes geometry.

use toml::Spanned;

use super::keys;
use super::named::{Coloring, Definitions, ascending};
use super::text::Text;
use super::values::point;
use crate::load::LoadError;

/// What a scene file says of particles.
#[derive(Clone, Debug)]
#[allow(dead_code, reason = "objects of particles are not made yet: they are what will read it")]
pub(super) struct Particles {
    /// The files.
    pub(super) files: Spanned<keys::Files>,
    /// The radius of those that have none of their own, in units of the files.
    pub(super) radius: Option<f64>,
    /// The number of the material.
    pub(super) material: Option<u32>,
    /// Attributes, and the values between which particles are shown.
    pub(super) crop: Vec<(String, [f64; 2])>,
    /// Colours that an attribute decides about: of the object, or else of its material.
    pub(super) coloring: Option<Coloring>,
    /// The colour of all; none if `coloring` or the material decides.
    pub(super) color: Option<[f32; 3]>,
    /// How often the box is repeated along each axis.
    pub(super) tile: [usize; 3],
    /// Least and greatest corner of the box in which the particles were computed, in units of the files.
    pub(super) bounds: Option<[[f64; 3]; 2]>,
}

/// What the keys of an object ask for.
pub(super) fn read(text: &Text<'_>, keys: keys::Particles, named: &Definitions) -> Result<Particles, LoadError> {
    let material = keys.material.map(|name| named.find(text, &name)).transpose()?;
    let of_material = material.and_then(|number| named.materials[number as usize].color.clone());
    let (coloring, color) = match keys.color {
        Some(keys::Paint::By(by)) => (Some(named.coloring(text, by)?), None),
        Some(keys::Paint::Plain(color)) => (None, Some(color.0.to_array())),
        None => (of_material, None),
    };
    let crop = keys.crop.into_iter().map(|(name, range)| Ok((name, ascending(text, &range)?)));
    let bounds = keys.bounds.map(|bounds| {
        let [low, high] = bounds.get_ref().map(point);
        let wrong = || text.error(bounds.span(), "this box is empty", "write its least corner first");
        (0..3).all(|axis| low[axis] < high[axis]).then_some([low, high]).ok_or_else(wrong)
    });
    Ok(Particles {
        files: keys.particles,
        radius: keys.radius.map(|radius| radius.0),
        material,
        crop: crop.collect::<Result<_, LoadError>>()?,
        coloring,
        color,
        tile: keys.tile.map_or([1; 3], |tile| tile.map(|count| count.0 as usize)),
        bounds: bounds.transpose()?,
    })
}

/// Adds particles to a scene.
pub(super) fn add(text: &Text<'_>, particles: &Particles) -> Result<(), LoadError> {
    let remedy = "leave this object out";
    Err(text.error(particles.files.span(), "particles in scene files are not shown yet", remedy))
}
