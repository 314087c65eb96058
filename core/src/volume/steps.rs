//! The way of rays through a brick.
//!
//! Where values are interpolated, it is cut into equal steps, none longer than asked for in units of cells. So steps follow the spacing of
//! the grid in each direction, and what comes out for a ray depends on that ray alone. Values are interpolated at the ends of steps, and
//! what is between them is [classified](crate::kernel::classify) as a whole. A step that takes much of the light is gone through again in
//! [`PARTS`]: within it, what is in front hides what is behind.
//!
//! Where the nearest sample counts, nothing changes between the planes halfway between samples: from one such plane to the next the
//! integral is exact.

use mobula_simd::{F32Lanes, I32Lanes, MaskLanes, Token};

use super::lighting::Lit;
use super::passage::{Passages, WIDTH};
use super::samples::BrickSamples;
use crate::Column;
use crate::kernel::absorb::{Light, absorb};
use crate::kernel::classify::{Look, Transfer};
use crate::kernel::trilinear::{CELLS, Place};
use crate::vector::load3;

/// A ray with less light than this is at its end: it could not become brighter by more than this part of what is behind.
const DARK: f32 = 1.0 / 1024.0;
/// Steps of a greater optical depth are gone through in parts: above which depth in how many.
const PARTS: [(f32, usize); 2] = [(0.5, 2), (4.0, 8)];

/// The rays of a vector in a box: which are in it, and from where to where.
pub(super) struct Inside<T: Token> {
    pub(super) rays: T::Mask,
    pub(super) near: T::F32,
    pub(super) far: T::F32,
}

impl<T: Token> Inside<T> {
    /// Of the rays from `at` with these signs.
    #[inline(always)]
    pub(super) fn new(
        token: T,
        passages: &Passages,
        transmittance: &Column<f32, WIDTH>,
        at: usize,
        octant: u32,
        bounds: [[T::F32; 3]; 2],
    ) -> Self {
        let origin = load3(token, &passages.origin, at);
        let inverse = load3(token, &passages.inverse, at);
        let mut near = token.load(&passages.t0[..], at);
        let mut far = token.load(&passages.t1[..], at);
        for axis in 0..3 {
            let low = (bounds[0][axis] - origin[axis]) * inverse[axis];
            let high = (bounds[1][axis] - origin[axis]) * inverse[axis];
            near = low.min(high).max(near);
            far = low.max(high).min(far);
        }
        let here = I32Lanes::eq(token.load_u32(&passages.octant[..], at), token.splat_i32(octant as i32));
        let lit = token.load(&transmittance[..], at).gt(token.splat(DARK));
        let rays = near.lt(far) & here & lit & token.first(passages.count.saturating_sub(at));
        Self { rays, near, far }
    }
}

/// The rays of a vector on their way through a brick.
pub(super) struct Steps<'a, T: Token> {
    pub(super) transfer: &'a Transfer,
    pub(super) samples: &'a BrickSamples,
    pub(super) lit: Option<Lit<'a, T>>,
    pub(super) light: Light<T::F32>,
    /// The number of the first ray.
    at: usize,
    inside: Inside<T>,
    /// In units of cells, from the least corner of the brick.
    origin: [T::F32; 3],
    direction: [T::F32; 3],
    size: [T::F32; 3],
    /// Lengths of the directions in space.
    space: T::F32,
}

impl<'a, T: Token> Steps<'a, T> {
    /// Of the rays from `at`.
    #[inline(always)]
    pub(super) fn new(
        token: T,
        passages: &Passages,
        at: usize,
        inside: Inside<T>,
        [low, high]: [[T::F32; 3]; 2],
        (transfer, samples, lit, light): (&'a Transfer, &'a BrickSamples, Option<Lit<'a, T>>, Light<T::F32>),
    ) -> Self {
        let mut origin = load3(token, &passages.origin, at);
        let mut size = low;
        for axis in 0..3 {
            (origin[axis], size[axis]) = (origin[axis] - low[axis], high[axis] - low[axis]);
        }
        let direction = load3(token, &passages.direction, at);
        let space = token.load(&passages.space[..], at);
        Self { transfer, samples, lit, light, at, inside, origin, direction, size, space }
    }

    /// Interpolated values, in equal steps.
    #[inline(always)]
    pub(super) fn linear(mut self, token: T, passages: &Passages, longest: f32) -> Light<T::F32> {
        let (zero, one) = (token.splat(0.0), token.splat(1.0));
        let way = (self.inside.far - self.inside.near) * token.load(&passages.cells[..], self.at);
        let steps = way * token.splat(1.0 / longest);
        let whole = steps.to_i32().to_f32();
        let count = (whole + one.select(whole.lt(steps), zero)).max(one);
        let dt = (self.inside.far - self.inside.near) / count;
        let length = dt * self.space;
        let most = count.select(self.inside.rays, zero).reduce_max() as usize;
        let mut last = self.look(token, self.inside.near);
        for step in 1..=most {
            let number = token.splat(step as f32);
            let look = self.look(token, dt.mul_add(number, self.inside.near));
            let mut seen = last.until(token, self.transfer, &look);
            let shown = self.inside.rays & seen[0].gt(zero);
            if shown.any() {
                let depth = seen[0] * length;
                let deep = shown & depth.gt(token.splat(PARTS[0].0));
                let flat = shown.and_not(deep);
                if flat.any() {
                    let middle = dt.mul_add(number - token.splat(0.5), self.inside.near);
                    self.shine(token, &mut seen, middle);
                    self.pass(token, seen, length, flat);
                }
                if deep.any() {
                    let deeper = deep & depth.gt(token.splat(PARTS[1].0));
                    let parts = if deeper.any() { PARTS[1].1 } else { PARTS[0].1 };
                    let share = |parts: usize| token.splat(1.0 / parts as f32);
                    let share = share(PARTS[1].1).select(deeper, share(PARTS[0].1));
                    let mut front = last;
                    for part in 1..=parts {
                        let end = share.mul_add(token.splat(part as f32), number - one);
                        let back = self.look(token, dt.mul_add(end, self.inside.near));
                        let mut seen = front.until(token, self.transfer, &back);
                        let middle = dt.mul_add(share.neg_mul_add(token.splat(0.5), end), self.inside.near);
                        self.shine(token, &mut seen, middle);
                        let which = if part > PARTS[0].1 { deeper } else { deep };
                        self.pass(token, seen, length * share, which);
                        front = back;
                    }
                }
            }
            last = look;
            self.inside.rays = self.inside.rays & number.lt(count);
            if !self.inside.rays.any() {
                break;
            }
        }
        self.light
    }

    /// The values of the nearest samples, from where one changes to where the next does.
    #[inline(always)]
    pub(super) fn nearest(mut self, token: T, passages: &Passages) -> Light<T::F32> {
        let (zero, half) = (token.splat(0.0), token.splat(0.5));
        let inverse = load3(token, &passages.inverse, self.at);
        let start = self.point(token, self.inside.near);
        // The next plane along each axis, and how far it is to the one behind it.
        let (mut plane, mut apart) = (start, start);
        for axis in 0..3 {
            apart[axis] = token.splat(-1.0).select(self.direction[axis].lt(zero), token.splat(1.0));
            plane[axis] = apart[axis].mul_add(half, (start[axis] + half).to_i32().to_f32());
        }
        let mut t = self.inside.near;
        for _ in 0..=CELLS.iter().sum() {
            let mut next = [self.inside.far; 3];
            for axis in 0..3 {
                let there = (plane[axis] - self.origin[axis]) * inverse[axis];
                // What is NaN, of a ray along a plane, is never reached.
                next[axis] = there.select(there.lt(self.inside.far), self.inside.far);
            }
            let end = next[0].min(next[1]).min(next[2]).max(t);
            let middle = (t + end) * half;
            let value = Place::new(token, self.point(token, middle)).nearest(token, &self.samples.values);
            let [extinction, r, g, b] = Look::new(token, self.transfer, value).seen;
            let mut seen = [extinction, extinction * r, extinction * g, extinction * b];
            let shown = self.inside.rays & extinction.gt(zero) & t.lt(end);
            if shown.any() {
                self.shine(token, &mut seen, middle);
                self.pass(token, seen, (end - t) * self.space, shown);
            }
            self.inside.rays = self.inside.rays & end.lt(self.inside.far);
            if !self.inside.rays.any() {
                break;
            }
            for axis in 0..3 {
                plane[axis] = (plane[axis] + apart[axis]).select(next[axis].le(end), plane[axis]);
            }
            t = end;
        }
        self.light
    }

    /// What interpolated values look like at t.
    #[inline(always)]
    fn look(&self, token: T, t: T::F32) -> Look<T> {
        let value = Place::new(token, self.point(token, t)).value(token, &self.samples.values);
        Look::new(token, self.transfer, value)
    }

    /// Multiplies what is emitted by what arrives at t, if there are lights.
    #[inline(always)]
    fn shine(&self, token: T, seen: &mut [T::F32; 4], t: T::F32) {
        if let Some(lit) = &self.lit {
            let place = Place::new(token, self.point(token, t));
            let mut gradient = [t; 3];
            for axis in 0..3 {
                gradient[axis] = place.value(token, &self.samples.gradients[axis]);
            }
            lit.light(token, seen, gradient, self.direction, t);
        }
    }

    /// Some rays pass a stretch of a length; who has hardly any light left is at the end.
    #[inline(always)]
    fn pass(&mut self, token: T, seen: [T::F32; 4], length: T::F32, rays: T::Mask) {
        let (before, rays) = (self.light, rays & self.inside.rays);
        absorb(token, &mut self.light, seen, length);
        for (now, then) in self.light.radiance.iter_mut().zip(before.radiance) {
            *now = now.select(rays, then);
        }
        self.light.transmittance = self.light.transmittance.select(rays, before.transmittance);
        self.inside.rays = self.inside.rays & self.light.transmittance.gt(token.splat(DARK));
    }

    /// Points of the rays, within the brick.
    #[inline(always)]
    fn point(&self, token: T, t: T::F32) -> [T::F32; 3] {
        let mut point = self.direction;
        for axis in 0..3 {
            point[axis] = point[axis].mul_add(t, self.origin[axis]).max(token.splat(0.0)).min(self.size[axis]);
        }
        point
    }
}
