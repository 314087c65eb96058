//! Surfaces of equal value as walks see them: the nodes that such a surface passes through.

use super::brick::CELLS;
use super::field::Field;
use super::layout::Layout;
use crate::bvh::{Child, Node, Tree};
use crate::kernel::margin::{Frame, PAD, larger};
use crate::leaf::Leaf;

/// The surfaces of some iso values in a field: the id of what is hit is the number of the iso value. Rays are in units of cells:
/// sample (i, j, k) is at (i, j, k).
#[derive(Clone, Copy)]
pub struct IsoTree<'a> {
    pub(super) field: &'a dyn Field,
    pub(super) values: &'a [f32],
}

impl<'a> IsoTree<'a> {
    /// The surfaces where the field has one of these values. What is at least as great is on one side, what is less on the other; NaN
    /// is nowhere.
    pub fn new(field: &'a dyn Field, values: &'a [f32]) -> Self {
        Self { field, values }
    }

    pub(super) fn layout(&self) -> &Layout {
        self.field.layout()
    }
}

impl core::fmt::Debug for IsoTree<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("IsoTree").field("values", &self.values).finish_non_exhaustive()
    }
}

impl Tree for IsoTree<'_> {
    type Leaves = Self;

    fn leaves(&self) -> &Self {
        self
    }

    fn frame(&self) -> &Frame {
        self.layout().frame()
    }

    fn root(&self) -> Child {
        self.layout().root()
    }

    #[inline(never)]
    fn node<'a>(&'a self, index: usize, room: &'a mut Node) -> Option<&'a Node> {
        let layout = self.layout();
        let (level, at) = layout.node(index);
        let below = level.checked_sub(1)?;
        let [low, high] = self.field.ranges(below, at);
        let frame = layout.frame();
        for axis in 0..3 {
            let (size, cells) = (CELLS[axis] << below, layout.cells(axis));
            let mut ends = [[0.0; 2]; 2];
            for (half, ends) in ends.iter_mut().enumerate() {
                let first = (2 * at[axis] + half) * size;
                let a = first.min(cells) as f32 - frame.center[axis];
                let b = (first + size).min(cells) as f32 - frame.center[axis];
                let margin = larger(a.abs(), b.abs()) * PAD;
                *ends = [a - margin, b + margin];
            }
            for slot in 0..8 {
                let [low, high] = ends[slot >> axis & 1];
                (room.planes[axis][slot], room.planes[axis + 3][slot]) = (low, high);
            }
        }
        let mut passed = 0;
        for &value in self.values {
            for slot in 0..8 {
                passed |= u32::from(low[slot] < value && value <= high[slot]) << slot;
            }
        }
        for slot in 0..8 {
            room.child[slot] = Child::EMPTY;
            if passed >> slot & 1 == 1 {
                let (x, y, z) = (slot & 1, slot >> 1 & 1, slot >> 2);
                room.child[slot] = layout.child(below, [2 * at[0] + x, 2 * at[1] + y, 2 * at[2] + z]);
            } else {
                (room.planes[0][slot], room.planes[3][slot]) = (f32::INFINITY, f32::NEG_INFINITY);
            }
        }
        Some(room)
    }

    #[inline(always)]
    fn prefetch(&self, child: Child) {
        if child.is_leaf() {
            Leaf::prefetch(self, child.leaf_range());
        }
    }

    fn leaf(&self, i: usize) -> Option<Child> {
        self.layout().nth_brick(i)
    }
}
