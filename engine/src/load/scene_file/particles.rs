//! Objects of particles.

use toml::Spanned;

use super::keys::Paint;
use super::named::{Coloring, Definitions};
use super::object_keys as keys;
use super::text::Text;
use super::values::{Bound, Named, point};
use crate::geometry::{Cropping, OpacityCurve};
use crate::load::{LoadError, RawParticles, VoxelType};
use crate::scene::{ColorBy, OpacityBy, ParticleLook};

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
    /// What is in the files, if they are nothing but numbers.
    pub(super) raw: Option<RawParticles>,
    /// Which particles are shown.
    pub(super) crops: Vec<Cropping>,
    /// How opaque all are, or what opacities by an attribute are multiplied by.
    pub(super) opacity: Option<f32>,
    /// The attribute that decides about opacities.
    pub(super) opacity_by: Option<OpacityBy>,
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
        Some(Paint::By(by)) => (Some(named.coloring(text, by)?), None),
        Some(Paint::Plain(color)) => (None, Some(color.0.to_array())),
        None => (of_material, None),
    };
    let (opacity, opacity_by) = match keys.opacity {
        None => (None, None),
        Some(keys::Opacity::All(part)) => (Some(part.0 as f32), None),
        Some(keys::Opacity::By(by)) => (by.scale.map(|scale| scale.0 as f32), Some(opacity_by(text, by)?)),
    };
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
        raw: keys.raw.map(|raw| self::raw(text, raw)).transpose()?,
        crops: keys.crop.into_iter().map(|(name, ranges)| cropping(text, name, &ranges)).collect::<Result<_, _>>()?,
        opacity,
        opacity_by,
        coloring,
        color,
        tile: keys.tile.map_or([1; 3], |tile| tile.map(|count| count.0 as usize)),
        bounds: bounds.transpose()?,
    })
}

/// Which particles a list of ranges shows; a range may be a single value.
fn cropping(text: &Text<'_>, attribute: String, ranges: &Spanned<keys::Ranges>) -> Result<Cropping, LoadError> {
    let range = |range: &[Bound; 2]| {
        let [low, high] = range.map(|end| end.0);
        let wrong = || text.error(ranges.span(), format!("{high} is not above {low}"), "write the lesser number first");
        (low <= high).then_some([low as f32, high as f32]).ok_or_else(wrong)
    };
    Ok(Cropping { attribute, ranges: ranges.get_ref().0.iter().map(range).collect::<Result<_, _>>()? })
}

fn opacity_by(text: &Text<'_>, keys: keys::OpacityBy) -> Result<OpacityBy, LoadError> {
    let curve = keys.points.map(|points| {
        let singles = points.get_ref().iter().map(|point| point.map(|x| x.0 as f32));
        let remedy = "write [value, opacity], by value, such as [[0, 0.05], [1, 1]]";
        OpacityCurve::new(singles.collect()).map_err(|error| text.error(points.span(), error.to_string(), remedy))
    });
    Ok(OpacityBy { name: keys.by, curve: curve.transpose()? })
}

fn raw(text: &Text<'_>, keys: keys::RawParticles) -> Result<RawParticles, LoadError> {
    let names = keys.layout.get_ref().iter().map(String::as_str);
    let remedy = "write names such as [\"x\", \"y\", \"z\", \"_\", \"speed\"], \"_\" for what is to be left out";
    let columns =
        RawParticles::columns(names).map_err(|error| text.error(keys.layout.span(), error.to_string(), remedy))?;
    let (kind, big_endian) = keys.kind.map_or((VoxelType::F32, false), |Named(raw)| (raw.kind, raw.big_endian));
    Ok(RawParticles { columns, kind, big_endian })
}

impl Particles {
    /// What they are shown as, but for a plain colour; lengths of files are multiplied by `scale`.
    pub(super) fn look(&self, scale: f64) -> ParticleLook {
        let color = match &self.coloring {
            Some(Coloring { by, map, range }) => ColorBy::Attribute {
                name: Some(by.clone()),
                map: map.clone(),
                range: range.map(|range| range.map(|end| end as f32)),
            },
            None if self.color.is_some() || self.material.is_some() => ColorBy::Material,
            None => ColorBy::default(),
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
            crops: self.crops.clone(),
            color,
            opacity: self.opacity,
            opacity_by: self.opacity_by.clone(),
        }
    }
}
