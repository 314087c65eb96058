//! One ray against eight boxes: the same ray in every lane.
//!
//! - NaN: an axis on which the ray has a NaN, or on which products overflow, is passed over: its box may be met, not missed.
//! - Zero direction and grazing rays: as [`super::aabb::padded_sorted`]; boxes are widened by the margin of [`super::margin`].

use mobula_simd::{F32Lanes, MaskLanes, Token};

use super::aabb::padded_sorted;
use super::boxes::{Planes, rows};
use super::few::FewRays;
use super::margin::{PAD, larger};
use crate::vector::splat3;
use crate::{Properties, Rays};

/// A ray taken out of a packet.
#[derive(Clone, Copy, Debug)]
pub struct OneRay {
    /// Origin.
    pub origin: [f32; 3],
    /// Direction.
    pub direction: [f32; 3],
    /// See [`Rays::inverse_directions`].
    pub inverse: [f32; 3],
    /// See [`Rays::shears`].
    pub shear: [f32; 3],
    /// The dominant axis.
    pub axis: usize,
    /// Does the direction have length 1?
    pub unit: bool,
    /// Near end of the interval.
    pub t_min: f32,
    /// Far end.
    pub t_max: f32,
    /// What box tests subtract: see [`super::aabb::padded_origin`].
    pub padded_origin: [[f32; 3]; 2],
}

impl OneRay {
    /// Ray `i`, whose inverse direction and shears are derived.
    #[inline(always)]
    pub fn of<const N: usize>(rays: &Rays<N>, i: usize, padded_origin: [[f32; 3]; 2]) -> Self {
        let (origin, direction) = rays.ray(i);
        let ([sx, sy, sz], [x, y, z]) = (rays.shear_columns(), rays.inverse_columns());
        Self {
            origin: origin.to_array(),
            direction: direction.to_array(),
            inverse: [x[i], y[i], z[i]],
            shear: [sx[i], sy[i], sz[i]],
            axis: rays.axes()[i] as usize,
            unit: rays.properties().contains(Properties::NORMALIZED_DIRECTIONS),
            t_min: rays.t_min()[i],
            t_max: rays.t_max[i],
            padded_origin,
        }
    }
}

/// See [`super::aabb::padded_origin`], of ray `i`, which starts at `origin` in the tree's frame.
#[inline(always)]
pub fn padded_origin<const N: usize>(rays: &Rays<N>, origin: [f32; 3], i: usize) -> [[f32; 3]; 2] {
    let inverse = rays.inverse_columns();
    let away = origin.iter().fold(0.0, |away, x| larger(x.abs(), away));
    let margin = away * PAD;
    let mut padded = [[f32::NAN; 3]; 2];
    for k in 0..3 {
        let inverse = inverse[k][i];
        if (4.0 * away * inverse).is_finite() {
            (padded[0][k], padded[1][k]) = ((origin[k] + margin) * inverse, (origin[k] - margin) * inverse);
        }
    }
    padded
}

/// A ray in every lane.
#[derive(Clone, Copy, Debug)]
pub struct SingleRay<T: Token> {
    /// As leaves want it.
    pub ray: FewRays<T>,
    /// Of the planes that the ray meets first and last.
    padded: [[T::F32; 3]; 2],
    /// The rows of those.
    rows: [[usize; 3]; 2],
}

impl<T: Token> SingleRay<T> {
    /// A ray in every lane.
    #[inline(always)]
    pub fn new(token: T, ray: &OneRay) -> Self {
        let [mut near, mut far] = [[token.splat(0.0); 3]; 2];
        let mut rows = [[0; 3]; 2];
        for k in 0..3 {
            let negative = usize::from(ray.inverse[k] < 0.0);
            near[k] = token.splat(ray.padded_origin[negative][k]);
            far[k] = token.splat(ray.padded_origin[1 - negative][k]);
            (rows[0][k], rows[1][k]) = (k + 3 * negative, k + 3 * (1 - negative));
        }
        let ray = FewRays {
            origin: splat3(token, ray.origin),
            direction: splat3(token, ray.direction),
            inverse: splat3(token, ray.inverse),
            shear: splat3(token, ray.shear),
            axis: ray.axis,
            own_axes: None,
            unit: ray.unit,
            t_min: token.splat(ray.t_min),
            t_max: token.splat(ray.t_max),
        };
        Self { ray, padded: [near, far], rows }
    }

    /// Which of eight boxes the ray meets, a bit each, and where it enters them.
    #[inline(always)]
    pub fn boxes(&self, token: T, planes: &Planes, nears: &mut [f32; 8]) -> u32 {
        let mut met = 0;
        let mut at = 0;
        while at < 8 {
            let (near, far) = (rows(token, planes, self.rows[0], at), rows(token, planes, self.rows[1], at));
            let FewRays { inverse, t_min, t_max, .. } = self.ray;
            let (hit, near) = padded_sorted(token, near, far, inverse, self.padded, t_min, t_max);
            met |= hit.bits() << at;
            near.store(nears, at);
            at += T::LANES;
        }
        met
    }
}
