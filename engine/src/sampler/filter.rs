//! What a pixel shows of the picture around it.

use std::sync::LazyLock;

use crate::choice::UnknownName;
use crate::packet::Column;

/// A reconstruction filter: how much a sample counts for a pixel, by how far it is from its middle along each side.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Filter {
    /// All that is in the pixel counts the same.
    Box,
    /// A Gaussian of standard deviation 0.4, as far as 1.5 pixels: smooth edges.
    #[default]
    Gaussian,
    /// Mitchell and Netravali, "Reconstruction Filters in Computer Graphics", 1988, with B = C = 1/3: sharp edges, with a seam along
    /// hard ones.
    Mitchell,
}

/// All filters, with their names.
const NAMES: [(&str, Filter); 3] =
    [("box", Filter::Box), ("gaussian", Filter::Gaussian), ("mitchell", Filter::Mitchell)];

impl Filter {
    /// Do some samples count negatively?
    pub(super) fn is_ever_negative(self) -> bool {
        self == Self::Mitchell
    }

    /// Moves samples that are spread evenly over their pixels to where the filter is, and says what each counts: 1, or -1 where the filter
    /// is negative.
    pub(super) fn spread(self, image: &mut [Column<f32>; 2], weights: &mut [f32]) {
        weights.fill(1.0);
        let table = match self {
            Self::Box => return,
            Self::Gaussian => &*GAUSSIAN,
            Self::Mitchell => &*MITCHELL,
        };
        for column in image {
            for (x, weight) in column.iter_mut().zip(weights.iter_mut()) {
                let pixel = x.floor();
                let place = table.place(*x - pixel);
                *x = pixel + 0.5 + place;
                if place.abs() > table.negative {
                    *weight = -*weight;
                }
            }
        }
    }
}

impl std::str::FromStr for Filter {
    type Err = UnknownName;
    fn from_str(name: &str) -> Result<Self, UnknownName> {
        let found = NAMES.iter().find(|(known, _)| name.eq_ignore_ascii_case(known)).map(|&(_, filter)| filter);
        let known = NAMES.map(|(name, _)| name).join(", ");
        found.ok_or_else(|| UnknownName { kind: "filter", name: name.to_owned(), known })
    }
}

impl std::fmt::Display for Filter {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(NAMES.iter().find(|(_, filter)| filter == self).map_or("", |(name, _)| name))
    }
}

static GAUSSIAN: LazyLock<Table> = LazyLock::new(|| {
    let width = |x: f64| -x * x / (2.0 * 0.4 * 0.4);
    Table::new(1.5, f64::INFINITY, |x| crate::math::exp2(width(x) * std::f64::consts::LOG2_E))
});

static MITCHELL: LazyLock<Table> = LazyLock::new(|| {
    // (12 - 9B - 6C, -18 + 12B + 6C, 6 - 2B) / 6 to 1, (-B - 6C, 6B + 30C, -12B - 48C, 8B + 24C) / 6 from there to 2; negative from
    // 8/7 on.
    Table::new(2.0, 8.0 / 7.0, |x| {
        if x < 1.0 {
            (7.0 * x * x * x - 12.0 * x * x + 16.0 / 3.0) / 6.0
        } else {
            (-7.0 / 3.0 * x * x * x + 12.0 * x * x - 20.0 * x + 32.0 / 3.0) / 6.0
        }
    })
});

/// Steps of a table.
const STEPS: usize = 1024;

/// Where the area under a filter's size reaches each fraction of the whole.
struct Table {
    places: [f32; STEPS + 1],
    /// From here on the filter is negative.
    negative: f32,
}

impl Table {
    /// Of a filter that is the same on both sides and ends at `end`.
    fn new(end: f64, negative: f64, filter: impl Fn(f64) -> f64) -> Self {
        const FINE: usize = 16 * STEPS;
        let at = |i: usize| end * (2.0 * (i as f64 + 0.5) / FINE as f64 - 1.0);
        let sizes: Vec<f64> = (0..FINE).map(|i| filter(at(i).abs()).abs()).collect();
        let whole: f64 = sizes.iter().sum();
        let mut places = [end as f32; STEPS + 1];
        places[0] = -end as f32;
        let (mut area, mut next) = (0.0, 1);
        for (i, size) in sizes.iter().enumerate() {
            while next < STEPS && area + size >= whole * next as f64 / STEPS as f64 {
                let part = (whole * next as f64 / STEPS as f64 - area) / size;
                places[next] = (end * (2.0 * (i as f64 + part) / FINE as f64 - 1.0)) as f32;
                next += 1;
            }
            area += size;
        }
        Self { places, negative: negative as f32 }
    }

    /// Where the area reaches a fraction, from the middle of the pixel.
    fn place(&self, fraction: f32) -> f32 {
        let at = fraction * STEPS as f32;
        let i = (at as usize).min(STEPS - 1);
        self.places[i] + (self.places[i + 1] - self.places[i]) * (at - i as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Samples along one pixel, with what they count.
    fn samples(filter: Filter, count: usize) -> Vec<(f32, f32)> {
        let mut image = [Column::new(count), Column::new(count)];
        let mut weights = vec![0.0; count];
        for i in 0..count {
            (image[0][i], image[1][i]) = (7.0 + (i as f32 + 0.5) / count as f32, 3.5);
        }
        filter.spread(&mut image, &mut weights);
        image[0].iter().zip(weights).map(|(x, weight)| (x - 7.5, weight)).collect()
    }

    #[test]
    fn samples_are_as_the_filter_is_high() {
        for (filter, variance) in [(Filter::Box, 1.0 / 12.0), (Filter::Gaussian, 0.16), (Filter::Mitchell, 0.0)] {
            let samples = samples(filter, 10_000);
            let sum = |f: &dyn Fn(f32) -> f32| samples.iter().map(|&(x, weight)| weight * f(x)).sum::<f32>();
            let whole = sum(&|_| 1.0);
            assert!(whole > 5_000.0, "{filter}: {whole}");
            assert!((sum(&|x| x) / whole).abs() < 2e-3, "{filter} is the same on both sides");
            // Mitchell's keeps quadratic functions but for (1 - B - 2C) / 3 = 0 of them: its variance is B / 3.
            let expected = if filter == Filter::Mitchell { 1.0 / 9.0 } else { variance };
            let found = sum(&|x| x * x) / whole;
            assert!((found - expected).abs() < 5e-3, "{filter}: variance {found}");
            assert_eq!(filter.to_string().parse(), Ok(filter));
        }
        assert!("sinc".parse::<Filter>().unwrap_err().to_string().contains("box, gaussian, mitchell"));
    }
}
