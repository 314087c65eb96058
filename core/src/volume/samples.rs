//! The samples of a brick for rays that go through it, and the gradient at each of them.

use super::voxel::Voxel;
use crate::kernel::trilinear::{CELLS, SAMPLES, Samples};

/// Samples of a brick with one more on each side: what differences are taken of.
const AROUND: [usize; 3] = [SAMPLES[0] + 2, SAMPLES[1] + 2, SAMPLES[2] + 2];

/// The samples of a brick. What is not finite is NaN.
#[derive(Clone, Debug)]
pub struct BrickSamples {
    /// The samples.
    pub values: Samples,
    /// Their gradients, by the differences of the neighbours on both sides, in units of cells.
    pub gradients: [Samples; 3],
}

impl BrickSamples {
    /// Zeros.
    pub const ZERO: Self = Self { values: Samples::ZERO, gradients: [Samples::ZERO; 3] };

    /// Copies the samples of brick `at` of a grid. Beyond the last ones these are repeated.
    pub fn load<V: Voxel>(&mut self, voxels: &[V], samples: [usize; 3], at: [usize; 3]) {
        let first = [0, 1, 2].map(|axis| at[axis] * CELLS[axis]);
        for k in 0..SAMPLES[2] {
            for j in 0..SAMPLES[1] {
                let mut row = [0.0; SAMPLES[0]];
                copy(voxels, samples, first, [j, k], &mut row);
                self.values.set_row(j, k, &row);
            }
        }
    }

    /// As [`load`](Self::load), with the gradients.
    pub fn load_with_gradients<V: Voxel>(&mut self, voxels: &[V], samples: [usize; 3], at: [usize; 3]) {
        let first = [0, 1, 2].map(|axis| (at[axis] * CELLS[axis]) as isize - 1);
        // From what is beyond the ends, the difference to the last one is as large as that of the last two.
        let mut around = [[[0.0; AROUND[0]]; AROUND[1]]; AROUND[2]];
        for (k, slice) in around.iter_mut().enumerate() {
            let z = beyond(first[2] + k as isize, samples[2]);
            for (j, row) in slice.iter_mut().enumerate() {
                let y = beyond(first[1] + j as isize, samples[1]);
                wide(voxels, samples, first[0], [y.0, z.0], row);
                if y.1 != y.0 || z.1 != z.0 {
                    let mut inner = [0.0; AROUND[0]];
                    wide(voxels, samples, first[0], [y.1, z.1], &mut inner);
                    for i in 0..AROUND[0] {
                        row[i] = row[i] + row[i] - inner[i];
                    }
                }
            }
        }
        for k in 0..SAMPLES[2] {
            for j in 0..SAMPLES[1] {
                let [mut value, mut x, mut y, mut z] = [[0.0; SAMPLES[0]]; 4];
                let (row, rows) = (&around[k + 1][j + 1], [&around[k + 1][j], &around[k + 1][j + 2]]);
                let slices = [&around[k][j + 1], &around[k + 2][j + 1]];
                for i in 0..SAMPLES[0] {
                    value[i] = row[i + 1];
                    x[i] = (row[i + 2] - row[i]) * 0.5;
                    y[i] = (rows[1][i + 1] - rows[0][i + 1]) * 0.5;
                    z[i] = (slices[1][i + 1] - slices[0][i + 1]) * 0.5;
                }
                self.values.set_row(j, k, &value);
                for (gradients, row) in self.gradients.iter_mut().zip([x, y, z]) {
                    gradients.set_row(j, k, &row);
                }
            }
        }
    }
}

/// Copies the samples of row (j, k) from sample `first` on.
#[inline(always)]
fn copy<V: Voxel, const N: usize>(
    voxels: &[V],
    [nx, ny, nz]: [usize; 3],
    first: [usize; 3],
    [j, k]: [usize; 2],
    out: &mut [f32; N],
) {
    let (y, z) = ((first[1] + j).min(ny - 1), (first[2] + k).min(nz - 1));
    let row = &voxels[(z * ny + y) * nx..][first[0]..nx];
    match row.first_chunk::<N>() {
        Some(row) => {
            for i in 0..N {
                out[i] = finite(row[i]);
            }
        }
        None => {
            for i in 0..N {
                out[i] = finite(row[i.min(row.len() - 1)]);
            }
        }
    }
}

/// Copies a row with one sample before its first and one behind its last.
#[inline(always)]
fn wide<V: Voxel>(voxels: &[V], samples: [usize; 3], first: isize, [y, z]: [usize; 2], out: &mut [f32; AROUND[0]]) {
    if let Some(start) = usize::try_from(first).ok().filter(|start| start + AROUND[0] <= samples[0]) {
        copy(voxels, samples, [start, y, z], [0, 0], out);
        return;
    }
    let row = &voxels[(z * samples[1] + y) * samples[0]..][..samples[0]];
    for (i, out) in out.iter_mut().enumerate() {
        let (at, inner) = beyond(first + i as isize, samples[0]);
        let value = finite(row[at]);
        *out = if inner == at { value } else { value + value - finite(row[inner]) };
    }
}

/// The sample at a place, and for a place beyond the ends the one that is as far from the end on the other side.
fn beyond(place: isize, count: usize) -> (usize, usize) {
    let last = count - 1;
    match usize::try_from(place) {
        Err(_) => (0, 1.min(last)),
        Ok(place) if place > last => (last, last.saturating_sub(1)),
        Ok(place) => (place, place),
    }
}

#[inline(always)]
fn finite<V: Voxel>(voxel: V) -> f32 {
    let value = voxel.to_f32();
    if V::FINITE || value.is_finite() { value } else { f32::NAN }
}
