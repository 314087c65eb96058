//! What all active rays of a packet have in common: least and greatest origins, reciprocal directions and distances
//! (Boulos, Wald and Shirley, "Geometric and Arithmetic Culling Methods for Entire Ray Packets", Utah 2006).
//!
//! - NaN: passed over, on the left of `min` and `max`.
//! - No active rays: the intervals are empty.

use mobula_simd::{F32Lanes, Token};

use crate::Rays;

/// Intervals of a packet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PacketBounds {
    /// Least and greatest origin, by axis.
    pub origin: [[f32; 3]; 2],
    /// Least and greatest reciprocal direction, by axis.
    pub inverse: [[f32; 3]; 2],
    /// Least near end.
    pub t_min: f32,
    /// Greatest far end.
    pub t_max: f32,
}

/// Finds the bounds of the active rays, whose inverse directions have been derived. With `COMMON_ORIGIN` only the first
/// origin is looked at.
#[inline(always)]
pub fn packet_bounds<T: Token, const N: usize, const COMMON_ORIGIN: bool>(token: T, rays: &Rays<N>) -> PacketBounds {
    let (inf, minus_inf) = (token.splat(f32::INFINITY), token.splat(f32::NEG_INFINITY));
    let (mut least, mut greatest) = ([inf; 7], [minus_inf; 7]);
    let mut at = 0;
    while at < N {
        let active = rays.active(token, at);
        for axis in 0..3 {
            let inverse = token.load(&rays.inverse_columns()[axis][..], at);
            least[axis] = inverse.select(active, inf).min(least[axis]);
            greatest[axis] = inverse.select(active, minus_inf).max(greatest[axis]);
            if !COMMON_ORIGIN {
                let origin = token.load(&rays.origins()[axis][..], at);
                least[axis + 3] = origin.select(active, inf).min(least[axis + 3]);
                greatest[axis + 3] = origin.select(active, minus_inf).max(greatest[axis + 3]);
            }
        }
        least[6] = token.load(&rays.t_min()[..], at).select(active, inf).min(least[6]);
        greatest[6] = token.load(&rays.t_max[..], at).select(active, minus_inf).max(greatest[6]);
        at += T::LANES;
    }
    let mut bounds = PacketBounds {
        origin: [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]],
        inverse: [[0.0; 3]; 2],
        // Of two zeros, min and max take the later, which depends on the lanes; adding zero makes both positive.
        t_min: least[6].reduce_min() + 0.0,
        t_max: greatest[6].reduce_max() + 0.0,
    };
    for axis in 0..3 {
        bounds.inverse[0][axis] = least[axis].reduce_min() + 0.0;
        bounds.inverse[1][axis] = greatest[axis].reduce_max() + 0.0;
        if !COMMON_ORIGIN {
            bounds.origin[0][axis] = least[axis + 3].reduce_min() + 0.0;
            bounds.origin[1][axis] = greatest[axis + 3].reduce_max() + 0.0;
        } else if !rays.range().is_empty() {
            // Through the same comparisons, so that a NaN is passed over here too.
            let x = rays.origins()[axis][rays.range().start % N];
            bounds.origin[0][axis] = if x < f32::INFINITY { x + 0.0 } else { f32::INFINITY };
            bounds.origin[1][axis] = if x > f32::NEG_INFINITY { x + 0.0 } else { f32::NEG_INFINITY };
        }
    }
    bounds
}
