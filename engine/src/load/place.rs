//! Where a model is put: coordinates far from the origin, or tiny or huge ones, do not fit the numbers that rays are traced with.

use std::path::Path;

/// What is done to coordinates before they become `f32`: an offset is subtracted, then they are multiplied by a power of two.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// What is subtracted.
    pub offset: [f64; 3],
    /// What they are multiplied by then.
    pub scale: f64,
}

impl Default for Place {
    /// Where it is.
    fn default() -> Self {
        Self { offset: [0.0; 3], scale: 1.0 }
    }
}

/// A model whose middle is this many times its size away from the origin is moved: map coordinates are 1e4 and more, and a `f32` has
/// 24 bits.
const FAR: f64 = 1000.0;
/// Sizes with whose squares and cubes `f32` can work.
const SIZES: std::ops::Range<f64> = 1e-9..1e9;
/// So many corners are looked at.
const SAMPLES: usize = 4096;

impl Place {
    /// Looks at some of the corners that faces use: at the median, so that a few that are elsewhere do not count.
    pub(super) fn of(positions: &[[f64; 3]], corners: &[u32]) -> Self {
        let Some((middle, size)) = most(positions, corners) else { return Self::default() };
        let mut place = Self::default();
        if middle.iter().any(|x| x.abs() > FAR * size) && size > 0.0 {
            // A round number, which is easy to add again.
            let step = 10f64.powf(size.log10().ceil());
            place.offset = middle.map(|x| (x / step).round() * step);
        }
        if size > 0.0 && !SIZES.contains(&size) {
            // Greater factors are no numbers.
            place.scale = 2f64.powf((-size.log2().round()).min(1000.0));
        }
        place
    }

    /// Where a file is put: at the place that was chosen for all that are shown together, else where it is best. Warns of what people
    /// should know.
    pub(super) fn choose(
        chosen: Option<Self>,
        file: &Path,
        positions: &[[f64; 3]],
        corners: &[u32],
        warnings: &mut Vec<String>,
    ) -> Self {
        let place = chosen.unwrap_or_else(|| Self::of(positions, corners));
        let file = file.display();
        if chosen.is_none() {
            warnings.extend(place.warning().map(|text| format!("{file}: {text}")));
        } else if place.blurs(positions, corners) {
            warnings.push(format!(
                "{file}: it is so far from the first file that its details are lost; show it alone, or name it first"
            ));
        }
        place
    }

    /// A point where it is put.
    pub fn put(&self, position: [f64; 3]) -> [f32; 3] {
        [0, 1, 2].map(|k| ((position[k] - self.offset[k]) * self.scale) as f32)
    }

    /// A plane (a, b, c, d), of the points where a x + b y + c z = d, where it is put.
    pub fn put_plane(&self, [a, b, c, d]: [f64; 4]) -> [f64; 4] {
        let [x, y, z] = self.offset;
        [a, b, c, (d - a * x - b * y - c * z) * self.scale]
    }

    /// The plane of the file that is put where this one is.
    pub fn plane_back(&self, [a, b, c, d]: [f64; 4]) -> [f64; 4] {
        let [x, y, z] = self.offset;
        [a, b, c, d / self.scale + a * x + b * y + c * z]
    }

    /// The point of the file that is put at `position`.
    pub fn back(&self, position: [f32; 3]) -> [f64; 3] {
        [0, 1, 2].map(|k| f64::from(position[k]) / self.scale + self.offset[k])
    }

    /// Would the corners that faces use lie too close together here for a `f32` to tell them apart?
    pub(super) fn blurs(&self, positions: &[[f64; 3]], corners: &[u32]) -> bool {
        let Some((middle, size)) = most(positions, corners) else { return false };
        // Of few there is no size by which to judge.
        size > 0.0 && (0..3).any(|k| (middle[k] - self.offset[k]).abs() > size * f64::from(1 << 18))
    }

    /// What people should know.
    pub(super) fn warning(&self) -> Option<String> {
        if *self == Self::default() {
            return None;
        }
        let mut done = Vec::new();
        if self.offset != [0.0; 3] {
            let [x, y, z] = self.offset.map(|x| -x + 0.0);
            done.push(format!("far from the origin: it is moved by {x}, {y}, {z}"));
        }
        if self.scale != 1.0 {
            let too = if self.scale > 1.0 { "small" } else { "large" };
            done.push(format!(
                "too {too} for the numbers that rays are traced with: it is scaled by 2^{}",
                self.scale.log2()
            ));
        }
        Some(format!("the model is {}", done.join(", and ")))
    }
}

/// Where the middle of most corners is, and how far most are from there.
fn most(positions: &[[f64; 3]], corners: &[u32]) -> Option<([f64; 3], f64)> {
    let step = corners.len().div_ceil(SAMPLES).max(1);
    let samples: Vec<[f64; 3]> = corners
        .iter()
        .step_by(step)
        .filter_map(|&corner| positions.get(corner as usize).copied())
        .filter(|position| position.iter().all(|x| x.is_finite()))
        .collect();
    if samples.is_empty() {
        return None;
    }
    let at = |mut values: Vec<f64>, share: usize| {
        let place = (values.len() - 1) * share / 16;
        *values.select_nth_unstable_by(place, f64::total_cmp).1
    };
    let middle = [0, 1, 2].map(|k| at(samples.iter().map(|p| p[k]).collect(), 8));
    let distance = |p: &[f64; 3]| (0..3).map(|k| (p[k] - middle[k]).abs()).fold(0.0, f64::max);
    let size = at(samples.iter().map(distance).collect(), 15);
    Some((middle, size))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(size: f64, at: [f64; 3]) -> Place {
        let corner = |i: usize| [0, 1, 2].map(|k| at[k] + size * ((i >> k & 1) as f64 - 0.5));
        let positions: Vec<_> = (0..8).map(corner).chain([[f64::NAN; 3], [-1e30, 0.0, 0.0]]).collect();
        let corners: Vec<u32> = (0..800).map(|i| i % 8).chain([8, 9]).collect();
        Place::of(&positions, &corners)
    }

    #[test]
    fn usual_models_stay_where_they_are() {
        for size in [1e-6, 1.0, 1e6] {
            for at in [[0.0; 3], [100.0 * size, 0.0, -300.0 * size]] {
                assert_eq!(place(size, at), Place::default(), "{size} {at:?}");
            }
        }
    }

    #[test]
    fn map_coordinates_are_moved_to_the_origin() {
        let place = place(30.0, [458_712.0, 5_428_771.0, 112.0]);
        assert_eq!(place, Place { offset: [458_700.0, 5_428_800.0, 100.0], scale: 1.0 });
        assert_eq!(place.put([458_712.25, 5_428_771.5, 112.125]), [12.25, -28.5, 12.125]);
        let text = place.warning().unwrap();
        assert_eq!(text, "the model is far from the origin: it is moved by -458700, -5428800, -100");
    }

    #[test]
    fn what_is_tiny_or_huge_is_scaled() {
        for size in [1e-43, 1e-30, 1e-12, 1e12, 1e30, 1e38, 1e300] {
            let place = place(size, [0.0; 3]);
            let [x, ..] = place.put([size, 0.0, 0.0]);
            assert!((0.4..4.0).contains(&x), "{size:e}: {x}");
            assert_eq!(place.scale.log2().fract(), 0.0);
        }
    }
}
