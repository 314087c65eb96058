//! Objects of particles.

use toml::Spanned;

use super::keys;
use super::named::{Coloring, Definitions, ascending};
use super::text::Text;
use super::values::point;
use crate::geometry::Cropping;
use crate::load::LoadError;
use crate::scene::{ColorBy, ParticleLook};

/// What a scene file says of particles.
#[derive(Clone, Debug)]
pub(super) struct Particles {
    /// The files.
    pub(super) files: Spanned<keys::Files>,
    /// The radius of those that have none of their own, in units of the files.
    pub(super) radius: Option<f64>,
    /// The attribute whose values are the radii, multiplied by `radius`.
    pub(super) radius_by: Option<String>,
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
    let crop = keys.crop.into_iter().map(|(name, range)| {
        let [low, high] = range.get_ref().map(|x| x.0);
        // A single value is a range.
        Ok((name, if low == high { [low, high] } else { ascending(text, &range)? }))
    });
    let bounds = keys.bounds.map(|bounds| {
        let [low, high] = bounds.get_ref().map(point);
        let wrong = || text.error(bounds.span(), "this box is empty", "write its least corner first");
        (0..3).all(|axis| low[axis] < high[axis]).then_some([low, high]).ok_or_else(wrong)
    });
    Ok(Particles {
        files: keys.particles,
        radius: keys.radius.map(|radius| radius.0),
        radius_by: keys.radius_by,
        material,
        crop: crop.collect::<Result<_, LoadError>>()?,
        coloring,
        color,
        tile: keys.tile.map_or([1; 3], |tile| tile.map(|count| count.0 as usize)),
        bounds: bounds.transpose()?,
    })
}

impl Particles {
    /// What they are shown as, but for a plain colour; lengths of files are multiplied by `scale`.
    pub(super) fn look(&self, scale: f64) -> ParticleLook {
        let crop = |(attribute, range): &(String, [f64; 2])| Cropping {
            attribute: attribute.clone(),
            ranges: vec![range.map(|end| end as f32)],
        };
        let color = match &self.coloring {
            Some(Coloring { by, map, range }) => ColorBy::Attribute {
                name: by.clone(),
                map: map.clone(),
                range: range.map(|range| range.map(|end| end as f32)),
            },
            None if self.color.is_some() || self.material.is_some() => ColorBy::Material,
            None => ColorBy::Auto,
        };
        let cell = |[low, high]: [[f64; 3]; 2]| {
            let side = |axis: usize| ((high[axis] - low[axis]) * scale) as f32;
            [[side(0), 0.0, 0.0], [0.0, side(1), 0.0], [0.0, 0.0, side(2)]]
        };
        ParticleLook {
            radius: self.radius.or(self.radius_by.as_ref().map(|_| 1.0)).map(|radius| (radius * scale) as f32),
            radius_by: self.radius_by.clone(),
            tile: (self.tile != [1; 3]).then(|| self.tile.map(|times| times.min(u32::MAX as usize) as u32)),
            cell: self.bounds.map(cell),
            material: self.material,
            crops: self.crop.iter().map(crop).collect(),
            color,
            opacity: None,
            opacity_by: None,
        }
    }
}
