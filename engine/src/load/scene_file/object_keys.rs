//! Which keys objects have, and what stands behind them.

use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;

use serde::Deserialize;
use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{Deserializer, Error, IntoDeserializer, MapAccess, SeqAccess, Unexpected, Visitor};
use toml::Spanned;

use super::keys::{Paint, either};
use super::values::{Bound, Count, Named, Number, Part, Point, Positive, Repeats, Single, StepLength};
use crate::load::VoxelType;

/// A file, or several.
#[derive(Clone, Debug)]
pub(super) struct Files(pub(super) Vec<String>);

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Mesh {
    pub(super) mesh: Spanned<Files>,
    pub(super) material: Option<Spanned<String>>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Spheres {
    /// Centre and radius.
    pub(super) spheres: Vec<(Single, Single, Single, Positive)>,
    pub(super) material: Option<Spanned<String>>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Particles {
    pub(super) particles: Spanned<Files>,
    pub(super) radius: Option<Positive>,
    pub(super) radius_by: Option<String>,
    pub(super) material: Option<Spanned<String>>,
    #[serde(default)]
    pub(super) crop: BTreeMap<String, Spanned<Ranges>>,
    pub(super) color: Option<Paint>,
    pub(super) opacity: Option<Opacity>,
    pub(super) raw: Option<RawParticles>,
    pub(super) tile: Option<[Repeats; 3]>,
    #[serde(rename = "box")]
    pub(super) bounds: Option<Spanned<[Point; 2]>>,
}

/// Values that are shown: one range, or several.
#[derive(Clone, Debug)]
pub(super) struct Ranges(pub(super) Vec<[Bound; 2]>);

/// What ranges are written as.
#[derive(Clone, Copy, Debug)]
enum InRanges {
    End(Bound),
    Range([Bound; 2]),
}

/// How opaque particles are: all alike, or as an attribute says.
#[derive(Clone, Debug)]
pub(super) enum Opacity {
    All(Part),
    By(OpacityBy),
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct OpacityBy {
    pub(super) by: String,
    /// Values and their opacities.
    pub(super) points: Option<Spanned<Vec<[Number; 2]>>>,
    /// What these are multiplied by.
    pub(super) scale: Option<Part>,
}

/// What a file of nothing but the numbers of particles does not say.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawParticles {
    pub(super) layout: Spanned<Vec<String>>,
    #[serde(rename = "type")]
    pub(super) kind: Option<Named<RawType>>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Volume {
    pub(super) volume: Spanned<Files>,
    pub(super) raw: Option<Raw>,
    pub(super) transfer: Option<Spanned<String>>,
    pub(super) window: Option<(Number, Positive)>,
    pub(super) shading: Option<Named<Shading>>,
    pub(super) step_length: Option<StepLength>,
    pub(super) iso: Option<Vec<Iso>>,
    pub(super) cut: Option<Vec<Spanned<[Single; 4]>>>,
    pub(super) origin: Option<Point>,
}

impl Volume {
    /// Does it say anything of what the volume is shown as?
    pub(super) fn says_how(&self) -> bool {
        let Self { volume: _, raw: _, transfer, window, shading, step_length, iso, cut, origin } = self;
        let medium = transfer.is_some() || window.is_some() || shading.is_some() || step_length.is_some();
        medium || iso.is_some() || cut.is_some() || origin.is_some()
    }
}

/// What a file of nothing but voxels does not say.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Raw {
    pub(super) dims: [Count; 3],
    pub(super) steps: Option<Count>,
    #[serde(rename = "type")]
    pub(super) kind: Named<RawType>,
    pub(super) spacing: Option<[Positive; 3]>,
}

/// A type of voxels, and whether their most significant byte is first.
#[derive(Clone, Copy, Debug)]
pub(super) struct RawType {
    pub(super) kind: VoxelType,
    pub(super) big_endian: bool,
}

impl FromStr for RawType {
    type Err = crate::load::NoVoxelType;
    fn from_str(word: &str) -> Result<Self, Self::Err> {
        let lower = word.to_ascii_lowercase();
        let (name, big_endian) = match lower.strip_suffix("be") {
            Some(name) => (name, true),
            None => (lower.strip_suffix("le").unwrap_or(&lower), false),
        };
        Ok(Self { kind: name.parse()?, big_endian })
    }
}

/// When media of volumes are lit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shading {
    Auto,
    On,
    Off,
}

impl FromStr for Shading {
    type Err = &'static str;
    fn from_str(word: &str) -> Result<Self, Self::Err> {
        match word {
            "auto" => Ok(Self::Auto),
            "on" => Ok(Self::On),
            "off" => Ok(Self::Off),
            _ => Err("write auto, on or off"),
        }
    }
}

/// An iso-surface: its value, or more.
#[derive(Clone, Debug)]
pub(super) struct Iso(pub(super) IsoKeys);

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct IsoKeys {
    pub(super) value: Number,
    pub(super) material: Option<Spanned<String>>,
    pub(super) transparent: Option<Part>,
}

either! {
    Files = "the name of a file between quotes, or a list of them" {
        fn visit_str<E: Error>(self, name: &str) -> Result<Files, E> {
            Ok(Files(vec![name.to_owned()]))
        }
        fn visit_seq<A: SeqAccess<'de>>(self, seq: A) -> Result<Files, A::Error> {
            Deserialize::deserialize(SeqAccessDeserializer::new(seq)).map(Files)
        }
    }
    Iso = "a value, or a table with value, material and transparent" {
        fn visit_i64<E: Error>(self, value: i64) -> Result<Iso, E> {
            Ok(plain_iso(value as f64))
        }
        fn visit_f64<E: Error>(self, value: f64) -> Result<Iso, E> {
            let finite = value.is_finite().then(|| plain_iso(value));
            finite.ok_or_else(|| E::invalid_value(Unexpected::Float(value), &self))
        }
        fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Iso, A::Error> {
            Deserialize::deserialize(MapAccessDeserializer::new(map)).map(Iso)
        }
    }
    Ranges = "a range such as [0.1, 9], or a list of ranges" {
        fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Ranges, A::Error> {
            let (mut ends, mut ranges) = (Vec::new(), Vec::new());
            while let Some(next) = seq.next_element()? {
                match next {
                    InRanges::End(end) => ends.push(end),
                    InRanges::Range(range) => ranges.push(range),
                }
            }
            match ends[..] {
                [] if !ranges.is_empty() => Ok(Ranges(ranges)),
                [low, high] if ranges.is_empty() => Ok(Ranges(vec![[low, high]])),
                _ => Err(A::Error::invalid_length(ends.len() + ranges.len(), &self)),
            }
        }
    }
    InRanges = "a number, or a range such as [0.1, 9]" {
        fn visit_i64<E: Error>(self, end: i64) -> Result<InRanges, E> {
            Deserialize::deserialize(end.into_deserializer()).map(InRanges::End)
        }
        fn visit_f64<E: Error>(self, end: f64) -> Result<InRanges, E> {
            Deserialize::deserialize(end.into_deserializer()).map(InRanges::End)
        }
        fn visit_seq<A: SeqAccess<'de>>(self, seq: A) -> Result<InRanges, A::Error> {
            Deserialize::deserialize(SeqAccessDeserializer::new(seq)).map(InRanges::Range)
        }
    }
    Opacity = "a number from 0 to 1, or a table with by, points and scale" {
        fn visit_i64<E: Error>(self, all: i64) -> Result<Opacity, E> {
            Deserialize::deserialize(all.into_deserializer()).map(Opacity::All)
        }
        fn visit_f64<E: Error>(self, all: f64) -> Result<Opacity, E> {
            Deserialize::deserialize(all.into_deserializer()).map(Opacity::All)
        }
        fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Opacity, A::Error> {
            Deserialize::deserialize(MapAccessDeserializer::new(map)).map(Opacity::By)
        }
    }
}

fn plain_iso(value: f64) -> Iso {
    Iso(IsoKeys { value: Number(value), material: None, transparent: None })
}
