//! Ray/triangle, watertight.
//!
//! Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013. The ray is sheared onto its dominant
//! axis; what is left is a planar question about three points, the same points for every triangle that shares them.
//! We depart in three ways. (1) A computed edge function is `round(p) - round(q)` of two products: it may be zero where the
//! truth is not, but never has the wrong sign; so a zero counts as inside for both neighbours and no ray passes between.
//! (2) We go to f64, where the products are exact, not at every zero, but where the edge functions are too rough to be
//! weights: the point that they weigh together must lie on the ray, up to [`OFF`]. This finds triangles that are needles,
//! seen edge-on, or tiny and elsewhere, for which f32 gives any answer and any distance; and it is what lets traversal
//! trust that a hit lies in the triangle's box. (3) Both sides of a triangle are hit, so no winding is kept.
//!
//! - NaN: a ray or triangle with a NaN is missed.
//! - Zero direction (or one below 2^-102, see [`Rays::shears`](crate::Rays::shears)): missed (its shear is NaN).
//! - Degenerate triangle (its area is zero in the sheared plane): missed.
//! - Grazing: a ray through an edge or vertex hits every triangle that has it; ties go to the lowest id.
//!
//! Where products of coordinates overflow, the test goes to f64 as well.
//!
//! A ray that starts on a triangle meets it at t = 0, which is not in an interval from 0 on; but rounding makes any small number of
//! that. So a distance that rounding alone can have made is 0: hits that are very near, for the size of the triangle's coordinates
//! relative to the origin, go to f64, where it is known how far off the depth may be because corners were rounded when they were
//! moved and sheared (`ROUNDED`). It holds at every level, and takes nothing from a ray that starts at any distance that its
//! coordinates can tell from 0. Only a ray that goes on nearly in the triangle's plane, or starts on a needle,
//! may hit it farther on.

use mobula_simd::{F32Lanes, MaskLanes, Token};

/// A ray as the test wants it: axes permuted so that the dominant one is last.
#[derive(Clone, Copy, Debug)]
pub struct ShearedRay<F> {
    /// `d[x] / d[z]` and `d[y] / d[z]`, see [`Rays::shears`](crate::Rays::shears).
    pub shear: [F; 2],
    /// `1 / d[z]`, the reciprocal of the direction along the dominant axis: `t` of a depth of 1.
    pub inverse_forward: F,
    /// Near end of the interval, not in it.
    pub t_min: F,
    /// Far end of the interval, in it.
    pub t_max: F,
}

/// How far off the ray a hit may be weighed together, as a fraction of the size of the triangle's coordinates relative
/// to the ray's origin; see [`crate::traverse`] for what becomes of it.
pub const OFF: f32 = 1.0 / (1 << 20) as f32;

/// Depths of less than this fraction of the size of the triangle's coordinates may be 0.
pub const NEAR: f32 = 1.0 / (1 << 21) as f32;
/// Depths of less than this fraction of the size of one corner's coordinates are looked at.
const LOOK: f32 = 1.0 / (1 << 18) as f32;
/// By how much of its size a coordinate of a corner may be off: four roundings, twice.
const ROUNDED: f64 = 8.0 / (1 << 24) as f64;

/// Products outside of this range may have lost bits to underflow, or everything to overflow.
const PRECISE: [f32; 2] = [1e-30, 1e38];

/// Tests the triangle `corners` (relative to the ray's origin, axes permuted like the ray's) in the lanes `active`. Returns
/// which of them hit, and their distances (meaningless in the others). Where `SKIP`, the rest is left out if all lanes are outside
/// of the triangle: a gain where that is foreseen, and a loss where it is the case every other time (as after a test of bounds) and
/// the vector is wide.
#[inline(always)]
pub fn triangle<T: Token, const SKIP: bool>(
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
    // All of one sign: one comparison for `least >= 0 or greatest <= 0`. Both are NaN, or neither is.
    let (least, greatest) = (u.min(v).min(w), u.max(v).max(w));
    let inside = active & least.max(-greatest).ge(zero);
    if (SKIP || T::LANES < 8) && !inside.any() {
        return (inside, zero);
    }
    let det = u + v + w;
    let depth = w.mul_add(c[2], v.mul_add(b[2], u * a[2]));
    let t = depth / det * ray.inverse_forward;
    let ahead = inside & t.gt(ray.t_min);
    let hit = ahead & t.le(ray.t_max);
    // The weights' point, times `det`.
    let off_x = w.mul_add(cx, v.mul_add(bx, u * ax)).abs();
    let off_y = w.mul_add(cy, v.mul_add(by, u * ay)).abs();
    let off = off_x.max(off_y) * token.splat(1.0 / OFF);
    // One corner is a size at hand, but too small a one for rays that start close to it.
    let size = a[2].abs().max(ax.abs()).max(ay.abs()) * det.abs();
    // Whatever the end of the interval, which what else is hit moves.
    let near = ahead & depth.abs().lt(size * token.splat(LOOK));
    let rough = inside.and_not(off.lt(size) & is_precise(token, size)) | near;
    if !rough.any() {
        return (hit, t);
    }
    // Another one is too small only on tiny triangles.
    let size = c[2].abs().max(bx.abs()).max(by.abs()) * det.abs();
    let rough = rough.and_not(off.lt(size) & is_precise(token, size)) | near;
    if !rough.any() {
        return (hit, t);
    }
    let values = [ax, ay, bx, by, cx, cy, a[2], b[2], c[2], ray.inverse_forward, ray.t_min, ray.t_max];
    let mut lanes = [[0.0; 16]; 12];
    for (out, value) in lanes.iter_mut().zip(values) {
        value.store(out, 0);
    }
    let (exact, distance) = in_f64(rough.bits(), &lanes);
    (hit.and_not(rough) | token.mask(exact), token.load(&distance, 0).select(rough, t))
}

/// Is a product, and what it is measured against, in the range where f32 keeps all its bits?
#[inline(always)]
fn is_precise<T: Token>(token: T, size: T::F32) -> T::Mask {
    size.gt(token.splat(PRECISE[0])) & size.lt(token.splat(PRECISE[1]))
}

/// The test again for the lanes `bits`, whose edge functions are too rough in f32. The sheared corners stay as they are;
/// products of two of them are exact in f64. `lanes`: ax, ay, bx, by, cx, cy, the depths of a, b, c, then the ray's
/// inverse_forward, t_min and t_max.
#[cold]
#[inline(never)]
fn in_f64(bits: u32, lanes: &[[f32; 16]; 12]) -> (u32, [f32; 16]) {
    let mut hit = 0;
    let mut t = [0.0; 16];
    for i in (0..16).filter(|i| bits >> i & 1 != 0) {
        let [ax, ay, bx, by, cx, cy, az, bz, cz, inverse_forward, t_min, t_max] = lanes.map(|lane| f64::from(lane[i]));
        let (u, v, w) = (cx * by - cy * bx, ax * cy - ay * cx, bx * ay - by * ax);
        let inside = (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0);
        let (depth, det) = (u * az + v * bz + w * cz, u + v + w);
        // How much the depth changes by x and y, times `det`.
        let by_x = ((bz - az) * (cy - ay) - (cz - az) * (by - ay)).abs();
        let by_y = ((cz - az) * (bx - ax) - (bz - az) * (cx - ax)).abs();
        let off = |weight: f64, x: f64, y: f64, z: f64| {
            let (x, y, z) = (x.abs(), y.abs(), z.abs());
            weight.abs() * (z * det.abs() + (x + z) * by_x + (y + z) * by_y)
        };
        let off = ROUNDED * (off(u, ax, ay, az) + off(v, bx, by, bz) + off(w, cx, cy, cz));
        // A triangle that is seen edge-on is at any depth; boxes are not widened by more.
        let size = [ax, ay, az, bx, by, bz, cx, cy, cz].iter().fold(0.0, |size: f64, x| size.max(x.abs()));
        let off = off.min(f64::from(NEAR) * size * det * det);
        t[i] = if depth.abs() * det.abs() < off { 0.0 } else { (depth / det * inverse_forward) as f32 };
        if inside && f64::from(t[i]) > t_min && f64::from(t[i]) <= t_max {
            hit |= 1 << i;
        }
    }
    (hit, t)
}
