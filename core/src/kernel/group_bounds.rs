//! Bounds of the rays of each group of a packet, taken once a packet: what [`super::frusta`] are made of.
//!
//! All directions of a group that is bounded have the same dominant axis and go the same way along it. An axis and a way make
//! a class; groups of one class can travel together. Slopes are what the triangle test shears by, so nothing is divided.
//!
//! - NaN: passed over; a ray without an interval reaches nowhere.
//! - Rays whose axes or ways differ, that start before their origin, or too far away: their group has no class and is [`MIXED`].

use mobula_simd::{F32Lanes, I32Lanes, MaskLanes, Token};

use super::groups::{GROUPS, Row, group_size};
use super::margin::{Frame, larger};
use crate::{Column, Rays};

/// The class of a group whose rays have nothing in common: they are traced as a stream.
pub const MIXED: u8 = u8::MAX;
/// Groups with origins beyond, and in trees that reach beyond, are not bounded: sums and products of such overflow.
const FARTHEST: f32 = 1e30;

/// Groups from a common origin whose slopes spread wider than this both ways have nothing else in common: a packet of shuffled
/// rays, whose bounds dismiss nothing.
const SCATTERED: f32 = 1.0 / 8.0;

/// Bounds of each group.
#[derive(Clone, Copy, Debug)]
pub struct GroupBounds {
    class: [u8; GROUPS],
    /// Least and greatest slopes, x then y, of each group.
    pub slope: [[Row; 2]; 2],
    /// The reciprocal of the direction along z that is least in size: it makes depths into the least distances.
    pub inverse: Row,
    /// Least and greatest origins, in the frame.
    pub origin: [[Row; 3]; 2],
    /// The far end of each group's intervals.
    pub t_max: Row,
    /// The greatest coordinate of the origins of groups that have a class.
    pub away: f32,
    /// What origins are relative to.
    pub frame: Frame,
}

impl GroupBounds {
    /// Looks at all groups of a packet, whose shears are derived.
    #[inline(always)]
    pub fn new<T: Token, const N: usize, const COMMON_ORIGIN: bool>(token: T, rays: &Rays<N>, frame: &Frame) -> Self {
        let zero = Column::splat(0.0);
        let mut bounds = Self {
            class: [MIXED; GROUPS],
            slope: [[zero; 2]; 2],
            inverse: zero,
            origin: [[zero; 3]; 2],
            t_max: Column::splat(f32::NEG_INFINITY),
            away: 0.0,
            frame: *frame,
        };
        let range = rays.range();
        let size = group_size(N);
        for group in range.start / size..range.end.div_ceil(size) {
            if range.start <= group * size && (group + 1) * size <= range.end {
                bounds.take::<T, N, COMMON_ORIGIN, false>(token, rays, group % GROUPS);
            } else {
                bounds.take::<T, N, COMMON_ORIGIN, true>(token, rays, group % GROUPS);
            }
        }
        if COMMON_ORIGIN {
            let (origin, _) = rays.ray(range.start);
            for (axis, x) in frame.origin(origin.to_array()).into_iter().enumerate() {
                bounds.origin[0][axis] = Column::splat(x);
                bounds.origin[1][axis] = Column::splat(x);
                bounds.away = larger(x.abs(), bounds.away);
            }
        } else {
            for group in range.start / size..range.end.div_ceil(size) {
                for axis in 0..if bounds.class(group) == MIXED { 0 } else { 3 } {
                    let (least, greatest) =
                        (bounds.origin[0][axis][group % GROUPS], bounds.origin[1][axis][group % GROUPS]);
                    bounds.away = larger(larger(least.abs(), greatest.abs()), bounds.away);
                }
            }
        }
        if larger(bounds.away, frame.farthest) > FARTHEST {
            bounds.class = [MIXED; GROUPS];
        }
        bounds
    }

    /// Groups of one class can travel together: twice the dominant axis, and one more if they go backward along it.
    #[inline(always)]
    pub fn class(&self, group: usize) -> u8 {
        self.class[group % GROUPS]
    }

    /// The groups of a class, a bit each.
    #[inline(always)]
    pub fn of_class(&self, class: u8) -> u32 {
        let mut groups = 0;
        for (group, &of) in self.class.iter().enumerate() {
            groups |= u32::from(of == class) << group;
        }
        groups
    }

    /// Bounds the rays of a group, some of which may be inactive if `MASKED`. Leaves out a common origin.
    #[inline(always)]
    fn take<T: Token, const N: usize, const COMMON_ORIGIN: bool, const MASKED: bool>(
        &mut self,
        token: T,
        rays: &Rays<N>,
        group: usize,
    ) {
        let size = group_size(N);
        let (inf, minus_inf, zero) = (token.splat(f32::INFINITY), token.splat(f32::NEG_INFINITY), token.splat(0.0));
        // Inactive lanes become NaN, which min and max pass over.
        let nan = token.splat(f32::NAN);
        let (mut low, mut high) = ([inf; 3], [minus_inf; 3]);
        let (mut low_origin, mut high_origin) = ([inf; 3], [minus_inf; 3]);
        let mut far = minus_inf;
        let axis = rays.axes()[rays.range().start.max(group * size)];
        let (mut mixed, mut early) = (false, false);
        let mut at = group * size;
        while at < (group + 1) * size {
            let active = rays.active(token, at);
            let mut same = token.load_u32(&rays.axes()[..], at).eq(token.splat_i32(axis as i32));
            let mut t_min = token.load(&rays.t_min()[..], at);
            let mut t_max = token.load(&rays.t_max[..], at);
            if MASKED {
                t_min = t_min.select(active, nan);
                t_max = t_max.select(active, nan);
                same = same | !active;
            }
            far = t_max.max(far);
            early |= t_min.lt(zero).any();
            mixed |= !same.all();
            for k in 0..3 {
                let mut x = token.load(&rays.shear_columns()[k][..], at);
                if MASKED {
                    x = x.select(active, nan);
                }
                (low[k], high[k]) = (x.min(low[k]), x.max(high[k]));
                if !COMMON_ORIGIN {
                    let mut x = token.load(&rays.origins()[k][..], at) - token.splat(self.frame.center[k]);
                    if MASKED {
                        x = x.select(active, nan);
                    }
                    (low_origin[k], high_origin[k]) = (x.min(low_origin[k]), x.max(high_origin[k]));
                }
            }
            at += T::LANES;
        }
        let (least, greatest) = (low[2].reduce_min(), high[2].reduce_max());
        let backward = greatest < 0.0;
        mixed |= early || (least < 0.0) != backward;
        self.class[group] = if mixed { MIXED } else { axis as u8 * 2 + u8::from(backward) };
        self.inverse[group] = if backward { greatest } else { least };
        self.t_max[group] = far.reduce_max();
        for k in 0..2 {
            self.slope[0][k][group] = low[k].reduce_min();
            self.slope[1][k][group] = high[k].reduce_max();
        }
        let spread = |k: usize| self.slope[1][k][group] - self.slope[0][k][group];
        if COMMON_ORIGIN && spread(0) > SCATTERED && spread(1) > SCATTERED {
            self.class[group] = MIXED;
        }
        if !COMMON_ORIGIN {
            for k in 0..3 {
                let (low, high) = (low_origin[k].reduce_min(), high_origin[k].reduce_max());
                (self.origin[0][k][group], self.origin[1][k][group]) = (low, high);
                // One ray from nowhere must not blur the others' bounds.
                if larger(low.abs(), high.abs()) > FARTHEST {
                    self.class[group] = MIXED;
                }
            }
        }
    }
}
