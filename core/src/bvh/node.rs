//! A node: the bounds of eight children as a structure of arrays, four cache lines.

use bytemuck::Zeroable;

use crate::kernel::boxes::Planes;
use crate::leaf::Bounds;

/// Where a child is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Zeroable)]
#[repr(transparent)]
pub struct Child(u32);

const LEAF: u32 = 1 << 31;
const COUNT_SHIFT: u32 = 28;
const START: u32 = (1 << COUNT_SHIFT) - 1;

impl Child {
    /// No child: a leaf of blocks that do not exist.
    pub const EMPTY: Self = Self(LEAF | START);

    /// The node with this index.
    ///
    /// # Panics
    /// If the index needs more than 31 bits.
    pub const fn node(index: usize) -> Self {
        assert!(index < LEAF as usize, "more than 2^31 nodes");
        Self(index as u32)
    }

    /// `count` (1..=8) blocks from `start`.
    ///
    /// # Panics
    /// If the start needs more than 28 bits or the count is not 1..=8.
    pub fn leaf(start: usize, count: usize) -> Self {
        assert!(
            (1..=8).contains(&count) && start < START as usize,
            "more than 2^28 blocks, or {count} blocks in a leaf"
        );
        Self(LEAF | ((count - 1) as u32) << COUNT_SHIFT | start as u32)
    }

    /// Is it a leaf?
    #[inline(always)]
    pub fn is_leaf(self) -> bool {
        self.0 & LEAF != 0
    }

    /// The index of the node; meaningless for a leaf.
    #[inline(always)]
    pub fn index(self) -> usize {
        self.0 as usize
    }

    /// What is in the leaf, a range of how leaves are stored; meaningless for a node.
    #[inline(always)]
    pub fn leaf_range(self) -> core::ops::Range<usize> {
        let start = (self.0 & START) as usize;
        start..start + (self.0 >> COUNT_SHIFT & 7) as usize + 1
    }

    /// The same child after `nodes` nodes and `blocks` blocks were put before it. Whether there are too many, is to be
    /// asked once for the last of them.
    #[inline(always)]
    pub(crate) fn moved(self, nodes: usize, blocks: usize) -> Self {
        let by = if self.is_leaf() { blocks } else { nodes };
        if self == Self::EMPTY { self } else { Self(self.0 + by as u32) }
    }
}

/// Eight children. Unused places have empty bounds, which no ray meets.
#[derive(Clone, Copy, Debug, Zeroable)]
#[repr(C, align(64))]
pub struct Node {
    /// `planes[0..3]`: low x, y, z of the children; `planes[3..6]`: high x, y, z. In the tree's frame, widened: see
    /// [`margin`](crate::kernel::margin).
    pub planes: Planes,
    /// Where they are. The flattest come last, for a ray that meets a flat box is likely stopped by the surface that fills it:
    /// rays that look for any hit try the last child first.
    pub child: [Child; 8],
    /// The first block of the subtree.
    pub(super) first_block: u32,
}

impl Node {
    /// No children.
    pub const EMPTY: Self = Self {
        planes: [
            [f32::INFINITY; 8],
            [f32::INFINITY; 8],
            [f32::INFINITY; 8],
            [f32::NEG_INFINITY; 8],
            [f32::NEG_INFINITY; 8],
            [f32::NEG_INFINITY; 8],
        ],
        child: [Child::EMPTY; 8],
        first_block: 0,
    };

    /// Sorts the children by the share of their largest face in half the surface of their box, the flattest last.
    pub(super) fn sort(&mut self) {
        let old = *self;
        let [x, y, z, far_x, far_y, far_z] = &old.planes;
        let mut order: [u32; 8] = core::array::from_fn(|slot| {
            let [x, y, z] = [far_x[slot] - x[slot], far_y[slot] - y[slot], far_z[slot] - z[slot]];
            let faces = [x * y, y * z, z * x];
            let share = faces.into_iter().fold(0.0, f32::max) / (faces[0] + faces[1] + faces[2]);
            // Floats that are not negative are in the order of their bits; the last three make room for the slot.
            share.to_bits() & !7 | slot as u32
        });
        order.sort_unstable();
        for (slot, from) in order.into_iter().enumerate() {
            let from = from as usize % 8;
            for (row, old) in self.planes.iter_mut().zip(&old.planes) {
                row[slot] = old[from];
            }
            self.child[slot] = old.child[from];
        }
    }

    /// Puts a child at `slot`.
    pub fn set(&mut self, slot: usize, bounds: &Bounds, child: Child) {
        for axis in 0..3 {
            self.planes[axis][slot] = bounds.low[axis];
            self.planes[axis + 3][slot] = bounds.high[axis];
        }
        self.child[slot] = child;
    }
}

#[cfg(test)]
mod tests {
    use alloc::vec::Vec;

    use super::*;

    #[test]
    fn the_flattest_child_comes_last() {
        let mut node = Node::EMPTY;
        let boxes = [[1.0, 1.0, 1.0], [4.0, 0.1, 4.0], [1.0, 1.0, 0.0], [2.0, 1.0, 2.0]];
        for (slot, high) in boxes.into_iter().enumerate() {
            let [x, y, z] = high;
            node.set(slot, &Bounds { low: [0.0; 4], high: [x, y, z, 0.0] }, Child::node(slot + 1));
        }
        node.sort();
        let met = (0..8).filter(|&slot| node.child[slot] != Child::EMPTY);
        let order: Vec<_> =
            met.map(|slot| (node.child[slot].index(), [3, 4, 5].map(|row| node.planes[row][slot]))).collect();
        assert_eq!(order, [(1, boxes[0]), (4, boxes[3]), (2, boxes[1]), (3, boxes[2])]);
    }
}
