//! Which keys there are, and what stands behind them; those of objects are in [`object_keys`](super::object_keys).

use std::fmt;
use std::str::FromStr;

use serde::Deserialize;
use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{Deserializer, Error, IgnoredAny, IntoDeserializer, MapAccess, SeqAccess, Unexpected, Visitor};
use toml::Spanned;

use super::values::{
    Color, Count, Exposure, FieldOfView, Index, Named, NotNegative, Number, Part, Point, Positive, Radiance, Reach,
    Single, Turn, Whole,
};
use crate::camera::CameraKind;
use crate::load::is_picture;
use crate::material::Pattern;
use crate::renderer::RendererKind;
use crate::sampler::SamplerKind;
use crate::tone::Curve;
use crate::view::Up;

/// What concerns the whole scene. What has parts of its own kind is read by itself.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(dead_code, reason = "the ignored ones are there so that they count as known")]
pub(super) struct Head {
    mobula: IgnoredAny,
    pub(super) size: Option<Spanned<[Count; 2]>>,
    pub(super) time: Option<Time>,
    pub(super) camera: Option<Spanned<Camera>>,
    pub(super) up: Option<Named<Up>>,
    pub(super) renderer: Option<Named<RendererKind>>,
    pub(super) sampler: Option<Named<SamplerKind>>,
    pub(super) shadows: Option<bool>,
    pub(super) occlusion: Option<Reach>,
    pub(super) tone: Option<Named<Curve>>,
    pub(super) exposure: Option<Exposure>,
    pub(super) smooth: Option<Turn>,
    pub(super) background: Option<Spanned<Background>>,
    pub(super) ambient: Option<Spanned<Ambient>>,
    pub(super) fog: Option<Fog>,
    pub(super) ground: Option<Ground>,
    materials: Option<IgnoredAny>,
    transfer: Option<IgnoredAny>,
    maps: Option<IgnoredAny>,
    object: Option<IgnoredAny>,
    light: Option<IgnoredAny>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Time {
    pub(super) step: Option<Positive>,
    #[serde(rename = "loop", default = "yes")]
    pub(super) repeat: bool,
    pub(super) show: Option<Whole>,
}

fn yes() -> bool {
    true
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Camera {
    pub(super) kind: Option<Named<CameraKind>>,
    pub(super) eye: Option<Point>,
    pub(super) at: Option<Point>,
    pub(super) up: Option<Point>,
    pub(super) fov: Option<FieldOfView>,
    pub(super) aperture: Option<NotNegative>,
    pub(super) focus: Option<Positive>,
}

/// Words of the command line, a colour, a sky, or a picture.
#[derive(Clone, Debug)]
pub(super) enum Background {
    Words(String),
    Plain(Color),
    Sky(Sky),
    Picture(Panorama),
}

/// A table: a picture if it has a file, else a sky.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Surrounding {
    zenith: Option<Radiance>,
    horizon: Option<Radiance>,
    nadir: Option<Radiance>,
    file: Option<Spanned<String>>,
    rotate: Option<Single>,
    strength: Option<NotNegative>,
}

impl Surrounding {
    fn background<E: Error>(self) -> Result<Background, E> {
        match self {
            Self {
                zenith: Some(zenith),
                horizon: Some(horizon),
                nadir: Some(nadir),
                file: None,
                rotate: None,
                strength: None,
            } => Ok(Background::Sky(Sky { zenith, horizon, nadir })),
            Self { zenith: None, horizon: None, nadir: None, file: Some(file), rotate, strength } => {
                Ok(Background::Picture(Panorama { file, rotate, strength }))
            }
            _ => Err(E::custom(
                "a background has either zenith, horizon and nadir, or file, and perhaps rotate and strength",
            )),
        }
    }
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Sky {
    pub(super) zenith: Radiance,
    pub(super) horizon: Radiance,
    pub(super) nadir: Radiance,
}

#[derive(Clone, Debug)]
pub(super) struct Panorama {
    pub(super) file: Spanned<String>,
    pub(super) rotate: Option<Single>,
    pub(super) strength: Option<NotNegative>,
}

/// Light from everywhere: the same, or from above and from below.
#[derive(Clone, Copy, Debug)]
pub(super) enum Ambient {
    Plain(Radiance),
    Hemisphere(Hemisphere),
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Hemisphere {
    pub(super) above: Radiance,
    pub(super) below: Radiance,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Fog {
    pub(super) density: NotNegative,
    pub(super) color: Option<Color>,
}

/// A ground under the scene: yes, no, or how.
#[derive(Clone, Copy, Debug)]
pub(super) enum Ground {
    Usual(bool),
    Such(SuchGround),
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SuchGround {
    pub(super) height: Option<Single>,
    pub(super) color: Option<Color>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PointLight {
    pub(super) at: Point,
    pub(super) color: Option<Radiance>,
    #[serde(default)]
    pub(super) falloff: bool,
}

/// A light from a point into a cone.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SpotLight {
    pub(super) at: Point,
    pub(super) to: Point,
    pub(super) color: Option<Radiance>,
    pub(super) inner: Option<Turn>,
    pub(super) outer: Option<Turn>,
    #[serde(default)]
    pub(super) falloff: bool,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RectangleLight {
    pub(super) at: Point,
    pub(super) to: Point,
    pub(super) up: Option<Point>,
    pub(super) size: [Positive; 2],
    pub(super) color: Option<Radiance>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DiskLight {
    pub(super) at: Point,
    pub(super) to: Point,
    pub(super) radius: Positive,
    pub(super) color: Option<Radiance>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SphereLight {
    pub(super) at: Point,
    pub(super) radius: Positive,
    pub(super) color: Option<Radiance>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SunLight {
    pub(super) direction: Point,
    pub(super) color: Option<Radiance>,
    pub(super) angle: Option<Turn>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CameraLight {
    pub(super) color: Option<Radiance>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DirectionalLight {
    pub(super) direction: Point,
    pub(super) color: Option<Radiance>,
}

/// A texture, and how it lies on a surface.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "the name of a picture, or a table with file, repeat, offset and clamp")]
pub(super) struct LaidTexture {
    pub(super) file: Spanned<String>,
    pub(super) repeat: Option<[Number; 2]>,
    pub(super) offset: Option<[Number; 2]>,
    #[serde(default)]
    pub(super) clamp: bool,
}

impl Default for LaidTexture {
    /// Of no file, once for each unit of texture coordinates.
    fn default() -> Self {
        Self { file: Spanned::new(0..0, String::new()), repeat: None, offset: None, clamp: false }
    }
}

/// Materials whose only parameter is a colour.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(dead_code, reason = "textures are taken out before; their names are here for messages")]
pub(super) struct Colored {
    pub(super) color: Option<Paint>,
    pub(super) texture: Option<IgnoredAny>,
    pub(super) normal_map: Option<IgnoredAny>,
    pub(super) opacity_map: Option<IgnoredAny>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(dead_code, reason = "textures are taken out before; their names are here for messages")]
pub(super) struct Phong {
    pub(super) color: Option<Paint>,
    pub(super) specular: Option<Color>,
    pub(super) shininess: Option<NotNegative>,
    pub(super) reflection: Option<Part>,
    pub(super) transparency: Option<Part>,
    pub(super) refractive_index: Option<Positive>,
    pub(super) texture: Option<IgnoredAny>,
    pub(super) normal_map: Option<IgnoredAny>,
    pub(super) opacity_map: Option<IgnoredAny>,
    pub(super) specular_map: Option<IgnoredAny>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Emissive {
    pub(super) color: Option<Paint>,
    pub(super) strength: Option<NotNegative>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(dead_code, reason = "textures are taken out before; their names are here for messages")]
pub(super) struct Principled {
    pub(super) color: Option<Paint>,
    pub(super) metallic: Option<Part>,
    pub(super) roughness: Option<Part>,
    pub(super) emission: Option<Radiance>,
    pub(super) opacity: Option<Part>,
    pub(super) ior: Option<Index>,
    pub(super) texture: Option<IgnoredAny>,
    pub(super) normal_map: Option<IgnoredAny>,
    pub(super) opacity_map: Option<IgnoredAny>,
    pub(super) metallic_roughness_map: Option<IgnoredAny>,
    pub(super) emission_map: Option<IgnoredAny>,
}

/// Materials with a colour and a roughness.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Rough {
    pub(super) color: Option<Paint>,
    pub(super) roughness: Option<Part>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Dielectric {
    pub(super) ior: Option<Positive>,
    pub(super) color: Option<Color>,
    pub(super) distance: Option<Positive>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ThinDielectric {
    pub(super) ior: Option<Positive>,
    pub(super) color: Option<Color>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Checker {
    pub(super) colors: Option<[Color; 2]>,
    pub(super) size: Option<Positive>,
    pub(super) by: Option<Named<Pattern>>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Wireframe {
    pub(super) line: Option<Color>,
    pub(super) color: Option<Paint>,
    pub(super) width: Option<Positive>,
    pub(super) relative_width: Option<Part>,
    pub(super) pixels: Option<Positive>,
}

/// Materials without parameters.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct NoKeys {}

/// A colour, or an attribute that decides about it.
#[derive(Clone, Debug)]
pub(super) enum Paint {
    Plain(Color),
    By(ColorBy),
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ColorBy {
    pub(super) by: String,
    pub(super) map: Option<Spanned<String>>,
    pub(super) range: Option<Spanned<[Number; 2]>>,
}

/// A transfer function: its points, or more.
#[derive(Clone, Debug)]
pub(super) enum TransferRows {
    Points(Vec<[Number; 5]>),
    Scaled(ScaledRows),
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ScaledRows {
    pub(super) points: Vec<[Number; 5]>,
    pub(super) values: Option<Named<Measured>>,
    pub(super) lengths: Option<Named<Measured>>,
}

/// What numbers of a transfer function are measured by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Measured {
    Absolute,
    Relative,
}

impl FromStr for Measured {
    type Err = &'static str;
    fn from_str(word: &str) -> Result<Self, Self::Err> {
        match word {
            "absolute" => Ok(Self::Absolute),
            "relative" => Ok(Self::Relative),
            _ => Err("write absolute or relative"),
        }
    }
}

/// Values that may be written in several ways: what people are told to write, and what each way gives.
macro_rules! either {
    ($($name:ident = $expected:literal { $($visit:tt)+ })+) => {$(
        impl<'de> Deserialize<'de> for $name {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                struct Ways;
                impl<'de> Visitor<'de> for Ways {
                    type Value = $name;
                    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                        f.write_str($expected)
                    }
                    $($visit)+
                }
                deserializer.deserialize_any(Ways)
            }
        }
    )+};
}

/// What a colour gives, and what a table.
macro_rules! color_or_map {
    ($type:ident: $color:ident, $map:ident) => {
        fn visit_i64<E: Error>(self, grey: i64) -> Result<$type, E> {
            Deserialize::deserialize(grey.into_deserializer()).map($type::$color)
        }
        fn visit_f64<E: Error>(self, grey: f64) -> Result<$type, E> {
            Deserialize::deserialize(grey.into_deserializer()).map($type::$color)
        }
        seq_or_map!($type: $color, $map);
    };
}

/// What a sequence gives, and what a table.
macro_rules! seq_or_map {
    ($type:ident: $seq:ident, $map:ident) => {
        fn visit_seq<A: SeqAccess<'de>>(self, seq: A) -> Result<$type, A::Error> {
            Deserialize::deserialize(SeqAccessDeserializer::new(seq)).map($type::$seq)
        }
        fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<$type, A::Error> {
            Deserialize::deserialize(MapAccessDeserializer::new(map)).map($type::$map)
        }
    };
}

either! {
    Background = "sky, daylight, black, white, a colour, a picture (hdr, exr, png, jpg, tga), or a table with zenith, horizon and nadir, or with file" {
        fn visit_str<E: Error>(self, words: &str) -> Result<Background, E> {
            let known = crate::background::parse(words).is_some() || is_picture(words.as_ref());
            let wrong = || E::invalid_value(Unexpected::Str(words), &self);
            known.then(|| Background::Words(words.to_owned())).ok_or_else(wrong)
        }
        fn visit_i64<E: Error>(self, grey: i64) -> Result<Background, E> {
            Deserialize::deserialize(grey.into_deserializer()).map(Background::Plain)
        }
        fn visit_f64<E: Error>(self, grey: f64) -> Result<Background, E> {
            Deserialize::deserialize(grey.into_deserializer()).map(Background::Plain)
        }
        fn visit_seq<A: SeqAccess<'de>>(self, seq: A) -> Result<Background, A::Error> {
            Deserialize::deserialize(SeqAccessDeserializer::new(seq)).map(Background::Plain)
        }
        fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Background, A::Error> {
            Surrounding::deserialize(MapAccessDeserializer::new(map))?.background()
        }
    }
    Ambient = "a colour, or a table with above and below" {
        fn visit_str<E: Error>(self, words: &str) -> Result<Ambient, E> {
            let color = crate::color::parse(words).map(|color| Ambient::Plain(Radiance(color)));
            color.ok_or_else(|| E::invalid_value(Unexpected::Str(words), &self))
        }
        color_or_map!(Ambient: Plain, Hemisphere);
    }
    Ground = "true, false, or a table with height and color" {
        fn visit_bool<E: Error>(self, there: bool) -> Result<Ground, E> {
            Ok(Ground::Usual(there))
        }
        fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Ground, A::Error> {
            Deserialize::deserialize(MapAccessDeserializer::new(map)).map(Ground::Such)
        }
    }
    Paint = "a colour, or a table with by, map and range" {
        fn visit_str<E: Error>(self, words: &str) -> Result<Paint, E> {
            let color = crate::color::parse(words).map(|color| Paint::Plain(Color(color)));
            color.ok_or_else(|| E::invalid_value(Unexpected::Str(words), &self))
        }
        color_or_map!(Paint: Plain, By);
    }
    TransferRows = "points such as [[0, 0, 0, 0, 0], [20, 1, 0.3, 0, 2]], or a table with points, values and lengths" {
        seq_or_map!(TransferRows: Points, Scaled);
    }
}

pub(super) use either;
