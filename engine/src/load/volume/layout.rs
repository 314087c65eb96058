//! How many voxels there are and in which order: checked before any of them is read.

use super::VoxelType;
use crate::load::lines::Fault;
use crate::volume::MOST_SAMPLES;

/// The most steps of time.
const MOST_STEPS: u64 = 1 << 16;

/// Voxels in the order in which a file has them: the first index of space fastest, and one step of time after the other, whole or
/// in parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Layout {
    /// Samples along each index of space.
    pub(super) dims: [usize; 3],
    /// Steps of time, at least one.
    pub(super) steps: usize,
    /// So many voxels of a step lie together; then the next step has its turn. All of a step: time is the slowest index; one: it is
    /// the fastest.
    pub(super) together: usize,
    count: usize,
}

impl Layout {
    /// Checks the sizes. Time comes after so many of the indices of space.
    pub(super) fn new(dims: [u64; 3], steps: u64, time_after: usize) -> Result<Self, Fault> {
        let [x, y, z] = dims;
        let fault = |problem: String, remedy| Err(Fault::new(problem, remedy));
        if dims.contains(&0) || steps == 0 {
            let of_steps = if steps == 1 { String::new() } else { format!(" in {steps} steps") };
            return fault(format!("a grid of {x} x {y} x {z}{of_steps} has no samples"), "check how it was written");
        }
        if dims.iter().any(|&side| side > MOST_SAMPLES as u64) {
            return fault(format!("a grid of {x} x {y} x {z} has more than {MOST_SAMPLES} samples a side"), "cut it");
        }
        if steps > MOST_STEPS {
            return fault(format!("{steps} steps of time are more than {MOST_STEPS}"), "split it");
        }
        let dims = dims.map(|side| side as usize);
        let product = |sides: &[usize]| sides.iter().try_fold(1_usize, |product, &side| product.checked_mul(side));
        let count = product(&dims);
        // Eight bytes each is the most: whatever fits now is never checked again.
        let bytes = product(&[dims[0], dims[1], dims[2], steps as usize, 8]);
        let (Some(count), Some(_)) = (count, bytes.filter(|&bytes| bytes <= isize::MAX as usize)) else {
            return fault(format!("{x} x {y} x {z} samples in {steps} steps are more than fit into memory"), "cut it");
        };
        let together = product(&dims[..time_after.min(3)]).unwrap_or(count);
        Ok(Self { dims, steps: steps as usize, together, count })
    }

    /// Voxels of a step.
    pub(super) fn per_step(&self) -> usize {
        self.count
    }

    /// Voxels of all steps.
    pub(super) fn voxels(&self) -> usize {
        self.count * self.steps
    }

    /// Bytes of all steps.
    pub(super) fn bytes(&self, kind: VoxelType) -> u64 {
        (self.voxels() * kind.bytes()) as u64
    }

    /// What it is, for messages.
    pub(super) fn describe(&self, kind: VoxelType) -> String {
        let ([x, y, z], bytes) = (self.dims, self.bytes(kind));
        let steps = if self.steps == 1 { String::new() } else { format!(" in {} steps", self.steps) };
        format!("{x} x {y} x {z} voxels of type {kind}{steps} take {bytes} bytes")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_checked() {
        let problem = |dims, steps| Layout::new(dims, steps, 3).map_err(|fault| fault.problem);
        let layout = problem([2, 3, 4], 5).unwrap();
        assert_eq!((layout.per_step(), layout.voxels(), layout.together), (24, 120, 24));
        assert_eq!(layout.bytes(VoxelType::F64), 960);
        for (dims, steps, expected) in [
            ([2, 0, 4], 1, "a grid of 2 x 0 x 4 has no samples"),
            ([2, 3, 4], 0, "a grid of 2 x 3 x 4 in 0 steps has no samples"),
            ([u64::MAX, 3, 4], 1, "has more than 65536 samples a side"),
            ([65537, 1, 1], 1, "has more than 65536 samples a side"),
            ([2, 3, 4], 65537, "65537 steps of time are more than 65536"),
            ([65536; 3], 65536, "more than fit into memory"),
        ] {
            let problem = problem(dims, steps).unwrap_err();
            assert!(problem.ends_with(expected), "{problem}");
        }
    }

    #[test]
    fn time_may_come_before_any_index_of_space() {
        let together = |time_after| Layout::new([2, 3, 4], 5, time_after).unwrap().together;
        assert_eq!([0, 1, 2, 3].map(together), [1, 2, 6, 24]);
    }
}
