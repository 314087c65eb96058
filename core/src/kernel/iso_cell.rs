//! Ray/iso-surface in a trilinear cell: the first root of the cubic along the ray.
//!
//! After Marmitt, Kleer, Wald, Friedrich and Slusallek, "Fast and Accurate Ray-Voxel Intersection Techniques for
//! Iso-Surface Ray Tracing", VMV 2004: the field along the ray is a cubic; its derivative's roots part it into at most
//! three monotone pieces; the first piece that changes sign holds the first root. So a ray that crosses the surface
//! twice inside a cell is found to. We depart in one way: the root is where the chord, and then two of Newton's steps, lead to,
//! if the cubic has changed sign within 2^-20 of the cell of there: the piece is monotone, so that the root is no farther away.
//! In the others, one of sixty, it is closed in on by a fixed number of halvings and then of Newton steps that may not
//! leave what the halvings left. After 12 halvings either Newton's steps square the error, or the field is so flat there that the
//! root is not known to 2^-12 of the cell anyway. What a lane finds does not depend on the others, so it is the same at every level.
//!
//! **Watertight.** Cells of a grid are units with whole numbers for corners, so that neighbours agree on the numbers of the face
//! between them, bit for bit:
//!
//! - A ray meets the plane at k at `(k - origin) / direction`, whichever cell asks. It leaves a cell where it first leaves one of
//!   its slabs, and enters the neighbour there.
//! - The value at a face is interpolated along x, then y, then z, by `a (1 - f) + b f`, which is a or b where f is 0 or 1. So
//!   of a face's value no more is asked than the four corners that both cells have. A fraction is 0 or 1 where the ray meets
//!   that plane too, at an edge or a vertex: all cells around it have the value of the edge or the vertex.
//! - Values are less the iso value before they are weighed, and weights are not negative: if all corners of a face are on one
//!   side, so is the value, by its sign bit, whatever is rounded. So cells all of whose corners are on one side need not be asked.
//!
//! A ray that is on one side where it enters a row of cells and on the other where it leaves thus changes sides in one of them, and
//! is not lost. Cells that it only touches, where it leaves as it enters, need not be asked: both sides of them have the same value.
//!
//! - NaN: a NaN in the ray, or a corner that is not finite: not to be asked ([`RayLanes::sound`]).
//! - Zero direction: missed, as an empty interval or a constant field.
//! - Degenerate: a cell that is constant is missed, one that is zero throughout too.
//! - Grazing: a field that touches zero without changing sign may be missed or hit. Zero counts as positive.

use mobula_simd::{F32Lanes, I32Lanes, MaskLanes, Token};

use super::cell_walk::RayLanes;

/// Halvings before Newton's steps, where these alone do not lead to the root.
const HALVINGS: usize = 12;
/// How near the sign must have changed for a root to be there.
const NEAR: f32 = 1.0 / (1 << 20) as f32;
/// Newton's steps.
const STEPS: usize = 2;

/// The field along a ray in each lane, in the cell that it is in.
#[derive(Clone, Copy, Debug)]
pub struct FieldAlong<T: Token> {
    /// From the constant up, from 0 at `near` to 1 at `far`.
    cubic: [T::F32; 4],
    near: T::F32,
    far: T::F32,
    /// Is it negative there?
    ends: [T::Mask; 2],
}

/// Which lanes may hit.
#[derive(Clone, Copy, Debug)]
pub struct May<T: Token> {
    /// Within the cell, wherever in the ray's interval.
    pub hit: T::Mask,
    /// These do: there is a crossing, and all of the cell is within the interval.
    pub surely: T::Mask,
    /// If there is a crossing, it is within the interval.
    within: T::Mask,
}

/// Tests a cell a lane in the lanes `active`: the unit cell with the low corner `low`, in units of which the ray is. `corners[i]`
/// is the value, less the iso value, at the corner whose x, y, z are bits 0, 1, 2 of `i`; none is minus zero. Returns which lanes
/// hit within `(t_min, t_max]`, and where first; if `ANY` hit is enough, where is not worked out if it is within for sure.
#[inline(always)]
pub fn iso_cell<T: Token, const ANY: bool>(
    token: T,
    active: T::Mask,
    corners: &[T::F32; 8],
    low: [T::F32; 3],
    rays: &RayLanes<T>,
    t_max: T::F32,
) -> (T::Mask, T::F32) {
    let (may, along) = field_along(token, active, corners, low, rays, t_max);
    if !may.hit.any() {
        return (may.hit, token.splat(0.0));
    }
    along.first_root::<ANY>(token, may, rays.t_min, t_max)
}

/// The first part of [`iso_cell`]: which lanes may hit, and what else has to be known to say where.
#[inline(always)]
pub fn field_along<T: Token>(
    token: T,
    active: T::Mask,
    corners: &[T::F32; 8],
    low: [T::F32; 3],
    rays: &RayLanes<T>,
    t_max: T::F32,
) -> (May<T>, FieldAlong<T>) {
    let RayLanes { origin, direction, inverse, t_min } = *rays;
    let (zero, one) = (token.splat(0.0), token.splat(1.0));
    let mut planes = [[zero; 2]; 3];
    let (mut near, mut far) = (t_min, token.splat(f32::INFINITY));
    for axis in 0..3 {
        let a = (low[axis] - origin[axis]) * inverse[axis];
        let b = ((low[axis] + one) - origin[axis]) * inverse[axis];
        planes[axis] = [a, b];
        near = a.min(b).max(near);
        far = a.max(b).min(far);
    }
    let inside = active & near.lt(far) & near.le(t_max);
    let within = inside & near.gt(t_min) & far.le(t_max);
    let entry = fractions(token, &planes, low, origin, direction, near);
    let exit = fractions(token, &planes, low, origin, direction, far);
    let ends = [is_negative(token, weighed(one, corners, entry)), is_negative(token, weighed(one, corners, exit))];
    let cubic = along(&coefficients(corners), entry, direction, far - near);
    // Between the ends the cubic is within the hull of its Bernstein coefficients.
    let third = token.splat(1.0 / 3.0);
    let hull = [cubic[1].mul_add(third, cubic[0]), (cubic[1] + cubic[1] + cubic[2]).mul_add(third, cubic[0])];
    let crossing = ends[0] ^ ends[1];
    let mut undecided = crossing;
    for value in hull {
        undecided = undecided | (value.lt(zero) ^ ends[0]);
    }
    (May { hit: inside & undecided, surely: within & crossing, within }, FieldAlong { cubic, near, far, ends })
}

impl<T: Token> FieldAlong<T> {
    /// Of no ray.
    #[inline(always)]
    pub fn none(token: T) -> Self {
        let (zero, none) = (token.splat(0.0), token.mask(0));
        Self { cubic: [zero; 4], near: zero, far: zero, ends: [none; 2] }
    }

    /// In the lanes of a mask, another's.
    #[inline(always)]
    pub fn set(&mut self, mask: T::Mask, other: &Self) {
        for (mine, other) in self.cubic.iter_mut().zip(&other.cubic) {
            *mine = other.select(mask, *mine);
        }
        (self.near, self.far) = (other.near.select(mask, self.near), other.far.select(mask, self.far));
        for (mine, other) in self.ends.iter_mut().zip(other.ends) {
            *mine = mine.and_not(mask) | (other & mask);
        }
    }

    /// Of lanes that surely hit: where.
    #[inline(always)]
    pub fn sure_root(&self, token: T, among: T::Mask, t_min: T::F32, t_max: T::F32) -> (T::Mask, T::F32) {
        self.first_root::<false>(token, May { hit: among, surely: among, within: among }, t_min, t_max)
    }

    /// Which lanes hit, and where first.
    #[inline(always)]
    pub fn first_root<const ANY: bool>(
        &self,
        token: T,
        may: May<T>,
        t_min: T::F32,
        t_max: T::F32,
    ) -> (T::Mask, T::F32) {
        let Self { cubic, near, far, ends } = *self;
        let (zero, one) = (token.splat(0.0), token.splat(1.0));
        let length = far - near;
        let mut hit = if ANY { may.surely } else { token.mask(0) };
        let inside = may.hit.and_not(hit);
        if ANY && !inside.any() {
            return (hit, zero);
        }
        // The monotone pieces: 0, low, high, 1. What is not a root, or not between, becomes an end.
        let [_, c, b, a] = cubic;
        let three_a = a * token.splat(3.0);
        let root = b.mul_sub(b, three_a * c).sqrt();
        let sum = -(b + (-root).select(b.lt(zero), root));
        let (first, second) = (sum / three_a, c / sum);
        let first = first.max(zero).min(one);
        let second = second.max(zero).min(one);
        let (low, high) = (first.min(second), first.max(second));
        let negative = [ends[0], at(cubic, low).lt(zero), at(cubic, high).lt(zero), ends[1]];
        let mut crossed = [
            inside & (negative[0] ^ negative[1]),
            inside & (negative[1] ^ negative[2]),
            inside & (negative[2] ^ negative[3]),
        ];
        if ANY {
            hit = hit | (may.within & (crossed[0] | crossed[1] | crossed[2]));
            for piece in &mut crossed {
                *piece = piece.and_not(may.within);
            }
        }
        let mut t = zero;
        // Once, except where a first root is not within the interval: it starts on the surface.
        while (crossed[0] | crossed[1] | crossed[2]).any() {
            let zeroth = crossed[0];
            let middle = crossed[1].and_not(zeroth);
            let last = crossed[2].and_not(zeroth | middle);
            let from = zero.select(zeroth, low.select(middle, high));
            let to = low.select(zeroth, high.select(middle, one));
            let sign = (negative[0] & zeroth) | (negative[1] & middle) | (negative[2] & last);
            let u = close_in(token, cubic, from, to, sign, zeroth | middle | last);
            let here = u.mul_add(length, near).min(far);
            let found = (zeroth | middle | last) & here.gt(t_min) & here.le(t_max);
            t = here.select(found, t);
            hit = hit | found;
            crossed = [token.mask(0), crossed[1].and_not(middle | found), crossed[2].and_not(last | found)];
        }
        (hit, t)
    }
}

/// Where in the cell the ray is at t, from 0 to 1.
#[inline(always)]
fn fractions<T: Token>(
    token: T,
    planes: &[[T::F32; 2]; 3],
    low: [T::F32; 3],
    origin: [T::F32; 3],
    direction: [T::F32; 3],
    t: T::F32,
) -> [T::F32; 3] {
    let (zero, one) = (token.splat(0.0), token.splat(1.0));
    let mut fractions = [zero; 3];
    for axis in 0..3 {
        let at = direction[axis].mul_add(t, origin[axis] - low[axis]).max(zero).min(one);
        let [a, b] = planes[axis];
        fractions[axis] = one.select(t.eq(b), zero.select(t.eq(a), at));
    }
    fractions
}

#[inline(always)]
fn is_negative<T: Token>(token: T, value: T::F32) -> T::Mask {
    I32Lanes::lt(value.to_bits(), token.splat_i32(0))
}

/// The value between the corners, weighed along x, then y, then z.
#[inline(always)]
fn weighed<F: F32Lanes>(one: F, corners: &[F; 8], [x, y, z]: [F; 3]) -> F {
    let (rest_x, rest_y, rest_z) = (one - x, one - y, one - z);
    let (a, b) = (mix(corners[0], corners[1], x, rest_x), mix(corners[2], corners[3], x, rest_x));
    let (c, d) = (mix(corners[4], corners[5], x, rest_x), mix(corners[6], corners[7], x, rest_x));
    mix(mix(a, b, y, rest_y), mix(c, d, y, rest_y), z, rest_z)
}

#[inline(always)]
fn mix<F: F32Lanes>(a: F, b: F, part: F, rest: F) -> F {
    b.mul_add(part, a * rest)
}

/// Coefficients of 1, x, y, z, xy, yz, zx, xyz of the field in a unit cell.
#[inline(always)]
fn coefficients<F: F32Lanes>(corners: &[F; 8]) -> [F; 8] {
    let [v0, vx, vy, vxy, vz, vzx, vyz, vxyz] = *corners;
    let (x, y, z) = (vx - v0, vy - v0, vz - v0);
    let (xy, yz, zx) = ((vxy - vy) - x, (vyz - vz) - y, (vzx - vz) - x);
    [v0, x, y, z, xy, yz, zx, (vxyz - vyz) - (vzx - vz) - xy]
}

/// Coefficients, from the constant up, of the field along the ray from a point of the cell on, over `length`.
#[inline(always)]
fn along<F: F32Lanes>(field: &[F; 8], [x, y, z]: [F; 3], direction: [F; 3], length: F) -> [F; 4] {
    let [k, kx, ky, kz, kxy, kyz, kzx, kxyz] = *field;
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

/// The root of the cubic in a piece where it changes sign; `negative` at its start. Only the lanes `asked` need it.
#[inline(always)]
fn close_in<T: Token>(
    token: T,
    cubic: [T::F32; 4],
    from: T::F32,
    to: T::F32,
    negative: T::Mask,
    asked: T::Mask,
) -> T::F32 {
    let (zero, half) = (token.splat(0.0), token.splat(0.5));
    let (start, end) = (at(cubic, from), at(cubic, to));
    let mut u = ((to - from) * (start / (start - end)) + from).max(from).min(to);
    for _ in 0..STEPS {
        u = newton(cubic, u, from, to);
    }
    let near = token.splat(NEAR);
    let (before, after) = (at(cubic, (u - near).max(from)), at(cubic, (u + near).min(to)));
    let unsure = asked.and_not(before.lt(zero) ^ after.lt(zero));
    if !unsure.any() {
        return u;
    }
    let (mut low, mut high) = (from, to);
    for _ in 0..HALVINGS {
        let middle = (low + high) * half;
        let other = at(cubic, middle).lt(zero) ^ negative;
        high = middle.select(other, high);
        low = low.select(other, middle);
    }
    let mut v = (low + high) * half;
    for _ in 0..STEPS {
        v = newton(cubic, v, low, high);
    }
    v.select(unsure, u)
}

/// A step of Newton's that stays in a piece.
#[inline(always)]
fn newton<F: F32Lanes>(cubic: [F; 4], u: F, low: F, high: F) -> F {
    let [_, c, b, a] = cubic;
    let slope = (a + a + a).mul_add(u, b + b).mul_add(u, c);
    (u - at(cubic, u) / slope).max(low).min(high)
}
