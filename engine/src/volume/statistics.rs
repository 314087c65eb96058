//! Which values a volume, or an attribute, has, and how often.

use super::{Volume, with_voxels};

/// Parts of equal width that a histogram has.
pub const BINS: usize = 64;

/// Which values a volume, or an attribute of particles, has, all steps of time together.
#[derive(Clone, Debug, PartialEq)]
pub struct Statistics {
    /// The least and the greatest finite value; `None`: there is none.
    pub range: Option<[f64; 2]>,
    /// The mean of the finite values; `None`: there is none.
    pub mean: Option<f64>,
    /// How many values are in each part of the range, from the least to the greatest.
    pub histogram: [u64; BINS],
    /// Values that are not numbers.
    pub not_numbers: u64,
    /// Values that are infinite.
    pub infinite: u64,
}

impl Statistics {
    /// Those of a volume. Reads all voxels twice.
    pub fn of(volume: &Volume) -> Self {
        let mut ends = Ends::default();
        for grid in &volume.steps {
            with_voxels!(grid.voxels(), |voxels| ends.add(voxels, |voxel| grid.value_of(voxel)));
        }
        ends.with_histogram(|range, histogram| {
            for grid in &volume.steps {
                with_voxels!(grid.voxels(), |voxels| count(voxels, |voxel| grid.value_of(voxel), range, histogram));
            }
        })
    }

    /// Those of all values of some lists. Reads them twice.
    pub fn of_values<V: Copy + Into<f64>>(lists: &[impl AsRef<[V]>]) -> Self {
        let mut ends = Ends::default();
        lists.iter().for_each(|values| ends.add(values.as_ref(), |value| value));
        ends.with_histogram(|range, histogram| {
            lists.iter().for_each(|values| count(values.as_ref(), |value| value, range, histogram));
        })
    }

    /// The range, and the value in it that best parts what is dark from what is bright: the variance between both is greatest (Otsu, "A
    /// Threshold Selection Method from Gray-Level Histograms", 1979).
    pub fn threshold(&self) -> (Option<[f64; 2]>, f64) {
        let total: f64 = self.histogram.iter().map(|&count| count as f64).sum();
        let whole: f64 = self.histogram.iter().enumerate().map(|(bin, &count)| bin as f64 * count as f64).sum();
        let (mut below, mut sum, mut best) = (0.0, 0.0, (0.0, 0));
        for (bin, &count) in self.histogram.iter().enumerate() {
            below += count as f64;
            sum += bin as f64 * count as f64;
            let apart = whole * below - sum * total;
            let variance = apart * apart / (below * (total - below)).max(1.0);
            if variance > best.0 {
                best = (variance, bin + 1);
            }
        }
        let part = best.1 as f64 / BINS as f64;
        (self.range, self.range.map_or(f64::NAN, |[low, high]| low * (1.0 - part) + high * part))
    }
}

/// What is found before there is a histogram.
struct Ends {
    low: f64,
    high: f64,
    sum: f64,
    finite: u64,
    not_numbers: u64,
    infinite: u64,
}

impl Default for Ends {
    fn default() -> Self {
        Self { low: f64::INFINITY, high: f64::NEG_INFINITY, sum: 0.0, finite: 0, not_numbers: 0, infinite: 0 }
    }
}

impl Ends {
    fn add<V: Copy + Into<f64>>(&mut self, voxels: &[V], value_of: impl Fn(f64) -> f64) {
        for &voxel in voxels {
            let value = value_of(voxel.into());
            if value.is_finite() {
                self.low = if value < self.low { value } else { self.low };
                self.high = if value > self.high { value } else { self.high };
                self.sum += value;
                self.finite += 1;
            } else if value.is_nan() {
                self.not_numbers += 1;
            } else {
                self.infinite += 1;
            }
        }
    }

    /// All together; `fill` counts the values in each part of the range.
    fn with_histogram(self, fill: impl FnOnce([f64; 2], &mut [u64; BINS])) -> Statistics {
        let Self { low, high, sum, finite, not_numbers, infinite } = self;
        let range = (finite > 0).then_some([low, high]);
        let mut histogram = [0; BINS];
        if let Some(range) = range {
            fill(range, &mut histogram);
        }
        Statistics { range, mean: range.map(|_| sum / finite as f64), histogram, not_numbers, infinite }
    }
}

/// Counts the finite values in each part of a range.
fn count<V: Copy + Into<f64>>(
    voxels: &[V],
    value_of: impl Fn(f64) -> f64,
    [low, high]: [f64; 2],
    histogram: &mut [u64; BINS],
) {
    // Halves: the whole width of a range may be more than the greatest number.
    let width = high / 2.0 - low / 2.0;
    let scale = if width > 0.0 { BINS as f64 / width } else { 0.0 };
    for &voxel in voxels {
        let value = value_of(voxel.into());
        if value.is_finite() {
            let place = (value / 2.0 - low / 2.0) * scale;
            histogram[(place as usize).min(BINS - 1)] += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::volume::{Grid, GridPlace, Voxels};

    fn volume(steps: Vec<Voxels>, scale: [f64; 2]) -> Volume {
        let place = GridPlace::with_spacing([1.0; 3]);
        let grid = |voxels: Voxels| Arc::new(Grid::new([voxels.len(), 1, 1], voxels, place, scale).unwrap());
        Volume { name: String::new(), steps: steps.into_iter().map(grid).collect() }
    }

    #[test]
    fn values_are_counted_over_all_steps() {
        let found = Statistics::of(&volume(vec![vec![0_u8, 1, 1, 63].into(), vec![64_u8, 63].into()], [2.0, -1.0]));
        assert_eq!((found.range, found.mean), (Some([-1.0, 127.0]), Some(63.0)));
        let counts: Vec<_> = found.histogram.iter().enumerate().filter(|(_, count)| **count > 0).collect();
        assert_eq!(counts, [(0, &1), (1, &2), (63, &3)]);
    }

    #[test]
    fn what_is_no_number_is_counted_apart() {
        let values = vec![f64::NAN, f64::INFINITY, -f64::MAX, f64::MAX, f64::NEG_INFINITY];
        let found = Statistics::of(&volume(vec![values.into()], [1.0, 0.0]));
        assert_eq!((found.range, found.not_numbers, found.infinite), (Some([-f64::MAX, f64::MAX]), 1, 2));
        assert_eq!((found.histogram[0], found.histogram[63], found.histogram.iter().sum::<u64>()), (1, 1, 2));
        let nothing = Statistics::of(&volume(vec![vec![f32::NAN; 3].into()], [1.0, 0.0]));
        assert_eq!((nothing.range, nothing.mean, nothing.not_numbers), (None, None, 3));
        let same = Statistics::of(&volume(vec![vec![7_i16; 3].into()], [1.0, 0.0]));
        assert_eq!((same.range, same.histogram[0]), (Some([7.0; 2]), 3));
    }
}
