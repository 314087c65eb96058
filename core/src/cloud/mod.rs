//! Particles: spheres with attributes, of which those are shown whose attributes have certain values.
//!
//! A cloud is a [tree of spheres](crate::leaf::SphereBlock) with the least and the greatest value of each attribute for each child of a
//! node. So what is not shown is passed by, subtree by subtree, and what is shown may change with each frame: nothing is built anew.
//!
//! Spheres and values lie in the order of the tree. A sphere's id is its place there, four places a block; some, at the end, may be
//! unused. Nothing else is kept: with one attribute of floats a cloud takes some 28 bytes a sphere, 20 of which are data.
//!
//! | file | idea |
//! |---|---|
//! | `shown` | the tree of what is shown, as walks see it |
//! | `attribute` | values by place, and their ranges by node |

mod attribute;
mod shown;

use alloc::vec::Vec;

pub use attribute::Values;
pub use shown::{Crop, Crops, Shown};

use self::attribute::Attribute;
use crate::NO_HIT;
use crate::bvh::{Bvh, Join, Quality};
use crate::leaf::{BLOCK, Bounds, Places, SphereBlock};

/// Spheres with attributes.
#[derive(Clone, Debug)]
pub struct Cloud {
    bvh: Bvh<SphereBlock<Places>>,
    attributes: Vec<Attribute>,
}

impl Cloud {
    /// Of spheres `0..count` (`[x, y, z, radius]`), and the values of each attribute, as many. Spheres that are not finite or whose radius
    /// is not one of [`RADII`](crate::kernel::sphere::RADII) are left out.
    ///
    /// # Panics
    /// If there are 2^32 - 4 spheres or more, or an attribute has another number of values.
    pub fn build(
        count: usize,
        quality: Quality,
        join: &impl Join,
        sphere: impl Fn(usize) -> [f32; 4] + Sync,
        values: Vec<Values>,
    ) -> Self {
        assert!(count < (NO_HIT as usize) & !(BLOCK - 1), "more spheres than places");
        let bvh = Bvh::<SphereBlock>::build(count, 0, quality, join, sphere);
        let of = |values: Values| {
            assert_eq!(values.len(), count, "a value for each sphere");
            Attribute::new(&bvh, values)
        };
        let attributes = values.into_iter().map(of).collect();
        Self { bvh: bvh.with_blocks(SphereBlock::placed), attributes }
    }

    /// How many spheres there are: those given, less what was left out.
    pub fn len(&self) -> usize {
        self.bvh.primitives()
    }

    /// Are there none?
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// How many places there are: ids are less.
    pub fn places(&self) -> usize {
        self.bvh.leaves.len() * BLOCK
    }

    /// Centre and radius of the sphere at a place, `[x, y, z, radius]`; `None` if there is none.
    #[inline]
    pub fn sphere(&self, place: usize) -> Option<[f32; 4]> {
        let sphere = self.bvh.leaves.get(place / BLOCK)?.sphere(place % BLOCK);
        (!sphere[3].is_nan()).then_some(sphere)
    }

    /// How many attributes there are.
    pub fn attributes(&self) -> usize {
        self.attributes.len()
    }

    /// The value of an attribute at a place; NaN if there is none.
    #[inline]
    pub fn value(&self, attribute: usize, place: usize) -> f32 {
        self.attributes.get(attribute).map_or(f32::NAN, |attribute| attribute.value(place))
    }

    /// The least and the greatest finite value of an attribute; `None` if there is none.
    pub fn range(&self, attribute: usize) -> Option<[f32; 2]> {
        self.attributes.get(attribute)?.range()
    }

    /// Which values an attribute of bytes has, rising; `None` if it is of floats.
    pub fn kinds(&self, attribute: usize) -> Option<Vec<u8>> {
        let bytes = self.attributes.get(attribute)?.bytes_by_place()?;
        let mut there = [false; 256];
        let used = bytes.iter().enumerate().filter(|&(place, _)| self.sphere(place).is_some());
        used.for_each(|(_, &kind)| there[usize::from(kind)] = true);
        Some((0..=u8::MAX).filter(|&kind| there[usize::from(kind)]).collect())
    }

    /// Least and greatest corner of all spheres; `None` if there are none.
    pub fn bounds(&self) -> Option<Bounds> {
        let bounds = self.bvh.bounds();
        bounds.is_finite().then_some(bounds)
    }

    /// Bytes that it occupies.
    pub fn bytes(&self) -> usize {
        self.bvh.bytes() + self.attributes.iter().map(Attribute::bytes).sum::<usize>()
    }

    /// Readies crops for this cloud.
    pub fn crops(&self, crops: &[Crop]) -> Crops {
        Crops::new(&self.attributes, crops)
    }

    /// What crops, made ready by this cloud, leave of it, as a tree for rays.
    pub fn shown<'a>(&'a self, crops: &'a Crops) -> Shown<'a> {
        Shown::new(&self.bvh, &self.attributes, crops)
    }
}
