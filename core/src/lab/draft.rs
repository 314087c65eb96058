//! A case before it is poured into a packet of some width: rays, primitives, the active range.

use alloc::vec::Vec;
use core::ops::Range;

use crate::{Properties, oracle};

/// A ray in rows.
#[derive(Clone, Copy, Debug)]
pub struct DraftRay {
    /// Origin.
    pub origin: [f32; 3],
    /// Direction.
    pub direction: [f32; 3],
    /// Near end of the interval.
    pub t_min: f32,
    /// Far end of the interval.
    pub t_max: f32,
}

impl DraftRay {
    /// The ray in `f64`.
    pub fn exact(&self) -> oracle::ExactRay {
        let ray = oracle::ExactRay::new(self.origin, self.direction);
        oracle::ExactRay { t_min: f64::from(self.t_min), t_max: f64::from(self.t_max), ..ray }
    }
}

/// What a kernel is run on.
#[derive(Clone, Debug)]
pub struct Draft<P> {
    /// Rays, the inactive ones too.
    pub rays: Vec<DraftRay>,
    /// Which of them are active.
    pub range: Range<usize>,
    /// Primitives; their ids are their places.
    pub primitives: Vec<P>,
    /// What is true of the active rays.
    pub promises: Properties,
}

impl<P> Draft<P> {
    /// Bends the directions until the promises are true.
    pub(super) fn keep_promises(&mut self, parallel: bool) {
        let Some(first) = self.rays.get(self.range.start).or(self.rays.first()).copied() else { return };
        for ray in &mut self.rays {
            if parallel {
                // As seen from a plane: the packet's image stays, where the first ray went.
                if ray.origin == first.origin {
                    ray.origin = [0, 1, 2].map(|k| first.origin[k] + 4.0 * (ray.direction[k] - first.direction[k]));
                }
                ray.direction = first.direction;
            }
            let d = &mut ray.direction;
            if self.promises.contains(Properties::NORMALIZED_DIRECTIONS) {
                let length = libm::sqrt(d.iter().map(|&x| f64::from(x) * f64::from(x)).sum());
                let unit = d.map(|x| (f64::from(x) / length) as f32);
                // NaN and infinities stay; what has no direction gets one.
                *d = if length > 0.0 { unit } else { [1.0, 0.0, 0.0] };
            }
            if self.promises.contains(Properties::CONSTANT_SIGNS) {
                for (x, like) in ray.direction.iter_mut().zip(first.direction) {
                    *x = x.copysign(like);
                }
            }
        }
    }
}
