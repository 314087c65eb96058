//! Least and greatest values of bricks and of the nodes above them, in the type of the samples: at most 2 % of their memory.

use alloc::vec::Vec;

use super::brick::CELLS;
use super::layout::Layout;
use super::voxel::Voxel;
use crate::bvh::Join;

/// Bricks are looked at in runs of at most so many rows of bricks without asking [`Join`].
const RUN: usize = 16;

/// The least and the greatest sample of each brick and node; those that are NaN do not count.
#[derive(Clone, Debug)]
pub struct Ranges<V> {
    /// Level by level, along x first.
    levels: Vec<Vec<[V; 2]>>,
}

impl<V: Voxel> Ranges<V> {
    /// Looks at all samples of a grid.
    ///
    /// # Panics
    /// If there are not as many as the layout says.
    pub fn new(layout: &Layout, voxels: &[V], join: &impl Join) -> Self {
        let [nx, ny, nz] = layout.samples();
        assert_eq!(voxels.len(), nx * ny * nz, "samples of a grid");
        let mut levels: Vec<Vec<[V; 2]>> = Vec::with_capacity(layout.levels().len());
        for (level, &dims) in layout.levels().iter().enumerate() {
            let count = dims[0] * dims[1] * dims[2];
            let Some(&any) = voxels.first().filter(|_| count > 0) else {
                levels.push(Vec::new());
                continue;
            };
            let mut ranges = alloc::vec![[any; 2]; count];
            if level == 0 {
                let rows = dims[1] * dims[2];
                rows_of_bricks(join, &mut ranges, 0, rows, dims, &|row, out| {
                    bricks(voxels, [nx, ny, nz], [row % dims[1], row / dims[1]], out);
                });
            } else {
                let (below, from) = (&levels[level - 1], layout.levels()[level - 1]);
                for (i, range) in ranges.iter_mut().enumerate() {
                    let at = [i % dims[0], i / dims[0] % dims[1], i / (dims[0] * dims[1])];
                    *range = children(from, at).map(|(_, i)| below[i]).reduce(merge).unwrap_or(*range);
                }
            }
            levels.push(ranges);
        }
        Self { levels }
    }
}

/// [`Ranges`] of whatever type the samples have.
pub trait NodeRanges: core::fmt::Debug + Send + Sync {
    /// Bytes that they occupy.
    fn bytes(&self) -> usize;

    /// Least and greatest values of the up to eight that node `at` of the level above `level` is made of, by their place: bits 0, 1, 2
    /// are x, y, z. The others are NaN.
    fn of_children(&self, layout: &Layout, level: usize, at: [usize; 3]) -> [[f32; 8]; 2];
}

impl<V: Voxel> NodeRanges for Ranges<V> {
    fn bytes(&self) -> usize {
        self.levels.iter().map(|level| level.len() * size_of::<[V; 2]>()).sum()
    }

    fn of_children(&self, layout: &Layout, level: usize, at: [usize; 3]) -> [[f32; 8]; 2] {
        let mut out = [[f32::NAN; 8]; 2];
        let (dims, ranges) = (layout.levels()[level], &self.levels[level]);
        for row in 0..4 {
            let [x, y, z] = [2 * at[0], 2 * at[1] + row % 2, 2 * at[2] + row / 2];
            if y < dims[1] && z < dims[2] {
                let count = (dims[0] - x).min(2);
                let start = (z * dims[1] + y) * dims[0] + x;
                for (i, &[low, high]) in ranges[start..start + count].iter().enumerate() {
                    (out[0][2 * row + i], out[1][2 * row + i]) = (low.to_f32(), high.to_f32());
                }
            }
        }
        out
    }
}

/// The places and numbers of what a node is made of, in a level with so many nodes along each axis.
fn children(dims: [usize; 3], at: [usize; 3]) -> impl Iterator<Item = (usize, usize)> {
    (0..8_usize).filter_map(move |slot| {
        let [x, y, z] = [0, 1, 2].map(|axis| 2 * at[axis] + (slot >> axis & 1));
        (x < dims[0] && y < dims[1] && z < dims[2]).then_some((slot, (z * dims[1] + y) * dims[0] + x))
    })
}

fn merge<V: Voxel>(a: [V; 2], b: [V; 2]) -> [V; 2] {
    [if b[0] < a[0] || is_nan(a[0]) { b[0] } else { a[0] }, if b[1] > a[1] || is_nan(a[1]) { b[1] } else { a[1] }]
}

#[expect(clippy::eq_op, reason = "what is not equal to itself is NaN")]
fn is_nan<V: Voxel>(value: V) -> bool {
    value != value
}

/// Calls `work` with each row of bricks, in parallel.
fn rows_of_bricks<V: Voxel>(
    join: &impl Join,
    ranges: &mut [[V; 2]],
    first: usize,
    rows: usize,
    dims: [usize; 3],
    work: &(impl Fn(usize, &mut [[V; 2]]) + Sync),
) {
    if rows <= RUN {
        for (row, out) in ranges.chunks_exact_mut(dims[0]).enumerate() {
            work(first + row, out);
        }
        return;
    }
    let middle = rows / 2;
    let (left, right) = ranges.split_at_mut(middle * dims[0]);
    join.join(
        || rows_of_bricks(join, left, first, middle, dims, work),
        || rows_of_bricks(join, right, first + middle, rows - middle, dims, work),
    );
}

/// The ranges of a row of bricks along x.
fn bricks<V: Voxel>(voxels: &[V], [nx, ny, nz]: [usize; 3], [j, k]: [usize; 2], out: &mut [[V; 2]]) {
    let mut first = true;
    for z in k * CELLS[2]..=((k + 1) * CELLS[2]).min(nz - 1) {
        for y in j * CELLS[1]..=((j + 1) * CELLS[1]).min(ny - 1) {
            let row = &voxels[(z * ny + y) * nx..][..nx];
            for (i, range) in out.iter_mut().enumerate() {
                let part = &row[i * CELLS[0]..=((i + 1) * CELLS[0]).min(nx - 1)];
                let start = if first { [part[0]; 2] } else { *range };
                *range = part.iter().fold(start, |range, &value| merge(range, [value; 2]));
            }
            first = false;
        }
    }
}
