//! Bounds of any rays whose directions have the same signs: intervals of origins and reciprocal directions.
//!
//! Boulos, Wald and Shirley, "Geometric and Arithmetic Culling Methods for Entire Ray Packets", Utah 2006. A class is an
//! octant.

use mobula_simd::{F32Lanes, MaskLanes, Token};

use super::PAD;
use super::cull::{Cull, GROUPS, MIXED, Row, greatest, group_size, least};
use super::node_rows;
use crate::Rays;
use crate::bvh::Node;
use crate::kernel::{aabb, splat3, sub};

/// Least and greatest values of the rays of each group, one lane a group. The origins are already moved outwards by the
/// margin of rounding, and sorted by which plane of a box they go with.
#[derive(Clone, Copy, Debug)]
pub(super) struct Intervals {
    /// What to subtract from the nearer and the farther planes, by axis.
    origin: [[Row; 3]; 2],
    /// Least and greatest reciprocal direction, by axis.
    inverse: [[Row; 3]; 2],
    t_min: Row,
    /// `-inf` for a group with nothing left to find.
    t_max: Row,
    /// Signs of the directions of a group (bit k: axis k is negative), or `MIXED`.
    octant: [u8; GROUPS],
    /// The same of all that travel together.
    all: Beam,
    travelling: u32,
    /// The greatest of all groups.
    margin: f32,
}

#[derive(Clone, Copy, Debug)]
struct Beam {
    origin: [[f32; 3]; 2],
    inverse: [[f32; 3]; 2],
    t_min: f32,
    t_max: f32,
    /// Rows of a node's planes that are met first and last.
    rows: [[usize; 3]; 2],
}

impl Cull for Intervals {
    const COMMON_ORIGIN: bool = false;

    #[inline(always)]
    fn new<T: Token, const N: usize>(token: T, rays: &Rays<N>, scale: f32) -> Self {
        let mut intervals = Self {
            origin: [[[0.0; GROUPS]; 3]; 2],
            inverse: [[[0.0; GROUPS]; 3]; 2],
            t_min: [f32::INFINITY; GROUPS],
            t_max: [f32::NEG_INFINITY; GROUPS],
            octant: [MIXED; GROUPS],
            all: Beam { origin: [[0.0; 3]; 2], inverse: [[0.0; 3]; 2], t_min: 0.0, t_max: 0.0, rows: [[0; 3]; 2] },
            travelling: 0,
            margin: 0.0,
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
            let (least, greatest) = (reduce_min::<T>(least), reduce_max::<T>(greatest));
            intervals.t_min[group] = least[6];
            intervals.t_max[group] = greatest[6];
            let size = |x: f32, y: f32| if x.abs() > y { x.abs() } else { y };
            let largest = (3..6).fold(scale, |s, k| size(least[k], size(greatest[k], s)));
            let margin = PAD * largest;
            intervals.margin = if margin > intervals.margin { margin } else { intervals.margin };
            let mut octant = 0u8;
            for axis in 0..3 {
                let (low, high) = (least[axis + 3] - margin, greatest[axis + 3] + margin);
                let negative = greatest[axis] < 0.0;
                octant |= if (least[axis] < 0.0) == negative { u8::from(negative) << axis } else { MIXED };
                intervals.inverse[0][axis][group] = least[axis];
                intervals.inverse[1][axis][group] = greatest[axis];
                intervals.origin[0][axis][group] = if negative { low } else { high };
                intervals.origin[1][axis][group] = if negative { high } else { low };
            }
            intervals.octant[group] = octant;
        }
        intervals
    }

    #[inline(always)]
    fn class(&self, group: usize) -> u8 {
        self.octant[group]
    }

    #[inline(always)]
    fn gather(&mut self, groups: u32, class: u8) {
        self.travelling = groups;
        self.all.rows = node_rows(class);
        for axis in 0..3 {
            let (near, far) = (&self.origin[0][axis], &self.origin[1][axis]);
            let (near, far) = if class >> axis & 1 != 0 {
                (least(near, groups), greatest(far, groups))
            } else {
                (greatest(near, groups), least(far, groups))
            };
            (self.all.origin[0][axis], self.all.origin[1][axis]) = (near, far);
            self.all.inverse[0][axis] = least(&self.inverse[0][axis], groups);
            self.all.inverse[1][axis] = greatest(&self.inverse[1][axis], groups);
        }
        self.all.t_min = least(&self.t_min, groups);
        self.all.t_max = greatest(&self.t_max, groups);
    }

    #[inline(always)]
    fn axis(&self) -> usize {
        0
    }

    #[inline(always)]
    fn farthest(&self) -> f32 {
        self.all.t_max
    }

    #[inline(always)]
    fn children<T: Token>(&self, token: T, node: &Node, near: &mut [f32; 8]) -> u32 {
        let all = &self.all;
        let mut met = 0;
        let mut at = 0;
        while at < 8 {
            let to_near = sub(node.rows(token, all.rows[0], at), splat3(token, all.origin[0]));
            let to_far = sub(node.rows(token, all.rows[1], at), splat3(token, all.origin[1]));
            let inverse = [splat3(token, all.inverse[0]), splat3(token, all.inverse[1])];
            let (t_min, t_max) = (token.splat(all.t_min), token.splat(all.t_max));
            let (hit, entry) = aabb::beam(token, to_near, to_far, inverse, t_min, t_max);
            entry.store(near, at);
            met |= hit.bits() << at;
            at += T::LANES;
        }
        met & 0xff
    }

    #[inline(always)]
    fn margin(&self) -> f32 {
        self.margin
    }

    #[inline(always)]
    fn farthest_of_groups(&mut self) -> &mut Row {
        &mut self.t_max
    }

    #[inline(always)]
    fn shorten(&mut self) {
        self.all.t_max = greatest(&self.t_max, self.travelling);
    }
}

#[inline(always)]
fn reduce_min<T: Token>(v: [T::F32; 7]) -> [f32; 7] {
    let mut out = [0.0; 7];
    for (out, v) in out.iter_mut().zip(v) {
        *out = v.reduce_min();
    }
    out
}

#[inline(always)]
fn reduce_max<T: Token>(v: [T::F32; 7]) -> [f32; 7] {
    let mut out = [0.0; 7];
    for (out, v) in out.iter_mut().zip(v) {
        *out = v.reduce_max();
    }
    out
}
