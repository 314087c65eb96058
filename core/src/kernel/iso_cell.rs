//! Ray/iso-surface in a trilinear cell: the first root of the cubic along the ray.
//!
//! After Marmitt, Kleer, Wald, Friedrich and Slusallek, "Fast and Accurate Ray-Voxel Intersection Techniques for
//! Iso-Surface Ray Tracing", VMV 2004: the field along the ray is a cubic; its derivative's roots part it into at most
//! three monotone pieces; the first piece that changes sign holds the first root. So a ray that crosses the surface
//! twice inside a cell is found to. We depart in one way: the root is closed in on by a fixed number of halvings and then
//! of Newton steps that may not leave what the halvings left, so that every lane does the same, at every level. After 12
//! halvings either Newton's steps square the error, or the field is so flat there that the root is not known to 2^-12 of
//! the cell anyway.
//!
//! - NaN: a NaN in the ray or the cell is missed.
//! - Zero direction: missed, as an empty interval or a constant field.
//! - Degenerate: a cell that is constant is missed, one that is zero throughout too.
//! - Grazing: a field that touches zero without changing sign may be missed or hit. A zero counts as positive, so of two
//!   cells with a common face, one has the crossing on it, as long as both work out the same values there; they do up to
//!   the rounding of the entry point.

use mobula_simd::{F32Lanes, MaskLanes, Token};

use super::aabb::aabb;

/// Halvings before Newton's steps.
const HALVINGS: usize = 12;
/// Newton's steps.
const STEPS: usize = 2;

/// Coefficients of 1, x, y, z, xy, yz, zx, xyz of the field in a unit cell, less the iso value. `values[i]` is that of the
/// corner whose x, y, z are bits 0, 1, 2 of `i`.
pub fn coefficients(values: &[f32; 8], iso: f32) -> [f32; 8] {
    let [v0, vx, vy, vxy, vz, vzx, vyz, vxyz] = *values;
    let (x, y, z) = (vx - v0, vy - v0, vz - v0);
    let (xy, yz, zx) = ((vxy - vy) - x, (vyz - vz) - y, (vzx - vz) - x);
    [v0 - iso, x, y, z, xy, yz, zx, (vxyz - vyz) - (vzx - vz) - xy]
}

/// Tests the cell in the lanes `active`. `origin`, `direction` and its reciprocal are in units of the cell, whose low
/// corner is at 0. Returns which lanes hit within `(t_min, t_max]`, and where first.
#[expect(clippy::too_many_arguments, reason = "a ray and a cell")]
#[inline(always)]
pub fn iso_cell<T: Token>(
    token: T,
    active: T::Mask,
    field: &[T::F32; 8],
    origin: [T::F32; 3],
    direction: [T::F32; 3],
    inverse: [T::F32; 3],
    t_min: T::F32,
    t_max: T::F32,
) -> (T::Mask, T::F32) {
    let (zero, one, half) = (token.splat(0.0), token.splat(1.0), token.splat(0.5));
    let to_low = [-origin[0], -origin[1], -origin[2]];
    let to_high = [one - origin[0], one - origin[1], one - origin[2]];
    let (inside, near) = aabb(token, to_low, to_high, inverse, t_min, t_max);
    let inside = active & inside;
    if !inside.any() {
        return (inside, zero);
    }
    // Where it leaves: as `aabb` finds it.
    let mut far = t_max;
    for axis in 0..3 {
        far = (to_low[axis] * inverse[axis]).max(to_high[axis] * inverse[axis]).min(far);
    }
    let length = far - near;
    let cubic = along(field, origin, direction, near, length);
    // The monotone pieces: 0, low, high, 1. What is not a root, or not between, becomes an end.
    let [d, c, b, a] = cubic;
    let three_a = a * token.splat(3.0);
    let root = b.mul_sub(b, three_a * c).sqrt();
    let sum = -(b + (-root).select(b.lt(zero), root));
    let (first, second) = (sum / three_a, c / sum);
    let first = first.max(zero).min(one);
    let second = second.max(zero).min(one);
    let (low, high) = (first.min(second), first.max(second));
    // A value that is zero counts as positive; NaN does too, so that nothing changes sign.
    let negative = [d.lt(zero), at(cubic, low).lt(zero), at(cubic, high).lt(zero), at(cubic, one).lt(zero)];
    let mut crossed = [
        inside & (negative[0] ^ negative[1]),
        inside & (negative[1] ^ negative[2]),
        inside & (negative[2] ^ negative[3]),
    ];
    let mut hit = token.mask(0);
    let mut t = zero;
    // Once, except where a first root is not within the interval: it starts on the surface.
    while (crossed[0] | crossed[1] | crossed[2]).any() {
        let zeroth = crossed[0];
        let middle = crossed[1].and_not(zeroth);
        let last = crossed[2].and_not(zeroth | middle);
        let from = zero.select(zeroth, low.select(middle, high));
        let to = low.select(zeroth, high.select(middle, one));
        let sign = (negative[0] & zeroth) | (negative[1] & middle) | (negative[2] & last);
        let u = close_in(cubic, from, to, sign, [zero, half]);
        let here = u.mul_add(length, near).min(far);
        let found = (zeroth | middle | last) & here.gt(t_min) & here.le(t_max);
        t = here.select(found, t);
        hit = hit | found;
        crossed = [token.mask(0), crossed[1].and_not(middle | found), crossed[2].and_not(last | found)];
    }
    (hit, t)
}

/// Coefficients, from the constant up, of the field along the ray from `near` on, over `length`.
#[inline(always)]
fn along<F: F32Lanes>(field: &[F; 8], origin: [F; 3], direction: [F; 3], near: F, length: F) -> [F; 4] {
    let [k, kx, ky, kz, kxy, kyz, kzx, kxyz] = *field;
    let x = direction[0].mul_add(near, origin[0]);
    let y = direction[1].mul_add(near, origin[1]);
    let z = direction[2].mul_add(near, origin[2]);
    let [dx, dy, dz] = [direction[0] * length, direction[1] * length, direction[2] * length];
    let (xy, yz, zx) = (kxyz.mul_add(z, kxy), kxyz.mul_add(x, kyz), kxyz.mul_add(y, kzx));
    // The gradient; its first part needs no y twice.
    let gx = xy.mul_add(y, kzx.mul_add(z, kx));
    let gy = yz.mul_add(z, kxy.mul_add(x, ky));
    let gz = zx.mul_add(x, kyz.mul_add(y, kz));
    let value = gx.mul_add(x, kyz.mul_add(y, kz).mul_add(z, ky.mul_add(y, k)));
    let (dxy, dyz, dzx) = (dx * dy, dy * dz, dz * dx);
    [value, gz.mul_add(dz, gy.mul_add(dy, gx * dx)), zx.mul_add(dzx, yz.mul_add(dyz, xy * dxy)), kxyz * (dxy * dz)]
}

/// The cubic's value.
#[inline(always)]
fn at<F: F32Lanes>([d, c, b, a]: [F; 4], u: F) -> F {
    a.mul_add(u, b).mul_add(u, c).mul_add(u, d)
}

/// The root of the cubic in a piece where it changes sign; `negative` at its start.
#[inline(always)]
fn close_in<F: F32Lanes>(cubic: [F; 4], from: F, to: F, negative: F::Mask, [zero, half]: [F; 2]) -> F {
    let (mut low, mut high) = (from, to);
    for _ in 0..HALVINGS {
        let middle = (low + high) * half;
        let other = at(cubic, middle).lt(zero) ^ negative;
        high = middle.select(other, high);
        low = low.select(other, middle);
    }
    let [_, c, b, a] = cubic;
    let (two_b, three_a) = (b + b, a + a + a);
    let mut u = (low + high) * half;
    for _ in 0..STEPS {
        let slope = three_a.mul_add(u, two_b).mul_add(u, c);
        u = (u - at(cubic, u) / slope).max(low).min(high);
    }
    u
}
