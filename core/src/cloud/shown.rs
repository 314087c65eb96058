//! The tree of what is shown, as walks see it.

use alloc::vec::Vec;

use super::attribute::Attribute;
use crate::bvh::{Bvh, Child, Node, Tree};
use crate::kernel::margin::Frame;
use crate::leaf::{Blocks, Places, SphereBlock};

/// Of a cloud, what has certain values.
#[derive(Clone, Debug, PartialEq)]
pub struct Crop {
    /// The number of the attribute. One that is not there crops everything.
    pub attribute: usize,
    /// From the least to the greatest value that is shown, both included; several intervals, if what is between them is not. What is NaN
    /// is not shown.
    pub ranges: Vec<[f32; 2]>,
}

/// Crops that are ready for a cloud. Only what all of them show is shown; without any, all is.
#[derive(Clone, Debug, Default)]
pub struct Crops {
    all: Vec<(usize, Vec<Interval>)>,
}

/// Values that are shown, and their levels.
#[derive(Clone, Copy, Debug)]
struct Interval {
    values: [f32; 2],
    levels: [u8; 2],
}

impl Crops {
    pub(super) fn new(attributes: &[Attribute], crops: &[Crop]) -> Self {
        let ready = |Crop { attribute, ranges }: &Crop| {
            let interval = |&values: &[f32; 2]| {
                let of = attributes.get(*attribute)?;
                (values[0] <= values[1]).then(|| Interval { values, levels: values.map(|value| of.level(value)) })
            };
            (*attribute, ranges.iter().filter_map(interval).collect())
        };
        Self { all: crops.iter().map(ready).collect() }
    }

    /// What they leave of the children of a node.
    #[inline(always)]
    fn children(&self, attributes: &[Attribute], node: usize) -> u32 {
        let mut shown = u32::MAX;
        for (attribute, intervals) in &self.all {
            let Some(attribute) = attributes.get(*attribute) else { return 0 };
            shown &= intervals.iter().fold(0, |met, interval| met | attribute.children_between(node, interval.levels));
        }
        shown
    }

    /// What they leave of the spheres of a block.
    #[inline(always)]
    fn spheres(&self, attributes: &[Attribute], block: usize) -> u32 {
        let mut shown = u32::MAX;
        for (attribute, intervals) in &self.all {
            let Some(attribute) = attributes.get(*attribute) else { return 0 };
            shown &= intervals.iter().fold(0, |met, interval| met | attribute.spheres_between(block, interval.values));
        }
        shown
    }
}

/// What crops leave of a cloud.
#[derive(Clone, Copy, Debug)]
pub struct Shown<'a> {
    bvh: &'a Bvh<SphereBlock<Places>>,
    attributes: &'a [Attribute],
    crops: &'a Crops,
}

impl<'a> Shown<'a> {
    pub(super) fn new(bvh: &'a Bvh<SphereBlock<Places>>, attributes: &'a [Attribute], crops: &'a Crops) -> Self {
        Self { bvh, attributes, crops }
    }

    /// A node with some children left out.
    #[inline(never)]
    fn cropped<'b>(&self, index: usize, node: &'b Node, room: &'b mut Node) -> &'b Node {
        let shown = self.crops.children(self.attributes, index);
        if shown & 0xff == 0xff {
            return node;
        }
        *room = *node;
        for slot in (0..8).filter(|slot| shown >> slot & 1 == 0) {
            room.child[slot] = Child::EMPTY;
            (room.planes[0][slot], room.planes[3][slot]) = (f32::INFINITY, f32::NEG_INFINITY);
        }
        room
    }
}

impl Tree for Shown<'_> {
    type Leaves = Self;

    #[inline(always)]
    fn leaves(&self) -> &Self {
        self
    }

    #[inline(always)]
    fn frame(&self) -> &Frame {
        self.bvh.frame()
    }

    #[inline(always)]
    fn root(&self) -> Child {
        self.bvh.root()
    }

    #[inline(always)]
    fn node<'a>(&'a self, index: usize, room: &'a mut Node) -> Option<&'a Node> {
        let node = self.bvh.nodes.get(index)?;
        Some(if self.crops.all.is_empty() { node } else { self.cropped(index, node, room) })
    }

    #[inline(always)]
    fn prefetch(&self, child: Child) {
        Tree::prefetch(self.bvh, child);
    }

    #[inline(always)]
    fn leaf(&self, i: usize) -> Option<Child> {
        Tree::leaf(self.bvh, i)
    }
}

impl Blocks for Shown<'_> {
    type Block = SphereBlock<Places>;

    #[inline(always)]
    fn blocks(&self) -> &[SphereBlock<Places>] {
        &self.bvh.leaves
    }

    #[inline(always)]
    fn shown(&self, block: usize) -> u32 {
        if self.crops.all.is_empty() { u32::MAX } else { self.crops.spheres(self.attributes, block) }
    }
}
