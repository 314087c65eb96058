//! How often values are in a grid.

use super::Grid;

/// Counts of values in bins of equal width.
#[derive(Clone, Debug, PartialEq)]
pub struct Histogram {
    /// The least and the greatest value.
    pub range: [f64; 2],
    /// How many values are in each bin.
    pub counts: Vec<u64>,
}

/// More samples than this are not looked at: every second, third, ... one is.
const MOST: usize = 1 << 22;

impl Histogram {
    /// Of the values of a grid, or of some of them if there are many; `None` if none is a number.
    pub fn new(grid: &Grid, bins: usize) -> Option<Self> {
        let range = grid.range()?;
        let mut counts = vec![0; bins.max(1)];
        let (voxels, width) = (grid.voxels(), range[1] - range[0]);
        // An odd number of them, so that all columns have their turn.
        let stride = voxels.len().div_ceil(MOST) | 1;
        for i in (0..voxels.len()).step_by(stride) {
            let part = (grid.value_of(voxels.get(i)) - range[0]) / width;
            // A value that is no number is in no bin; where all are equal they are in the first.
            if !part.is_nan() || width == 0.0 {
                let bin = (part * counts.len() as f64) as usize;
                let last = counts.len() - 1;
                counts[bin.min(last)] += 1;
            }
        }
        Some(Self { range, counts })
    }

    /// The value that best parts what is dark from what is bright (Otsu, "A Threshold Selection Method from Gray-Level Histograms",
    /// 1979): the variance between both is greatest.
    pub fn threshold(&self) -> f64 {
        let total: f64 = self.counts.iter().map(|&count| count as f64).sum();
        let mean: f64 = self.counts.iter().enumerate().map(|(bin, &count)| bin as f64 * count as f64).sum();
        let (mut below, mut sum, mut best) = (0.0, 0.0, (0.0, 0));
        for (bin, &count) in self.counts.iter().enumerate() {
            below += count as f64;
            sum += bin as f64 * count as f64;
            let apart = mean * below - sum * total;
            let variance = apart * apart / (below * (total - below)).max(1.0);
            if variance > best.0 {
                best = (variance, bin + 1);
            }
        }
        let [low, high] = self.range;
        low + (high - low) * best.1 as f64 / self.counts.len() as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::GridPlace;

    #[test]
    fn values_are_counted_and_parted() {
        let place = GridPlace::with_spacing([1.0; 3]);
        let values: Vec<f32> =
            (0..1000).map(|i| if i % 4 == 0 { 90.0 + (i % 10) as f32 } else { (i % 20) as f32 }).collect();
        let grid = Grid::new([10; 3], values.into(), place, [2.0, 1.0]).unwrap();
        let histogram = Histogram::new(&grid, 64).unwrap();
        assert_eq!((histogram.range, histogram.counts.iter().sum::<u64>()), ([3.0, 197.0], 1000));
        assert!((39.0..181.0).contains(&histogram.threshold()), "{}", histogram.threshold());
        let flat = Grid::new([2; 3], vec![7_u8; 8].into(), place, [1.0, 0.0]).unwrap();
        assert_eq!(Histogram::new(&flat, 4).unwrap().counts, [8, 0, 0, 0]);
        let none = Grid::new([2; 3], vec![f32::NAN; 8].into(), place, [1.0, 0.0]).unwrap();
        assert_eq!(Histogram::new(&none, 4), None);
    }
}
