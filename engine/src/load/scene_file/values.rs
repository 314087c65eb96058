//! What may stand behind keys: numbers within limits, colours, names. Each says what it expects where something else stands.

use std::fmt;
use std::marker::PhantomData;
use std::str::FromStr;

use glam::Vec3;
use serde::Deserialize;
use serde::de::value::SeqAccessDeserializer;
use serde::de::{Deserializer, Error, SeqAccess, Unexpected, Visitor};

use crate::color;
use crate::tone::Tone;

/// A kind of number: its type, what people are told to write, and which are meant.
macro_rules! numbers {
    ($($(#[$outer:meta])* $name:ident($type:ty) = $expected:literal, $from:ident, |$x:ident| $test:expr;)+) => {$(
        $(#[$outer])*
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub(super) struct $name(pub(super) $type);

        impl<'de> Deserialize<'de> for $name {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                struct Numbers;
                impl Visitor<'_> for Numbers {
                    type Value = $name;
                    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                        f.write_str($expected)
                    }
                    fn visit_i64<E: Error>(self, number: i64) -> Result<$name, E> {
                        let found = $from::of_whole(number).filter(|&$x| $test);
                        found.map($name).ok_or_else(|| E::invalid_value(Unexpected::Signed(number), &self))
                    }
                    fn visit_f64<E: Error>(self, number: f64) -> Result<$name, E> {
                        let found = $from::of_float(number).filter(|&$x| $test);
                        found.map($name).ok_or_else(|| E::invalid_value(Unexpected::Float(number), &self))
                    }
                }
                deserializer.deserialize_any(Numbers)
            }
        }
    )+};
}

/// Numbers with a fraction: whole ones are too.
struct Real;

impl Real {
    fn of_whole(number: i64) -> Option<f64> {
        Some(number as f64)
    }

    fn of_float(number: f64) -> Option<f64> {
        number.is_finite().then_some(number)
    }
}

/// As [`Real`], and infinite ones.
struct Endless;

impl Endless {
    fn of_whole(number: i64) -> Option<f64> {
        Some(number as f64)
    }

    fn of_float(number: f64) -> Option<f64> {
        (!number.is_nan()).then_some(number)
    }
}

/// Numbers that must be written as whole ones.
struct Counted;

impl Counted {
    fn of_whole(number: i64) -> Option<u64> {
        number.try_into().ok()
    }

    fn of_float(_: f64) -> Option<u64> {
        None
    }
}

numbers! {
    /// Any.
    Number(f64) = "a finite number", Real, |_x| true;
    /// The end of a range.
    Bound(f64) = "a number, or inf", Endless, |_x| true;
    /// Within the numbers that rays are traced with.
    Single(f64) = "a number from -1e30 to 1e30", Real, |x| x.abs() <= 1e30;
    /// A length, a density.
    Positive(f64) = "a number above 0, at most 1e30", Real, |x| x > 0.0 && x <= 1e30;
    /// A distance that something is looked for, which may have no end.
    Reach(f64) = "a number from 0 to 1e30, or inf", Endless, |x| (0.0..=1e30).contains(&x) || x == f64::INFINITY;
    /// A power of 2.
    Exposure(f64) = "a number from -32 to 32", Real, |x| x.abs() <= f64::from(Tone::MOST_EXPOSURE);
    /// A density, a sharpness.
    NotNegative(f64) = "a number from 0 to 1e30", Real, |x| (0.0..=1e30).contains(&x);
    /// A fraction.
    Part(f64) = "a number from 0 to 1", Real, |x| (0.0..=1.0).contains(&x);
    /// An index of refraction.
    Index(f64) = "a number from 1 to 100", Real, |x| (1.0..=100.0).contains(&x);
    /// Degrees.
    FieldOfView(f64) = "an angle from 1 to 360 degrees", Real, |x| (1.0..=360.0).contains(&x);
    /// Degrees between two directions.
    Turn(f64) = "an angle from 0 to 180 degrees", Real, |x| (0.0..=180.0).contains(&x);
    /// Units of cells.
    StepLength(f64) = "a number from 0.03125 to 16", Real, |x| (0.031_25..=16.0).contains(&x);
    /// A number of a step, of pixels.
    Whole(u64) = "a whole number from 0 on", Counted, |_x| true;
    /// How many of something there are.
    Count(u64) = "a whole number from 1 on", Counted, |x| x > 0;
    /// How often something is repeated.
    Repeats(u64) = "a whole number from 1 to 64", Counted, |x| (1..=64).contains(&x);
}

/// A point of space.
pub(super) type Point = [Single; 3];

/// The numbers of a point.
pub(super) fn point(point: Point) -> [f64; 3] {
    point.map(|x| x.0)
}

/// A fraction of light in linear RGB: three numbers from 0 to 1, one for grey, or `#rrggbb` on the sRGB curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Color(pub(super) Vec3);

/// Light in linear RGB: as [`Color`], but without a greatest number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Radiance(pub(super) Vec3);

struct Colors {
    greatest: f64,
}

impl Colors {
    fn channel<E: Error>(&self, number: f64) -> Result<f32, E> {
        let found = (0.0..=self.greatest).contains(&number).then_some(number as f32);
        found.ok_or_else(|| E::invalid_value(Unexpected::Float(number), self))
    }
}

impl<'de> Visitor<'de> for Colors {
    type Value = Vec3;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let limit = if self.greatest > 1.0 { "from 0 on" } else { "from 0 to 1" };
        write!(f, "a colour: three numbers {limit} such as [1, 0.5, 0], or \"#rrggbb\"")
    }

    fn visit_i64<E: Error>(self, number: i64) -> Result<Vec3, E> {
        self.channel(number as f64).map(Vec3::splat)
    }

    fn visit_f64<E: Error>(self, number: f64) -> Result<Vec3, E> {
        self.channel(number).map(Vec3::splat)
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<Vec3, E> {
        color::parse(text).ok_or_else(|| E::invalid_value(Unexpected::Str(text), &self))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, seq: A) -> Result<Vec3, A::Error> {
        let [r, g, b] = <[Number; 3]>::deserialize(SeqAccessDeserializer::new(seq))?;
        Ok(Vec3::new(self.channel(r.0)?, self.channel(g.0)?, self.channel(b.0)?))
    }
}

impl<'de> Deserialize<'de> for Color {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Colors { greatest: 1.0 }).map(Self)
    }
}

impl<'de> Deserialize<'de> for Radiance {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Colors { greatest: 1e30 }).map(Self)
    }
}

/// A component by the name that the command line uses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Named<T>(pub(super) T);

impl<'de, T: FromStr<Err: fmt::Display>> Deserialize<'de> for Named<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Names<T>(PhantomData<T>);
        impl<T: FromStr<Err: fmt::Display>> Visitor<'_> for Names<T> {
            type Value = Named<T>;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a name between quotes")
            }
            fn visit_str<E: Error>(self, name: &str) -> Result<Named<T>, E> {
                name.parse().map(Named).map_err(E::custom)
            }
        }
        deserializer.deserialize_str(Names(PhantomData))
    }
}
