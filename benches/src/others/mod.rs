//! Further peers, which trace one ray at a time.
//!
//! | file | what it calls |
//! |---|---|
//! | `obvhs.rs` | the crate `obvhs` |
//! | `plain.rs` | the crate `bvh` |
//!
//! `tinybvh-rs` (0.1.0-beta.3) builds, but its queries crash.

#[cfg(feature = "peers")]
mod obvhs;
#[cfg(feature = "peers")]
mod plain;

use crate::rays::{Found, Kind, NOTHING, RaySet};
use crate::scenes::Primitives;

/// A library beside Embree.
pub trait Other {
    /// Its name, and how it was asked.
    fn name(&self) -> &'static str;

    /// Its timed loop over all rays.
    fn trace(&self, kind: Kind, rays: &RaySet, found: &mut Found);
}

/// Those that were compiled, each with its tree over these triangles; they know no spheres.
pub fn all(primitives: &Primitives) -> Vec<Box<dyn Other>> {
    let mut all: Vec<Box<dyn Other>> = Vec::new();
    #[cfg(feature = "peers")]
    if let Primitives::Triangles(triangles) = primitives {
        all.push(Box::new(obvhs::Obvhs::new(triangles)));
        all.push(Box::new(plain::Plain::new(triangles)));
    }
    // Without the feature nobody is there to look at them.
    let _ = (primitives, &mut all);
    all
}

/// Stores what a ray found: a triangle and where, or nothing.
#[inline(always)]
#[cfg_attr(not(feature = "peers"), allow(dead_code, reason = "the peers are what calls it"))]
fn store(kind: Kind, found: &mut Found, i: usize, t_max: f32, hit: Option<(u32, f32)>) {
    let (primitive, t) = hit.unwrap_or((NOTHING, t_max));
    found.primitive[i] = primitive;
    found.t[i] = if kind.any_hit() && hit.is_some() { f32::NEG_INFINITY } else { t };
}
