//! Ray/triangle, watertight.
//!
//! Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013. The ray is sheared onto its dominant
//! axis; what is left is a planar question about three points, the same points for every triangle that shares them.
//! We depart in three ways. (1) A computed edge function is `round(p) - round(q)` of two products: it may be zero where the
//! truth is not, but never has the wrong sign; so a zero counts as inside for both neighbours and no ray passes between.
//! (2) Only when all three are zero do we go to f64, where the products are exact. (3) Both sides of a triangle are hit,
//! so no winding is kept.
//!
//! - NaN: a ray or triangle with a NaN is missed.
//! - Zero direction: missed (its shear is NaN).
//! - Degenerate triangle (its area is zero in the sheared plane): missed.
//! - Grazing: a ray through an edge or vertex hits every triangle that has it; ties go to the lowest id.
//!
//! Coordinates relative to the ray's origin must stay below 1e18, or products overflow and the triangle is missed.

use mobula_simd::{F32Lanes, MaskLanes, Token};

/// A ray as the test wants it: axes permuted so that the dominant one is last.
#[derive(Clone, Copy, Debug)]
pub struct ShearedRay<F> {
    /// `d[x] / d[z]` and `d[y] / d[z]`, see [`Rays::shears`](crate::Rays::shears).
    pub shear: [F; 2],
    /// `d[z]`, the direction along the dominant axis.
    pub forward: F,
    /// Near end of the interval, not in it.
    pub t_min: F,
    /// Far end of the interval, in it.
    pub t_max: F,
}

/// Tests the triangle `corners` (relative to the ray's origin, axes permuted like the ray's) in the lanes `active`. Returns
/// which of them hit, and their distances (meaningless in the others).
#[inline(always)]
pub fn triangle<T: Token>(
    token: T,
    active: T::Mask,
    corners: [[T::F32; 3]; 3],
    ray: &ShearedRay<T::F32>,
) -> (T::Mask, T::F32) {
    let zero = token.splat(0.0);
    let [a, b, c] = corners;
    let (ax, ay) = (ray.shear[0].neg_mul_add(a[2], a[0]), ray.shear[1].neg_mul_add(a[2], a[1]));
    let (bx, by) = (ray.shear[0].neg_mul_add(b[2], b[0]), ray.shear[1].neg_mul_add(b[2], b[1]));
    let (cx, cy) = (ray.shear[0].neg_mul_add(c[2], c[0]), ray.shear[1].neg_mul_add(c[2], c[1]));
    // Not fused, in both families: a fused difference of products can have the wrong sign on both sides of an edge.
    let u = cx * by - cy * bx;
    let v = ax * cy - ay * cx;
    let w = bx * ay - by * ax;
    let inside = active & (u.min(v).min(w).ge(zero) | u.max(v).max(w).le(zero));
    if !inside.any() {
        return (inside, zero);
    }
    let det = u + v + w;
    let t = w.mul_add(c[2], v.mul_add(b[2], u * a[2])) / (det * ray.forward);
    let mut hit = inside & t.gt(ray.t_min) & t.le(ray.t_max);
    let mut t = t;
    let flat = inside & det.eq(zero);
    if flat.any() {
        let values = [ax, ay, bx, by, cx, cy, a[2], b[2], c[2], ray.forward, ray.t_min, ray.t_max];
        let mut lanes = [[0.0; 16]; 12];
        for (out, value) in lanes.iter_mut().zip(values) {
            value.store(out, 0);
        }
        let (exact, distance) = in_f64(flat.bits(), &lanes);
        let exact = token.mask(exact);
        t = token.load(&distance, 0).select(exact, t);
        hit = hit.and_not(flat) | exact;
    }
    (hit, t)
}

/// The test again for the lanes `bits`, whose three edge functions are all zero in f32. The sheared corners stay as they
/// are; products of two of them are exact in f64. `lanes`: ax, ay, bx, by, cx, cy, the depths of a, b, c, then the
/// ray's forward, t_min and t_max.
#[cold]
#[inline(never)]
fn in_f64(bits: u32, lanes: &[[f32; 16]; 12]) -> (u32, [f32; 16]) {
    let mut hit = 0;
    let mut t = [0.0; 16];
    for i in (0..16).filter(|i| bits >> i & 1 != 0) {
        let [ax, ay, bx, by, cx, cy, az, bz, cz, forward, t_min, t_max] = lanes.map(|lane| f64::from(lane[i]));
        let (u, v, w) = (cx * by - cy * bx, ax * cy - ay * cx, bx * ay - by * ax);
        let inside = (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0);
        t[i] = ((u * az + v * bz + w * cz) / ((u + v + w) * forward)) as f32;
        if inside && f64::from(t[i]) > t_min && f64::from(t[i]) <= t_max {
            hit |= 1 << i;
        }
    }
    (hit, t)
}
