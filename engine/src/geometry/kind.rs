//! What a kind of geometry is, and what finds its hits.

use std::any::Any;
use std::fmt::Debug;
use std::sync::Arc;

use glam::{BVec3, Vec3};

use super::Census;
use crate::accel::Build;
use crate::packet::{EveryWidth, Surface};

/// "The scene's default material", as an index of a material. So does every index that is out of range.
pub const DEFAULT_MATERIAL: u32 = u32::MAX;

/// Primitives of one kind, numbered from 0: plain data that knows its surface and can have a structure built that finds its hits.
///
/// A geometry may be wrong in every way that a file can be wrong: indices out of range, NaN, zero area. Primitives that cannot be hit
/// are left out, which the census tells; they keep their numbers. Nothing panics.
pub trait Geometry: Surface + Any + Debug + Send + Sync {
    /// What people call it.
    fn name(&self) -> &str {
        ""
    }

    /// Number of primitives, those left out included; at most 2^32 - 1.
    fn primitives(&self) -> usize;

    /// Looks at every primitive: bounds, counts by name, and what is left out.
    fn census(&self) -> Census;

    /// The census of a geometry of which no primitive is left out, but for the bounds, if it takes no look at every primitive; the bounds
    /// are then those of its structure. `None` unless the kind knows better.
    fn counts(&self) -> Option<Census> {
        None
    }

    /// Calls `visit` with points that show how far the geometry reaches: cameras are placed so that they see all of them. The corners
    /// of the bounds, unless the kind knows better.
    fn extremes(&self, visit: &mut dyn FnMut(Vec3)) {
        let (low, high) = self.census().bounds;
        if low.cmple(high).all() {
            for corner in 0..8_u8 {
                visit(Vec3::select(BVec3::new(corner & 1 > 0, corner & 2 > 0, corner & 4 > 0), low, high));
            }
        }
    }

    /// As [`extremes`](Self::extremes), for one primitive of each `step`, [drawn](draw) from them: enough to tell where most are. All,
    /// unless the kind knows better.
    fn some_extremes(&self, _step: usize, visit: &mut dyn FnMut(Vec3)) {
        self.extremes(visit);
    }

    /// The index of the material that all primitives have, [`DEFAULT_MATERIAL`] unless the kind knows better; or, where they differ,
    /// `None`, and those of `primitives` in `out`.
    fn materials(&self, _primitives: &[u32], _out: &mut [u32]) -> Option<u32> {
        Some(DEFAULT_MATERIAL)
    }

    /// May any primitive have an [`opacity`](Self::opacity) below 1?
    fn is_translucent(&self) -> bool {
        false
    }

    /// The fraction of the light towards a primitive that it stops, 0 to 1, by which what its material stops is multiplied.
    fn opacity(&self, _primitive: u32) -> f32 {
        1.0
    }

    /// The same with `shift` added to all indices of materials but [`DEFAULT_MATERIAL`]: for scenes that are joined.
    fn shift_materials(self: Arc<Self>, shift: u32) -> Arc<dyn Geometry>;

    /// May geometries of this type have one structure together? It is faster than several.
    fn shares_structure(&self) -> bool {
        true
    }

    /// Builds what finds the hits of `members`: geometries of this type, this one first. Its ids are the numbers of all their
    /// primitives, one geometry after the other.
    fn structure(&self, members: &[Arc<dyn Geometry>], build: &Build) -> Box<dyn Structure>;
}

impl dyn Geometry {
    /// The geometry as what it is, if it is of that type.
    pub fn downcast_ref<G: Geometry>(&self) -> Option<&G> {
        (self as &dyn Any).downcast_ref()
    }
}

/// What finds the hits of one or several geometries.
pub trait Structure: EveryWidth + Debug + Send + Sync {
    /// Number of primitives that rays can hit. One without any is not asked.
    fn primitives(&self) -> usize;

    /// Bytes that it occupies.
    fn bytes(&self) -> usize;

    /// The bounds of all primitives, where it is known that none is left out. `None` unless the kind knows better.
    fn whole_bounds(&self) -> Option<(Vec3, Vec3)> {
        None
    }

    /// Could it [`refit`](Self::refit) to these?
    fn can_refit(&self, members: &[Arc<dyn Geometry>]) -> bool;

    /// Follows primitives that moved: the same ids, at new places. Much cheaper than to build anew, but rays get slower the more the
    /// primitives have changed places. What is not finite or has no area now is left out until it has.
    fn refit(&mut self, members: &[Arc<dyn Geometry>]);
}

/// One number of each `step` below `count`: it looks random which, as primitives come in patterns, but is the same each time.
pub fn draw(count: usize, step: usize) -> impl Iterator<Item = usize> {
    let lot = |number: usize| (number as u32 ^ 0x5bd1_e995).wrapping_mul(0x9e37_79b1) as usize >> 7;
    (0..count).step_by(step.max(1)).map(move |first| first + lot(first) % step.clamp(1, count - first))
}

/// Adds `shift` to an index of a material, unless it is [`DEFAULT_MATERIAL`].
pub fn shift_material(index: &mut u32, shift: u32) {
    if *index != DEFAULT_MATERIAL {
        *index = index.saturating_add(shift);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_of_each_step_is_drawn() {
        for (count, step) in [(0, 1), (1, 1), (100, 1), (100, 7), (1000, 64), (5, 9)] {
            let drawn: Vec<usize> = draw(count, step).collect();
            assert_eq!(drawn.len(), count.div_ceil(step));
            let in_step = |(i, &number): (usize, &usize)| number / step == i && number < count;
            assert!(drawn.iter().enumerate().all(in_step), "{count} {step}: {drawn:?}");
        }
        assert_eq!(draw(50, 1).collect::<Vec<_>>(), (0..50).collect::<Vec<_>>());
    }
}
