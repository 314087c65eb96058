//! What people say of particles on the command line.

use std::fmt;

use clap::Args;
use mobula::geometry::OpacityCurve;
use mobula::volume::Preset;

use super::values::{Lengths, Transfer, distance, lengths, transfer};

#[derive(Args, Clone, Debug)]
pub(crate) struct ParticleOptions {
    /// Radius of all particles [default: as files say, or else half of the mean distance of neighbours]
    #[arg(long, help_heading = "Particles", value_name = "R", value_parser = distance)]
    pub(crate) radius: Option<f32>,

    /// The attribute whose values are the radii of particles, multiplied by --radius if that is given
    #[arg(long, help_heading = "Particles", value_name = "ATTRIBUTE")]
    pub(crate) radius_by: Option<String>,

    /// How often particles are repeated along each edge of their periodic box
    #[arg(long, help_heading = "Particles", value_name = "NX,NY,NZ", value_parser = tile)]
    pub(crate) tile: Option<Tile>,

    /// Edges of the periodic box of particles [default: as files say]
    #[arg(long = "box", help_heading = "Particles", value_name = "X,Y,Z", requires = "tile", value_parser = lengths)]
    pub(crate) periodic_box: Option<Lengths>,

    /// The attribute that decides about the colours of particles, or none [default: element, or else the first]
    #[arg(long, help_heading = "Particles", value_name = "ATTRIBUTE")]
    pub(crate) color_by: Option<String>,

    #[arg(long, help_heading = "Particles", value_name = "NAME|FILE", value_parser = transfer, help = format!(
        "Colours of the attribute: {}, labels (a colour for each whole number), elements (those of atoms), or a file as for --transfer \
         [default: viridis; of whole numbers labels]", Preset::NAMES.join(", ")
    ))]
    pub(crate) map: Option<Transfer>,

    /// The values that have the first and the last colour [default: the least and the greatest of all steps]
    #[arg(long, help_heading = "Particles", value_name = "LO,HI", value_parser = range, allow_hyphen_values = true)]
    pub(crate) range: Option<Range>,

    /// Shows only particles whose value of an attribute is from LO to HI, both included, or in another range of the same option; may be
    /// given for several attributes, of which all count
    #[arg(long, help_heading = "Particles", value_name = "ATTRIBUTE=LO,HI[,LO,HI...]", value_parser = crop)]
    pub(crate) crop: Vec<Crop>,

    /// How opaque particles are, from 0 to 1 [default: 1]
    #[arg(long, help_heading = "Particles", value_name = "A", value_parser = opacity)]
    pub(crate) opacity: Option<f32>,

    /// The attribute that decides how opaque particles are, multiplied by --opacity if that is given: values with their opacities,
    /// straight between them [default: from 0 for the least to 1 for the greatest of all steps]
    #[arg(long, help_heading = "Particles", value_name = "ATTRIBUTE[=V:A,V:A...]", value_parser = opacities)]
    pub(crate) opacity_by: Option<Opacities>,
}

/// How often a periodic box is repeated along each of its edges.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Tile(pub(super) [u32; 3]);

pub(super) fn tile(text: &str) -> Result<Tile, String> {
    let numbers: Option<Vec<u32>> = text.split(',').map(|part| part.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[x, y, z]) if x > 0 && y > 0 && z > 0 => Ok(Tile([x, y, z])),
        _ => Err("write three whole numbers above 0 with commas between them, such as 2,2,2".into()),
    }
}

/// From a value to a greater one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Range(pub(super) [f32; 2]);

pub(super) fn range(text: &str) -> Result<Range, String> {
    match ends(text) {
        Some([low, high]) if low < high && low.is_finite() && high.is_finite() => Ok(Range([low, high])),
        _ => Err("write two numbers with a comma between them, the second greater, such as 0,2.5".into()),
    }
}

/// Values of an attribute, both ends included.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Crop {
    pub(super) attribute: String,
    pub(super) ranges: Vec<[f32; 2]>,
}

pub(super) fn crop(text: &str) -> Result<Crop, String> {
    let ranges = |text: &str| -> Option<Vec<[f32; 2]>> {
        let numbers = text.split(',').map(|number| number.trim().parse().ok()).collect::<Option<Vec<f32>>>()?;
        let (pairs, rest) = numbers.as_chunks();
        (rest.is_empty() && pairs.iter().all(|[low, high]| low <= high)).then(|| pairs.to_vec())
    };
    match text.split_once('=').and_then(|(name, text)| Some((name.trim(), ranges(text)?))) {
        Some((name, ranges)) if !name.is_empty() => Ok(Crop { attribute: name.to_owned(), ranges }),
        _ => {
            Err("write a name, = and two numbers with a comma between them, such as speed=0.1,9; inf is a number"
                .into())
        }
    }
}

/// An attribute that decides how opaque particles are, and the opacities of its values.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Opacities {
    pub(super) attribute: String,
    pub(super) curve: Option<OpacityCurve>,
}

pub(super) fn opacities(text: &str) -> Result<Opacities, String> {
    let example = "write a name, or a name, = and values with their opacities, such as heat=0:0.05,90:1";
    let (name, points) = text.split_once('=').map_or((text, None), |(name, points)| (name, Some(points)));
    let point = |text: &str| -> Option<[f32; 2]> {
        let (value, opacity) = text.split_once(':')?;
        Some([value.trim().parse().ok()?, opacity.trim().parse().ok()?])
    };
    let curve = |text: &str| {
        let points: Option<_> = text.split(',').map(point).collect();
        OpacityCurve::new(points.ok_or(example)?).map_err(|error| error.to_string())
    };
    match name.trim() {
        "" => Err(example.to_owned()),
        name => Ok(Opacities { attribute: name.to_owned(), curve: points.map(curve).transpose()? }),
    }
}

impl fmt::Display for Opacities {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.attribute)?;
        for (i, [value, opacity]) in self.curve.iter().flat_map(OpacityCurve::points).enumerate() {
            write!(f, "{}{value}:{opacity}", if i == 0 { '=' } else { ',' })?;
        }
        Ok(())
    }
}

pub(super) fn opacity(text: &str) -> Result<f32, String> {
    let opacity = text.trim().parse().ok().filter(|opacity| (0.0..=1.0).contains(opacity));
    opacity.ok_or_else(|| "write a number from 0 to 1 (opaque)".into())
}

fn ends(text: &str) -> Option<[f32; 2]> {
    let (low, high) = text.split_once(',')?;
    Some([low.trim().parse().ok()?, high.trim().parse().ok()?])
}

impl ParticleOptions {
    /// Those that say which attribute decides about colours, and how, as names and values.
    #[cfg(feature = "window")]
    pub(crate) fn color_words(&self) -> impl Iterator<Item = (&'static str, String)> {
        let map = self.map.as_ref().map(Transfer::to_string);
        let words =
            [("color-by", self.color_by.clone()), ("map", map), ("range", self.range.map(|Range(ends)| joined(&ends)))];
        words.into_iter().filter_map(|(name, value)| Some((name, value?)))
    }

    /// The others, as names and values.
    #[cfg(feature = "window")]
    pub(crate) fn words(&self) -> Vec<(&'static str, String)> {
        let Self { radius, radius_by, tile, periodic_box, crop, opacity, opacity_by, .. } = self;
        let mut words = Vec::new();
        let mut option = |name, value: Option<String>| words.extend(value.map(|value| (name, value)));
        option("radius", radius.map(|radius| radius.to_string()));
        option("radius-by", radius_by.clone());
        option("tile", tile.map(|Tile(times)| joined(&times)));
        option("box", periodic_box.map(|Lengths(sides)| joined(&sides)));
        for Crop { attribute, ranges } in crop {
            option("crop", Some(format!("{attribute}={}", joined(ranges.as_flattened()))));
        }
        option("opacity", opacity.map(|opacity| opacity.to_string()));
        option("opacity-by", opacity_by.as_ref().map(Opacities::to_string));
        words
    }
}

#[cfg(feature = "window")]
fn joined(numbers: &[impl fmt::Display]) -> String {
    numbers.iter().map(ToString::to_string).collect::<Vec<_>>().join(",")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_of_options_are_checked() {
        assert_eq!(tile("2, 1,3"), Ok(Tile([2, 1, 3])));
        for bad in ["", "2", "2,2", "0,1,1", "-1,1,1", "1,1,1.5", "1,1,99999999999"] {
            assert!(tile(bad).is_err(), "{bad}");
        }
        for text in ["heat", "heat=0:0.05,90:1", "heat=-1.5:0", "heat=0:1,0:0"] {
            assert_eq!(opacities(text).unwrap().to_string(), text);
        }
        for (bad, expected) in [
            ("", "such as heat="),
            ("=0:1", "such as heat="),
            ("heat=", "such as heat="),
            ("heat=0,1", "such as heat="),
            ("heat=1:1,0:1", "the value of point 2 is below the one before"),
            ("heat=0:1,nan:1", "the value of point 2 is not finite"),
            ("heat=0:1.5", "the opacity of point 1 is not from 0 to 1"),
            ("heat=0:nan", "the opacity of point 1 is not from 0 to 1"),
        ] {
            assert!(opacities(bad).unwrap_err().contains(expected), "{bad}: {:?}", opacities(bad));
        }
        assert_eq!(opacity("0.25"), Ok(0.25));
        for bad in ["", "-0.1", "1.1", "nan", "half"] {
            assert!(opacity(bad).is_err(), "{bad}");
        }
    }
}
