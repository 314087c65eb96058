//! Intervals of rays: what a group of rays, or all of a packet, has in common.
//!
//! Boulos, Wald and Shirley, "Geometric and Arithmetic Culling Methods for Entire Ray Packets", Utah 2006.

use mobula_simd::{F32Lanes, MaskLanes, Token};

use super::PAD;
use crate::{Rays, kernel::aabb};

/// Groups in a packet, at most.
pub(super) const GROUPS: usize = 16;

/// Rays in a group: 16, or as many as make 16 groups of a wider packet.
pub(super) const fn group_size(width: usize) -> usize {
    if width <= 16 * GROUPS { 16 } else { width.div_ceil(GROUPS).next_multiple_of(16) }
}

/// Least and greatest values of the rays of each group, one lane a group. The origins are already moved outwards by the
/// margin of rounding, and sorted by which plane of a box they go with.
#[derive(Clone, Copy, Debug)]
pub(super) struct Beams {
    /// What to subtract from the nearer and the farther planes, by axis.
    pub(super) origin: [[[f32; GROUPS]; 3]; 2],
    /// Least and greatest reciprocal direction, by axis.
    pub(super) inverse: [[[f32; GROUPS]; 3]; 2],
    /// Least `t_min`.
    pub(super) t_min: [f32; GROUPS],
    /// Greatest `t_max`; `-inf` for a group with nothing left to find.
    pub(super) t_max: [f32; GROUPS],
    /// Signs of the directions of a group (bit k: axis k is negative), or `MIXED`.
    pub(super) octant: [u8; GROUPS],
}

/// Not all rays of a group have the same signs.
pub(super) const MIXED: u8 = 8;

impl Beams {
    /// Looks at all groups of a packet. The packet has its inverse directions.
    #[inline(always)]
    pub(super) fn new<T: Token, const N: usize>(token: T, rays: &Rays<N>, scale: f32) -> Self {
        let mut beams = Self {
            origin: [[[0.0; GROUPS]; 3]; 2],
            inverse: [[[0.0; GROUPS]; 3]; 2],
            t_min: [f32::INFINITY; GROUPS],
            t_max: [f32::NEG_INFINITY; GROUPS],
            octant: [MIXED; GROUPS],
        };
        let size = group_size(N);
        let range = rays.range();
        for group in range.start / size..range.end.div_ceil(size) {
            let (inf, minus_inf) = (token.splat(f32::INFINITY), token.splat(f32::NEG_INFINITY));
            let mut least = [inf; 7];
            let mut greatest = [minus_inf; 7];
            let mut at = group * size;
            while at < N.min((group + 1) * size) {
                let active = rays.active(token, at);
                for axis in 0..3 {
                    let inverse = token.load(&rays.inverse_columns()[axis][..], at);
                    let origin = token.load(&rays.origins()[axis][..], at);
                    least[axis] = inverse.select(active, inf).min(least[axis]);
                    greatest[axis] = inverse.select(active, minus_inf).max(greatest[axis]);
                    least[axis + 3] = origin.select(active, inf).min(least[axis + 3]);
                    greatest[axis + 3] = origin.select(active, minus_inf).max(greatest[axis + 3]);
                }
                least[6] = token.load(&rays.t_min()[..], at).select(active, inf).min(least[6]);
                greatest[6] = token.load(&rays.t_max[..], at).select(active, minus_inf).max(greatest[6]);
                at += T::LANES;
            }
            let least = least.map(F32Lanes::reduce_min);
            let greatest = greatest.map(F32Lanes::reduce_max);
            beams.t_min[group] = least[6];
            beams.t_max[group] = greatest[6];
            let size = |x: f32, y: f32| if x.abs() > y { x.abs() } else { y };
            let largest = (3..6).fold(scale, |s, k| size(least[k], size(greatest[k], s)));
            let margin = PAD * largest;
            let mut octant = 0;
            for axis in 0..3 {
                let (low, high) = (least[axis + 3] - margin, greatest[axis + 3] + margin);
                let negative = greatest[axis] < 0.0;
                octant |= if least[axis] < 0.0 && !negative { MIXED } else { u8::from(negative) << axis };
                beams.inverse[0][axis][group] = least[axis];
                beams.inverse[1][axis][group] = greatest[axis];
                beams.origin[0][axis][group] = if negative { low } else { high };
                beams.origin[1][axis][group] = if negative { high } else { low };
            }
            beams.octant[group] = octant.min(MIXED);
        }
        beams
    }

    /// One beam around the groups of a mask, all of the same octant.
    #[inline(always)]
    pub(super) fn around(&self, groups: u32, octant: u8) -> Beam {
        let mut beam = Beam {
            origin: [[0.0; 3]; 2],
            inverse: [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]],
            t_min: f32::INFINITY,
            t_max: f32::NEG_INFINITY,
        };
        for axis in 0..3 {
            let negative = octant >> axis & 1 != 0;
            let (near, far) = if negative { (f32::INFINITY, f32::NEG_INFINITY) } else { (f32::NEG_INFINITY, f32::INFINITY) };
            (beam.origin[0][axis], beam.origin[1][axis]) = (near, far);
        }
        for group in (0..GROUPS).filter(|group| groups >> group & 1 != 0) {
            for axis in 0..3 {
                let (near, far) = (self.origin[0][axis][group], self.origin[1][axis][group]);
                let [out_near, out_far] = &mut beam.origin;
                if octant >> axis & 1 != 0 {
                    (out_near[axis], out_far[axis]) = (out_near[axis].min(near), out_far[axis].max(far));
                } else {
                    (out_near[axis], out_far[axis]) = (out_near[axis].max(near), out_far[axis].min(far));
                }
                beam.inverse[0][axis] = beam.inverse[0][axis].min(self.inverse[0][axis][group]);
                beam.inverse[1][axis] = beam.inverse[1][axis].max(self.inverse[1][axis][group]);
            }
            beam.t_min = beam.t_min.min(self.t_min[group]);
            beam.t_max = beam.t_max.max(self.t_max[group]);
        }
        beam
    }

    /// Which of the groups meet the box, whose planes are given as nearer and farther ones.
    #[inline(always)]
    pub(super) fn meet<T: Token>(&self, token: T, near: [f32; 3], far: [f32; 3], groups: usize) -> u32 {
        let mut met = 0;
        let mut at = 0;
        while at < groups {
            let row = |rows: &[[f32; GROUPS]; 3], k: usize| token.load(&rows[k], at);
            let to_near = core::array::from_fn(|k| token.splat(near[k]) - row(&self.origin[0], k));
            let to_far = core::array::from_fn(|k| token.splat(far[k]) - row(&self.origin[1], k));
            let inverse = [0, 1].map(|i| core::array::from_fn(|k| row(&self.inverse[i], k)));
            let (t_min, t_max) = (token.load(&self.t_min, at), token.load(&self.t_max, at));
            met |= aabb::beam(token, to_near, to_far, inverse, t_min, t_max).0.bits() << at;
            at += T::LANES;
        }
        met
    }
}

/// The interval of one or all groups.
#[derive(Clone, Copy, Debug)]
pub(super) struct Beam {
    pub(super) origin: [[f32; 3]; 2],
    pub(super) inverse: [[f32; 3]; 2],
    pub(super) t_min: f32,
    pub(super) t_max: f32,
}
