//! How a medium is lit: by lights that are known where rays enter and leave the grid, as a surface across the gradient would be.

use alloc::vec::Vec;

use mobula_simd::{F32Lanes, Token};

use super::passage::{Passages, WIDTH};
use crate::vector::{dot, load3, splat3};
use crate::{Column, Columns3};

/// Light for the rays of some passages.
#[derive(Clone, Debug, Default)]
pub struct Lighting {
    /// What arrives from everywhere where the gradient is level, and how much more where it points up, linear RGB.
    pub ambient: [[f32; 3]; 2],
    /// Up, moved into cells.
    pub up: [f32; 3],
    /// Products of the rows of the way into cells: xx, yy, zz, xy, yz, zx. A gradient in cells has a length in space by these.
    pub metric: [f32; 6],
    /// Gradients shorter than this, per length in space, count less: they have no direction to speak of.
    pub flat: f32,
    /// The lights.
    pub lights: Vec<LightRows>,
}

/// A light, for each ray where it enters and where it leaves; in between both are taken to change linearly.
#[derive(Clone, Debug)]
pub struct LightRows {
    /// The ways to it, moved into cells. Their lengths in space do not count.
    pub towards: [Columns3<WIDTH>; 2],
    /// Squares of the lengths of these in space, and between them their product.
    pub squares: Columns3<WIDTH>,
    /// What arrives, linear RGB.
    pub radiance: [Columns3<WIDTH>; 2],
}

impl Default for LightRows {
    fn default() -> Self {
        let zero = [Column::splat(0.0); 3];
        Self { towards: [zero; 2], squares: zero, radiance: [zero; 2] }
    }
}

/// The most that is kept of a light for the rays of a vector in a brick: the way to it where they enter, how that changes, radiance.
type Here = [[f32; 16]; 9];

/// The lights as the rays of a vector see them in a brick.
pub(super) struct Lit<'a, T: Token> {
    lighting: &'a Lighting,
    here: &'a [Here],
    /// Where the rays enter the brick, and one over how long they are in it.
    near: T::F32,
    per_length: T::F32,
}

impl<'a, T: Token> Lit<'a, T> {
    /// For the rays from `at`, which are in the brick from `near` to `far`.
    #[inline(always)]
    pub(super) fn new(
        token: T,
        lighting: &'a Lighting,
        here: &'a mut Vec<Here>,
        passages: &Passages,
        at: usize,
        [near, far]: [T::F32; 2],
    ) -> Self {
        here.resize(lighting.lights.len(), [[0.0; 16]; 9]);
        let (start, per_length) = (token.load(&passages.t0[..], at), token.load(&passages.per_length[..], at));
        let (first, last) = ((near - start) * per_length, (far - start) * per_length);
        let middle = (first + last) * token.splat(0.5);
        for (rows, here) in lighting.lights.iter().zip(here.iter_mut()) {
            let (from, to) = (rows.towards_at(token, at, first), rows.towards_at(token, at, last));
            let radiance = [load3(token, &rows.radiance[0], at), load3(token, &rows.radiance[1], at)];
            for axis in 0..3 {
                from[axis].store(&mut here[axis], 0);
                (to[axis] - from[axis]).store(&mut here[3 + axis], 0);
                mix(radiance[0][axis], radiance[1][axis], middle).store(&mut here[6 + axis], 0);
            }
        }
        Self { lighting, here, near, per_length: token.splat(1.0) / (far - near) }
    }

    /// Multiplies what is emitted, in all but the first of `seen`, by what arrives at t. The gradient and the directions of the rays are in
    /// cells.
    #[inline(always)]
    pub(super) fn light(
        &self,
        token: T,
        seen: &mut [T::F32; 4],
        gradient: [T::F32; 3],
        direction: [T::F32; 3],
        t: T::F32,
    ) {
        let (zero, one, half) = (token.splat(0.0), token.splat(1.0), token.splat(0.5));
        let part = (t - self.near) * self.per_length;
        let Lighting { ambient, up, metric, flat, .. } = self.lighting;
        let [x, y, z] = gradient;
        let diagonal = dot([x * x, y * y, z * z], splat3(token, [metric[0], metric[1], metric[2]]));
        let mixed = dot([x * y, y * z, z * x], splat3(token, [metric[3], metric[4], metric[5]]));
        let length = (mixed + mixed + diagonal).sqrt();
        // Towards the viewer, whichever way values rise.
        let sign = one.select(dot(gradient, direction).lt(zero), -one);
        let usable = length.gt(token.splat(f32::MIN_POSITIVE)) & length.lt(token.splat(f32::INFINITY));
        let scale = (sign / length).select(usable, zero);
        // Of what is no number, nothing is left.
        let normal = [x.select(usable, zero) * scale, y.select(usable, zero) * scale, z.select(usable, zero) * scale];
        // Where there is no direction to speak of: what a surface of any direction gets on average.
        let weight = (length / token.splat(*flat)).min(one).select(usable, zero);
        let even = (one - weight) * half;
        let towards_up = dot(normal, splat3(token, *up)) * weight;
        let mut arriving = [zero; 3];
        for (i, arriving) in arriving.iter_mut().enumerate() {
            *arriving = towards_up.mul_add(token.splat(ambient[1][i]), token.splat(ambient[0][i]));
        }
        for here in self.here.iter() {
            let mut towards = [zero; 3];
            for axis in 0..3 {
                towards[axis] = part.mul_add(token.load(&here[3 + axis], 0), token.load(&here[axis], 0));
            }
            let cosine = dot(normal, towards).max(zero).mul_add(weight, even);
            for (i, arriving) in arriving.iter_mut().enumerate() {
                *arriving = cosine.mul_add(token.load(&here[6 + i], 0), *arriving);
            }
        }
        for i in 0..3 {
            seen[i + 1] = seen[i + 1] * arriving[i];
        }
    }
}

impl LightRows {
    /// The unit vectors to the light, moved into cells, at a part of the way from where rays enter to where they leave.
    #[inline(always)]
    fn towards_at<T: Token>(&self, token: T, at: usize, part: T::F32) -> [T::F32; 3] {
        let (from, to) = (load3(token, &self.towards[0], at), load3(token, &self.towards[1], at));
        let [aa, ab, bb] = load3(token, &self.squares, at);
        let (zero, rest) = (token.splat(0.0), token.splat(1.0) - part);
        let square = part.mul_add(part * bb, rest.mul_add(rest * aa, (part + part) * (rest * ab)));
        let scale = (token.splat(1.0) / square.sqrt()).select(square.gt(zero), zero);
        let mut out = [zero; 3];
        for axis in 0..3 {
            out[axis] = mix(from[axis], to[axis], part) * scale;
        }
        out
    }
}

#[inline(always)]
fn mix<F: F32Lanes>(a: F, b: F, part: F) -> F {
    part.mul_add(b - a, a)
}
