//! Values by place, and their ranges by node.

use alloc::borrow::Cow;
use alloc::vec::Vec;

use crate::NO_HIT;
use crate::bvh::Bvh;
use crate::leaf::{BLOCK, Block as _, SphereBlock};

/// Values of one attribute.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// Quantities.
    F32(Vec<f32>),
    /// Kinds, flags.
    U8(Vec<u8>),
}

impl Values {
    /// How many there are.
    pub fn len(&self) -> usize {
        match self {
            Self::F32(values) => values.len(),
            Self::U8(values) => values.len(),
        }
    }

    /// Are there none?
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// All of them as floats.
    pub fn to_f32(&self) -> Cow<'_, [f32]> {
        match self {
            Self::F32(values) => Cow::Borrowed(values),
            Self::U8(values) => Cow::Owned(values.iter().map(|&value| value.into()).collect()),
        }
    }

    /// Value `i`; NaN if there is none.
    #[inline]
    pub fn get(&self, i: usize) -> f32 {
        match self {
            Self::F32(values) => values.get(i).copied().unwrap_or(f32::NAN),
            Self::U8(values) => values.get(i).map_or(f32::NAN, |&value| value.into()),
        }
    }
}

/// Least and greatest level of the values in each child of a node: the other way round where there is none.
type Levels = [[u8; 8]; 2];

/// An attribute of the spheres of a tree.
#[derive(Clone, Debug)]
pub(super) struct Attribute {
    /// By place.
    values: Values,
    /// Least and greatest finite value.
    range: Option<[f32; 2]>,
    /// Level 0, and levels for each unit of the value.
    low: f32,
    per_unit: f32,
    /// By node.
    levels: Vec<Levels>,
}

impl Attribute {
    /// Of values by id, which become those by place.
    pub(super) fn new(bvh: &Bvh<SphereBlock>, values: Values) -> Self {
        let ids = || (0..).zip(&bvh.leaves).flat_map(|(number, block)| block.ids(number).map(|id| id as usize));
        let values = match values {
            Values::F32(values) => Values::F32(ids().map(|id| values.get(id).copied().unwrap_or(f32::NAN)).collect()),
            Values::U8(values) => Values::U8(ids().map(|id| values.get(id).copied().unwrap_or(0)).collect()),
        };
        let used = ids().enumerate().filter(|&(_, id)| id != NO_HIT as usize).map(|(place, _)| values.get(place));
        let ends = used.filter(|value| value.is_finite()).map(|value| [value; 2]);
        let range = ends.reduce(|[low, high], [value, _]| [low.min(value), high.max(value)]);
        let [low, high] = match &values {
            Values::F32(_) => range.unwrap_or_default(),
            Values::U8(_) => [0.0, 255.0],
        };
        let mut attribute = Self { values, range, low, per_unit: 255.0 / (high - low), levels: Vec::new() };
        attribute.levels = attribute.levels_of(bvh);
        attribute
    }

    /// Bottom up: nodes stand before their children.
    fn levels_of(&self, bvh: &Bvh<SphereBlock>) -> Vec<Levels> {
        let mut levels = alloc::vec![[[u8::MAX; 8], [0; 8]]; bvh.nodes.len()];
        for at in (0..levels.len()).rev() {
            for (slot, child) in bvh.nodes[at].child.into_iter().enumerate() {
                let (mut least, mut greatest) = (u8::MAX, 0);
                if child.is_leaf() {
                    // No child is a leaf without values.
                    let blocks = child.leaf_range();
                    for place in blocks.start * BLOCK..blocks.end * BLOCK {
                        let value = self.values.get(place);
                        if !value.is_nan() {
                            let level = self.level(value);
                            (least, greatest) = (least.min(level), greatest.max(level));
                        }
                    }
                } else {
                    let [low, high] = levels[child.index()];
                    (least, greatest) = (least_of(low), greatest_of(high));
                }
                (levels[at][0][slot], levels[at][1][slot]) = (least, greatest);
            }
        }
        levels
    }

    /// The level of a value, which never falls where values rise: so what lies between two values lies between their levels.
    pub(super) fn level(&self, value: f32) -> u8 {
        ((value - self.low) * self.per_unit) as u8
    }

    #[inline]
    pub(super) fn value(&self, place: usize) -> f32 {
        self.values.get(place)
    }

    /// Values that are bytes.
    pub(super) fn bytes_by_place(&self) -> Option<&[u8]> {
        match &self.values {
            Values::U8(values) => Some(values),
            Values::F32(_) => None,
        }
    }

    pub(super) fn range(&self) -> Option<[f32; 2]> {
        self.range
    }

    pub(super) fn bytes(&self) -> usize {
        let each = if matches!(self.values, Values::F32(_)) { 4 } else { 1 };
        self.values.len() * each + self.levels.len() * size_of::<Levels>()
    }

    /// Which children of a node may have values between two levels, a bit each.
    #[inline(always)]
    pub(super) fn children_between(&self, node: usize, [low, high]: [u8; 2]) -> u32 {
        let Some([least, greatest]) = self.levels.get(node) else { return 0 };
        (0..8).fold(0, |met, slot| met | u32::from(least[slot] <= high && low <= greatest[slot]) << slot)
    }

    /// Which spheres of a block have values between two, a bit each.
    #[inline(always)]
    pub(super) fn spheres_between(&self, block: usize, [low, high]: [f32; 2]) -> u32 {
        let mut met = 0;
        for i in 0..BLOCK {
            let value = self.values.get(block * BLOCK + i);
            met |= u32::from(low <= value && value <= high) << i;
        }
        met
    }
}

fn least_of(levels: [u8; 8]) -> u8 {
    levels.into_iter().fold(u8::MAX, u8::min)
}

fn greatest_of(levels: [u8; 8]) -> u8 {
    levels.into_iter().fold(0, u8::max)
}
