//! What came out of a kernel, whatever the packet's width.

use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;
use core::ops::Range;

use crate::Properties;

/// Names of [`Outcome::columns`].
const NAMES: [&str; 10] = [
    "t_max",
    "direction x",
    "direction y",
    "direction z",
    "inverse x",
    "inverse y",
    "inverse z",
    "shear x",
    "shear y",
    "shear z",
];

/// Bits by ray.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Outcome {
    pub(super) columns: [Vec<u32>; 10],
    pub(super) found: Vec<u32>,
    pub(super) axis: Vec<u32>,
    pub(super) extra: Vec<u32>,
    pub(super) properties: Properties,
}

impl Outcome {
    /// Far end of ray `i`'s interval: the distance of its hit.
    pub fn t_max(&self, i: usize) -> f32 {
        f32::from_bits(self.columns[0][i])
    }

    /// Direction of ray `i`.
    pub fn direction(&self, i: usize) -> [f32; 3] {
        [1, 2, 3].map(|c| f32::from_bits(self.columns[c][i]))
    }

    /// Reciprocal direction of ray `i`.
    pub fn inverse(&self, i: usize) -> [f32; 3] {
        [4, 5, 6].map(|c| f32::from_bits(self.columns[c][i]))
    }

    /// Shear factors of ray `i`, and the reciprocal of its direction along the dominant axis.
    pub fn shear(&self, i: usize) -> [f32; 3] {
        [7, 8, 9].map(|c| f32::from_bits(self.columns[c][i]))
    }

    /// Dominant axis of ray `i`.
    pub fn axis(&self, i: usize) -> u32 {
        self.axis[i]
    }

    /// What was written for ray `i`.
    pub fn found(&self, i: usize) -> u32 {
        self.found[i]
    }

    /// The other answers.
    pub fn extra(&self, at: usize) -> f32 {
        f32::from_bits(self.extra[at])
    }

    /// What is known of the rays now.
    pub fn properties(&self) -> Properties {
        self.properties
    }

    /// Must be the same bits everywhere; NaN equals NaN.
    pub(super) fn equals(&self, want: &Self) -> Result<(), String> {
        for (name, (got, want)) in NAMES.iter().zip(self.columns.iter().zip(&want.columns)) {
            same(name, got, want, 0..got.len())?;
        }
        same("axis", &self.axis, &want.axis, 0..self.axis.len())?;
        self.answers_equal(want)?;
        if self.properties != want.properties {
            return Err(format!("properties {:?}, want {:?}", self.properties, want.properties));
        }
        Ok(())
    }

    /// As [`equals`](Self::equals), of the answers only, not of what was derived on the way.
    pub(super) fn answers_equal(&self, want: &Self) -> Result<(), String> {
        same(NAMES[0], &self.columns[0], &want.columns[0], 0..self.columns[0].len())?;
        same("found", &self.found, &want.found, 0..self.found.len())?;
        same("extra", &self.extra, &want.extra, 0..self.extra.len())
    }

    /// Must be as it was outside of the active rays.
    pub(super) fn untouched(&self, before: &Self, active: &Range<usize>) -> Result<(), String> {
        let width = self.found.len();
        for range in [0..active.start, active.end.max(active.start)..width] {
            for (name, (got, want)) in NAMES.iter().zip(self.columns.iter().zip(&before.columns)) {
                same(name, got, want, range.clone())?;
            }
            same("axis", &self.axis, &before.axis, range.clone())?;
            same("found", &self.found, &before.found, range)?;
        }
        Ok(())
    }
}

fn same(name: &str, got: &[u32], want: &[u32], mut range: Range<usize>) -> Result<(), String> {
    match range.find(|&i| got.get(i) != want.get(i)) {
        None => Ok(()),
        Some(i) => {
            let (got, want) = (got[i], want[i]);
            let (g, w) = (f32::from_bits(got), f32::from_bits(want));
            Err(format!("{name}[{i}] is {got:#010x} ({g:e}), want {want:#010x} ({w:e})"))
        }
    }
}
