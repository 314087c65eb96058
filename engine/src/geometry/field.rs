//! A grid of a volume made ready for rays: where it is, and the hierarchy of what is in it.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3, Vec3};
use mobula_core::volume::{self as core, Brick, BrickSamples, CELLS, Layout, NodeRanges, Ranges, TooLarge};

use crate::accel::Pool;
use crate::progress::Progress;
use crate::volume::{Grid, with_voxels};

/// A grid with its hierarchy, which does not depend on what is made of it: iso-surfaces and media share one.
#[derive(Debug)]
pub struct Field {
    grid: Arc<Grid>,
    layout: Layout,
    ranges: Box<dyn NodeRanges>,
    to_cells: DAffine3,
    range: [f64; 2],
}

impl Field {
    /// Looks at all samples of a grid.
    ///
    /// # Errors
    /// If there are too many.
    pub fn new(grid: Arc<Grid>) -> Result<Self, TooLarge> {
        let layout = Layout::new(grid.dims())?;
        let progress = Progress::default();
        let ranges: Box<dyn NodeRanges> = with_voxels!(grid.voxels(), |voxels| {
            Box::new(Pool::enter(|| Ranges::new(&layout, voxels, &Pool(&progress))))
        });
        let place = grid.place();
        let to_space =
            DAffine3 { matrix3: DMat3::from_cols_array_2d(&place.axes.map(Into::into)), translation: place.origin };
        let range = grid.range().unwrap_or_default();
        Ok(Self { to_cells: to_space.inverse(), grid, layout, ranges, range })
    }

    /// The grid.
    pub fn grid(&self) -> &Arc<Grid> {
        &self.grid
    }

    /// The least and the greatest value; zeros if none is a number.
    pub fn range(&self) -> [f64; 2] {
        self.range
    }

    /// Bytes of the hierarchy.
    pub fn bytes(&self) -> usize {
        self.ranges.bytes()
    }

    /// From space to cells: sample (i, j, k) comes to be at (i, j, k).
    pub fn to_cells(&self) -> &DAffine3 {
        &self.to_cells
    }

    /// The corners of the box around all samples.
    pub fn corners(&self) -> [Vec3; 8] {
        self.grid.place().corners(self.grid.dims()).map(|corner| corner.as_vec3())
    }

    /// Calls `visit` with the corners of all bricks that may have one of these values, in the samples' own numbers, between their samples.
    pub fn visit_bricks(&self, values: &[f32], visit: &mut dyn FnMut(Vec3)) {
        let (layout, place) = (&self.layout, self.grid.place());
        if layout.levels()[0] == [0; 3] {
            return;
        }
        let mut nodes = vec![(layout.levels().len() - 1, [0; 3])];
        while let Some((level, at)) = nodes.pop() {
            let Some(below) = level.checked_sub(1) else {
                for corner in 0..8_usize {
                    let cell = |axis: usize| {
                        let first = (at[axis] + (corner >> axis & 1)) * CELLS[axis];
                        first.min(layout.cells(axis)) as f64
                    };
                    let [x, y, z] = [0, 1, 2].map(|axis| place.axes[axis] * cell(axis));
                    visit((place.origin + x + y + z).as_vec3());
                }
                continue;
            };
            let [low, high] = self.ranges.of_children(layout, below, at);
            let passed = |slot: &usize| values.iter().any(|&value| low[*slot] < value && value <= high[*slot]);
            let child = |slot: usize| (below, [0, 1, 2].map(|axis| 2 * at[axis] + (slot >> axis & 1)));
            nodes.extend((0..8).filter(passed).map(child));
        }
    }

    /// Where a point of space is, in cells.
    #[inline(always)]
    pub fn cells_of(&self, point: Vec3) -> DVec3 {
        self.to_cells.transform_point3(point.as_dvec3())
    }
}

/// The steps of time of a volume, of which one is shown.
#[derive(Clone, Debug)]
pub struct Series {
    fields: Arc<[Arc<Field>]>,
    step: usize,
    range: [f64; 2],
}

impl Series {
    /// These steps, the first of them shown.
    ///
    /// # Panics
    /// If there are none.
    pub fn new(fields: Vec<Arc<Field>>) -> Self {
        assert!(!fields.is_empty(), "a volume has a step of time");
        let ends = |[a, b]: [f64; 2], [c, d]: [f64; 2]| [a.min(c), b.max(d)];
        let range = fields.iter().map(|field| field.range()).reduce(ends).unwrap_or_default();
        Self { fields: fields.into(), step: 0, range }
    }

    /// Of the steps of a volume whose least and greatest value are these: all of its steps need not be here.
    pub fn of_range(self, range: [f64; 2]) -> Self {
        Self { range, ..self }
    }

    /// With this step shown; behind the last comes the first.
    pub fn at(&self, step: usize) -> Self {
        Self { step: step % self.fields.len(), ..self.clone() }
    }

    /// What is shown.
    pub fn field(&self) -> &Arc<Field> {
        &self.fields[self.step]
    }

    /// Which step is shown, from 0.
    pub fn step(&self) -> usize {
        self.step
    }

    /// How many steps there are.
    pub fn steps(&self) -> usize {
        self.fields.len()
    }

    /// The least and the greatest value of all steps.
    pub fn range(&self) -> [f64; 2] {
        self.range
    }
}

impl core::Field for Field {
    fn layout(&self) -> &Layout {
        &self.layout
    }

    fn ranges(&self, level: usize, at: [usize; 3]) -> [[f32; 8]; 2] {
        self.ranges.of_children(&self.layout, level, at)
    }

    fn prefetch(&self, at: [usize; 3]) {
        let first = [0, 1, 2].map(|axis| at[axis] * CELLS[axis]);
        with_voxels!(self.grid.voxels(), |voxels| Brick::prefetch(voxels, self.grid.dims(), first));
    }

    fn load(&self, at: [usize; 3], rows: u32, brick: &mut Brick) {
        let first = [0, 1, 2].map(|axis| at[axis] * CELLS[axis]);
        with_voxels!(self.grid.voxels(), |voxels| brick.load_rows(voxels, self.grid.dims(), first, rows));
    }

    fn samples(&self, at: [usize; 3], gradients: bool, out: &mut BrickSamples) {
        let dims = self.grid.dims();
        with_voxels!(self.grid.voxels(), |voxels| {
            if gradients { out.load_with_gradients(voxels, dims, at) } else { out.load(voxels, dims, at) }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::GridPlace;

    #[test]
    fn bricks_with_a_value_are_found() {
        // A ball of radius 3 around (30, 10, 10).
        let samples: Vec<u8> = (0..40 * 20 * 20)
            .map(|i: i32| {
                let [x, y, z] = [i % 40 - 30, i / 40 % 20 - 10, i / 800 - 10];
                if x * x + y * y + z * z <= 9 { 100 } else { 0 }
            })
            .collect();
        let place = GridPlace { origin: DVec3::splat(100.0), ..GridPlace::with_spacing([2.0, 1.0, 1.0]) };
        let field = Field::new(Arc::new(Grid::new([40, 20, 20], samples.into(), place, [1.0, 0.0]).unwrap())).unwrap();
        let bounds = |values: &[f32]| {
            let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
            field.visit_bricks(values, &mut |point| (low, high) = (low.min(point), high.max(point)));
            (low - 100.0, high - 100.0)
        };
        let (low, high) = bounds(&[50.0]);
        assert!(low.cmple(Vec3::new(54.0, 7.0, 7.0)).all() && low.cmpge(Vec3::new(32.0, 3.0, 3.0)).all(), "{low}");
        assert!(high.cmpge(Vec3::new(66.0, 13.0, 13.0)).all() && high.x <= 78.0, "{high}");
        assert!(bounds(&[200.0]).0.x > bounds(&[200.0]).1.x, "no such value");
    }
}
