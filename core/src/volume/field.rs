//! A grid with its hierarchy, whatever type its samples have.

use super::brick::{Brick, CELLS};
use super::layout::Layout;
use super::ranges::{NodeRanges, Ranges};
use super::samples::BrickSamples;
use super::voxel::Voxel;

/// What a walk asks of a grid: so that it is compiled once, not for each type of samples.
pub trait Field: Send + Sync {
    /// Its bricks.
    fn layout(&self) -> &Layout;

    /// Least and greatest values of what node `at` of the level above `level` is made of, by place; NaN where there is nothing.
    fn ranges(&self, level: usize, at: [usize; 3]) -> [[f32; 8]; 2];

    /// Asks for the memory of a brick before it is read.
    fn prefetch(&self, at: [usize; 3]);

    /// Rows of samples of a brick: see [`Brick::load_rows`].
    fn load(&self, at: [usize; 3], rows: u32, brick: &mut Brick);

    /// The samples of a brick for rays that go through it, and their gradients if they are asked for.
    fn samples(&self, at: [usize; 3], gradients: bool, out: &mut BrickSamples);
}

/// The samples of a grid, along x first, and what is known of them.
#[derive(Clone, Copy, Debug)]
pub struct GridField<'a, V> {
    /// The samples.
    pub voxels: &'a [V],
    /// Their bricks.
    pub layout: &'a Layout,
    /// What is in these.
    pub ranges: &'a Ranges<V>,
}

impl<V: Voxel> Field for GridField<'_, V> {
    fn layout(&self) -> &Layout {
        self.layout
    }

    fn ranges(&self, level: usize, at: [usize; 3]) -> [[f32; 8]; 2] {
        self.ranges.of_children(self.layout, level, at)
    }

    fn prefetch(&self, at: [usize; 3]) {
        Brick::prefetch(self.voxels, self.layout.samples(), [0, 1, 2].map(|axis| at[axis] * CELLS[axis]));
    }

    fn load(&self, at: [usize; 3], rows: u32, brick: &mut Brick) {
        brick.load_rows(self.voxels, self.layout.samples(), [0, 1, 2].map(|axis| at[axis] * CELLS[axis]), rows);
    }

    fn samples(&self, at: [usize; 3], gradients: bool, out: &mut BrickSamples) {
        if gradients {
            out.load_with_gradients(self.voxels, self.layout.samples(), at);
        } else {
            out.load(self.voxels, self.layout.samples(), at);
        }
    }
}
