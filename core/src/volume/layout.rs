//! Which bricks a grid has, and which node is made of which.
//!
//! Level 0 are the bricks. A node of a higher level is made of up to 2 x 2 x 2 of the level below; the last level has one node.

use alloc::vec::Vec;

use super::brick::CELLS;
use crate::bvh::Child;
use crate::kernel::margin::Frame;

/// Bits of what tells bricks apart.
const BITS: u32 = 27;

/// A grid with more bricks than there are numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TooLarge;

impl core::fmt::Display for TooLarge {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("the grid has more than 2^27 bricks of 8 x 4 x 4 cells")
    }
}

impl core::error::Error for TooLarge {}

/// The bricks of a grid and the nodes above them.
#[derive(Clone, Debug)]
pub struct Layout {
    samples: [usize; 3],
    /// Nodes along each axis, level by level.
    levels: Vec<[usize; 3]>,
    /// Bits of the first two indices of a brick.
    bits: [u32; 2],
    frame: Frame,
}

impl Layout {
    /// Of a grid with so many samples along each axis.
    ///
    /// # Errors
    /// If there are too many.
    pub fn new(samples: [usize; 3]) -> Result<Self, TooLarge> {
        let cells = samples.map(|n| n.saturating_sub(1));
        let mut level = [0, 1, 2].map(|axis| cells[axis].div_ceil(CELLS[axis]));
        if level.contains(&0) {
            level = [0; 3];
        }
        let bits = level.map(|n| n.saturating_sub(1).checked_ilog2().map_or(0, |log| log + 1));
        if bits.iter().sum::<u32>() > BITS {
            return Err(TooLarge);
        }
        let mut levels = alloc::vec![level];
        while level.iter().any(|&n| n > 1) {
            level = level.map(|n| n.div_ceil(2));
            levels.push(level);
        }
        // The middle of the grid; halves are exact.
        let reach = cells.map(|n| n as f32 * 0.5);
        let farthest = reach.into_iter().fold(0.0, f32::max);
        let frame = Frame { center: reach, size: farthest, farthest };
        Ok(Self { samples, levels, bits: [bits[0], bits[1]], frame })
    }

    /// Samples along each axis.
    pub fn samples(&self) -> [usize; 3] {
        self.samples
    }

    /// Nodes along each axis, level by level from the bricks up.
    pub fn levels(&self) -> &[[usize; 3]] {
        &self.levels
    }

    /// What boxes are relative to.
    pub fn frame(&self) -> &Frame {
        &self.frame
    }

    /// Cells along an axis.
    #[inline(always)]
    pub fn cells(&self, axis: usize) -> usize {
        self.samples[axis] - 1
    }

    /// Where the walk begins.
    pub fn root(&self) -> Child {
        match self.levels.len() - 1 {
            _ if self.levels[0] == [0; 3] => Child::EMPTY,
            top => self.child(top, [0; 3]),
        }
    }

    /// A node, or on level 0 a brick, by its indices.
    #[inline(always)]
    pub fn child(&self, level: usize, [x, y, z]: [usize; 3]) -> Child {
        let number = x | y << self.bits[0] | z << (self.bits[0] + self.bits[1]);
        if level == 0 { Child::leaf(number, 1) } else { Child::node(level << BITS | number) }
    }

    /// Level and indices of a node.
    #[inline(always)]
    pub fn node(&self, index: usize) -> (usize, [usize; 3]) {
        (index >> BITS, self.indices(index & ((1 << BITS) - 1)))
    }

    /// The indices of a brick; `None` if there is none of this number.
    #[inline(always)]
    pub fn brick(&self, number: usize) -> Option<[usize; 3]> {
        let at = self.indices(number);
        (0..3).all(|axis| at[axis] < self.levels[0][axis]).then_some(at)
    }

    #[inline(always)]
    fn indices(&self, number: usize) -> [usize; 3] {
        let part = |from: u32, bits: u32| number >> from & ((1 << bits) - 1);
        let [x, y] = self.bits;
        [part(0, x), part(x, y), number >> (x + y)]
    }

    /// Brick `i` of all, along x first.
    pub fn nth_brick(&self, i: usize) -> Option<Child> {
        let [x, y, z] = self.levels[0];
        (i < x * y * z).then(|| self.child(0, [i % x, i / x % y, i / (x * y)]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bricks_and_nodes_have_numbers_of_their_own() {
        let layout = Layout::new([18, 83, 10]).unwrap();
        assert_eq!(layout.levels(), [[3, 21, 3], [2, 11, 2], [1, 6, 1], [1, 3, 1], [1, 2, 1], [1, 1, 1]]);
        let mut seen = alloc::collections::BTreeSet::new();
        let mut count = 0;
        while let Some(brick) = layout.nth_brick(count) {
            let number = brick.leaf_range().start;
            let at = layout.brick(number).unwrap();
            assert_eq!(layout.child(0, at), brick);
            assert!(brick.is_leaf() && seen.insert(number));
            count += 1;
        }
        assert_eq!(count, 3 * 21 * 3);
        assert_eq!(layout.node(layout.child(3, [0, 2, 0]).index()), (3, [0, 2, 0]));
        assert_eq!(layout.brick(Child::EMPTY.leaf_range().start), None);
    }

    #[test]
    fn flat_grids_have_no_cells_and_huge_ones_are_refused() {
        assert_eq!(Layout::new([5, 1, 5]).unwrap().root(), Child::EMPTY);
        assert!(Layout::new([2048, 2048, 2048]).is_ok());
        assert_eq!(Layout::new([1 << 16, 1 << 16, 1 << 10]).err(), Some(TooLarge));
    }
}
