//! The values of one step, and where in space they are.

use glam::DVec3;

use super::{Voxels, with_voxels};

/// Where the samples of a grid are: sample (i, j, k) is at `origin + i axes[0] + j axes[1] + k axes[2]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridPlace {
    /// Where sample (0, 0, 0) is.
    pub origin: DVec3,
    /// The way from one sample to the next along each index.
    pub axes: [DVec3; 3],
}

impl GridPlace {
    /// From the origin along the axes of space.
    pub fn with_spacing(spacing: [f64; 3]) -> Self {
        let [x, y, z] = spacing;
        Self { origin: DVec3::ZERO, axes: [DVec3::X * x, DVec3::Y * y, DVec3::Z * z] }
    }

    /// Distances between neighbouring samples.
    pub fn spacing(&self) -> [f64; 3] {
        self.axes.map(DVec3::length)
    }

    /// The corners of a grid with so many samples along each index: bits 0, 1, 2 of a corner's number say which ends.
    pub fn corners(&self, dims: [usize; 3]) -> [DVec3; 8] {
        let last = dims.map(|side| side.saturating_sub(1) as f64);
        std::array::from_fn(|i| self.point([0, 1, 2].map(|k| if i >> k & 1 == 1 { last[k] } else { 0.0 })))
    }

    /// Where a point between samples is, by its indices.
    pub fn point(&self, [i, j, k]: [f64; 3]) -> DVec3 {
        self.origin + self.axes[0] * i + self.axes[1] * j + self.axes[2] * k
    }
}

/// What is wrong with a grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum GridError {
    /// A side without samples.
    #[error("a grid of {0} x {1} x {2} has no samples")]
    Empty(usize, usize, usize),
    /// More or fewer samples than the sides say.
    #[error("a grid with sides of {0} x {1} x {2} has not {3} samples")]
    Count(usize, usize, usize, usize),
    /// Sides that are longer than can be counted with.
    #[error("a grid may have at most {MOST_SAMPLES} samples a side")]
    TooLong,
    /// Samples that are not at points of space, or all in a plane.
    #[error("the spacing and the orientation of the grid are not finite, or all its samples are in a plane")]
    Place,
    /// Values that are not numbers.
    #[error("the scale of the values is zero or not finite")]
    Scale,
}

/// The most samples along a side.
pub const MOST_SAMPLES: usize = 1 << 16;

/// Scalar values at the points of a regular grid. Along the first index they lie next to each other in memory.
#[derive(Clone, Debug)]
pub struct Grid {
    dims: [usize; 3],
    voxels: Voxels,
    place: GridPlace,
    scale: [f64; 2],
}

impl Grid {
    /// A grid with so many samples along each index. What a sample stands for is `scale[0] voxel + scale[1]`.
    ///
    /// # Errors
    /// If these do not fit together.
    pub fn new(dims: [usize; 3], voxels: Voxels, place: GridPlace, scale: [f64; 2]) -> Result<Self, GridError> {
        let [x, y, z] = dims;
        if dims.contains(&0) {
            return Err(GridError::Empty(x, y, z));
        }
        if dims.iter().any(|&side| side > MOST_SAMPLES) {
            return Err(GridError::TooLong);
        }
        if x.checked_mul(y).and_then(|slice| slice.checked_mul(z)) != Some(voxels.len()) {
            return Err(GridError::Count(x, y, z, voxels.len()));
        }
        let [a, b, c] = place.axes;
        let volume = a.cross(b).dot(c);
        if !(place.origin.is_finite() && volume.is_finite() && volume != 0.0) {
            return Err(GridError::Place);
        }
        if !(scale[0].is_finite() && scale[1].is_finite() && scale[0] != 0.0) {
            return Err(GridError::Scale);
        }
        Ok(Self { dims, voxels, place, scale })
    }

    /// The same grid with its first sample elsewhere.
    ///
    /// # Errors
    /// If that is no point.
    pub fn moved_to(self, origin: DVec3) -> Result<Self, GridError> {
        let place = GridPlace { origin, ..self.place };
        if origin.is_finite() { Ok(Self { place, ..self }) } else { Err(GridError::Place) }
    }

    /// Samples along each index.
    pub fn dims(&self) -> [usize; 3] {
        self.dims
    }

    /// The samples as they are stored, the first index fastest.
    pub fn voxels(&self) -> &Voxels {
        &self.voxels
    }

    /// Where they are.
    pub fn place(&self) -> &GridPlace {
        &self.place
    }

    /// A sample's voxel times the first, plus the second, is what it stands for.
    pub fn scale(&self) -> [f64; 2] {
        self.scale
    }

    /// The least and the greatest finite value; `None` if none is.
    pub fn range(&self) -> Option<[f64; 2]> {
        let [low, high] = with_voxels!(&self.voxels, |voxels| ends(voxels));
        let [a, b] = [low, high].map(|voxel| self.value_of(voxel));
        (low <= high).then_some([a.min(b), a.max(b)])
    }

    /// What a voxel would be that stands for a value.
    pub fn voxel_of(&self, value: f64) -> f64 {
        (value - self.scale[1]) / self.scale[0]
    }

    /// What a voxel stands for.
    pub fn value_of(&self, voxel: f64) -> f64 {
        voxel * self.scale[0] + self.scale[1]
    }
}

/// The least and the greatest of some numbers.
fn ends<V: Copy + Into<f64>>(voxels: &[V]) -> [f64; 2] {
    voxels.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], &voxel| {
        let x = voxel.into();
        if x.is_finite() { [if x < low { x } else { low }, if x > high { x } else { high }] } else { [low, high] }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grids_are_checked() {
        let place = GridPlace::with_spacing([1.0, 2.0, 0.5]);
        let grid = |dims, count, place, scale| Grid::new(dims, vec![0_u8; count].into(), place, scale).err();
        assert_eq!(grid([2, 3, 4], 24, place, [1.0, 0.0]), None);
        assert_eq!(grid([2, 0, 4], 0, place, [1.0, 0.0]), Some(GridError::Empty(2, 0, 4)));
        assert_eq!(grid([2, 3, 4], 25, place, [1.0, 0.0]), Some(GridError::Count(2, 3, 4, 25)));
        assert_eq!(grid([1 << 17, 1, 1], 1 << 17, place, [1.0, 0.0]), Some(GridError::TooLong));
        let flat = GridPlace::with_spacing([1.0, 0.0, 1.0]);
        assert_eq!(grid([2, 3, 4], 24, flat, [1.0, 0.0]), Some(GridError::Place));
        assert_eq!(grid([2, 3, 4], 24, place, [f64::NAN, 0.0]), Some(GridError::Scale));
    }

    #[test]
    fn samples_have_a_place_and_stand_for_a_value() {
        let place = GridPlace { origin: DVec3::new(1.0, 2.0, 3.0), ..GridPlace::with_spacing([1.0, 2.0, 0.5]) };
        let grid = Grid::new([1, 1, 2], vec![3_i16, -7].into(), place, [0.5, 10.0]).unwrap();
        assert_eq!(grid.place().point([0.0, 1.0, 2.0]), DVec3::new(1.0, 4.0, 4.0));
        assert_eq!(grid.place().spacing(), [1.0, 2.0, 0.5]);
        assert_eq!(grid.range(), Some([6.5, 11.5]));
        assert_eq!((grid.value_of(grid.voxels().get(1)), grid.voxel_of(6.5)), (6.5, -7.0));
    }
}
