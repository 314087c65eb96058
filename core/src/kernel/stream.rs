//! Rays that have nothing in common, up to 64 together (a stream of rays), against the eight boxes of a node: ray by ray, each against all
//! boxes at once, or box by box, each against a vector of rays.
//!
//! Barringer and Akenine-Moeller, "Dynamic Ray Stream Traversal", TOG 2014 (ray by ray); Benthin et al., "Combining Single and Packet-Ray
//! Tracing for Arbitrary Ray Distributions on the Intel MIC Architecture", TVCG 2012 (box by box).
//!
//! - NaN: an axis on which a ray has a NaN, or on which products overflow, is passed over: its box may be met, not missed.
//! - Zero direction and grazing rays: as [`super::aabb::padded`]; boxes are widened by the margin of [`super::margin`].

use mobula_simd::{F32Lanes, MaskLanes, Token};

use super::aabb::{padded, padded_origin};
use super::boxes::{Planes, overlapping};
use super::margin::{Frame, PAD};
use super::words::{WORDS, part, word_size};
use crate::vector::load3;
use crate::{Column, Columns3, Rays};

/// Which rays meet which of eight boxes.
#[derive(Clone, Copy, Debug)]
pub struct Meetings {
    /// The boxes that any ray meets, a bit each.
    pub boxes: u32,
    /// The rays that meet each of these, a bit each.
    pub rays: [u64; 8],
    /// Where the first of them enters it; infinity where that was not asked.
    pub near: [f32; 8],
}

impl Meetings {
    const NONE: Self = Self { boxes: 0, rays: [0; 8], near: [f32::INFINITY; 8] };
}

/// A row of three columns, in every lane.
#[inline(always)]
fn row<T: Token, const N: usize>(token: T, [x, y, z]: &Columns3<N>, i: usize) -> [T::F32; 3] {
    [token.splat(x[i]), token.splat(y[i]), token.splat(z[i])]
}

/// Eight bits in the lowest bits of eight bytes, the first in the last byte.
#[inline(always)]
fn spread(bits: u32) -> u64 {
    // Copies of the eight, nine bits apart: of each the seventh bit is another one.
    u64::from(bits).wrapping_mul(0x8040_2010_0804_0201) >> 7 & 0x0101_0101_0101_0101
}

/// What box tests need of the rays of a packet, worked out once.
#[derive(Clone, Debug)]
pub struct Stream<const N: usize> {
    /// See [`padded_origin`].
    padded: [[Column<f32, N>; 3]; 2],
    /// The least and the greatest coordinates that the rays of a word pass, in the tree's frame, moved outwards by the margin.
    around: [[[f32; 3]; 2]; WORDS],
    /// For which words that was done.
    derived: u32,
}

impl<const N: usize> Default for Stream<N> {
    /// Nothing is worked out yet.
    #[inline(always)]
    fn default() -> Self {
        let zero = [Column::splat(0.0); 3];
        Self { padded: [zero; 2], around: [[[0.0; 3]; 2]; WORDS], derived: 0 }
    }
}

impl<const N: usize> Stream<N> {
    /// Works out what is needed of a word of rays, whose inverse directions are derived, unless that was done before.
    #[inline(always)]
    pub fn derive<T: Token>(&mut self, token: T, rays: &Rays<N>, frame: &Frame, word: usize) {
        if self.derived >> word & 1 != 0 {
            return;
        }
        self.derived |= 1 << word;
        let (inf, minus_inf, nan) = (token.splat(f32::INFINITY), token.splat(f32::NEG_INFINITY), token.splat(f32::NAN));
        let (mut least, mut greatest) = ([inf; 3], [minus_inf; 3]);
        let mut lane = 0;
        while lane < word_size(N) {
            let at = 64 * word + lane;
            let origins = frame.origins(token, load3(token, rays.origins(), at));
            let mut away = token.splat(0.0);
            for origin in origins {
                away = origin.abs().max(away);
            }
            let margin = away * token.splat(PAD);
            let (t_min, t_max) = (token.load(&rays.t_min()[..], at), token.load(&rays.t_max[..], at));
            let searching = rays.active(token, at) & t_min.le(t_max);
            let nowhere = searching & away.eq(inf);
            // Where it starts: at the origin, unless behind it.
            let t_min = t_min.min(token.splat(0.0));
            for (k, origin) in origins.into_iter().enumerate() {
                let inverse = token.load(&rays.inverse_columns()[k][..], at);
                let [low, high] = padded_origin(token, origin, inverse, margin, away);
                low.store(&mut self.padded[0][k][..], at);
                high.store(&mut self.padded[1][k][..], at);
                // A NaN on the left of `min` and `max` is passed over: rays that are done, and 0 times infinity, which leads nowhere.
                let direction = token.load(&rays.directions()[k][..], at);
                let (start, end) = (direction.mul_add(t_min, origin), direction.mul_add(t_max, origin));
                let low = end.min(start.min(origin)).select(searching, nan);
                let high = end.max(start.max(origin)).select(searching, nan);
                // From infinitely far away nothing is known of where it goes.
                least[k] = minus_inf.select(nowhere, low - margin).min(least[k]);
                greatest[k] = inf.select(nowhere, high + margin).max(greatest[k]);
            }
            lane += T::LANES;
        }
        let around = &mut self.around[word % WORDS];
        for k in 0..3 {
            (around[0][k], around[1][k]) = (least[k].reduce_min(), greatest[k].reduce_max());
        }
    }

    /// Which of the rays `these` of a word, a bit each, meet which boxes, and where the first of them enters each, unless they look for `ANY` hit.
    #[inline(always)]
    pub fn meetings<T: Token, const ANY: bool>(
        &self,
        token: T,
        rays: &Rays<N>,
        planes: &Planes,
        word: usize,
        these: u64,
    ) -> Meetings {
        let mut close = u32::MAX;
        if ANY {
            close = overlapping(token, planes, &self.around[word % WORDS]);
            let (mut vectors, mut lane) = (0, 0);
            while lane < word_size(N) {
                vectors += u32::from(part::<T>(these, lane) != 0);
                lane += T::LANES;
            }
            // Short rays: few boxes are close. A ray and eight boxes, or a box and as many rays, take about as long.
            if close.count_ones() * vectors * (T::LANES as u32) < 8 * these.count_ones() {
                return self.by_box(token, rays, planes, word, these, close);
            }
        }
        let mut meetings = self.by_ray::<T, ANY>(token, rays, planes, word, these);
        meetings.boxes &= close;
        meetings
    }

    /// One ray after the other against all boxes at once.
    #[inline(always)]
    fn by_ray<T: Token, const ANY: bool>(
        &self,
        token: T,
        rays: &Rays<N>,
        planes: &Planes,
        word: usize,
        these: u64,
    ) -> Meetings {
        let token = token.narrow();
        let mut meetings = Meetings::NONE;
        // Byte 7 - b of word w: which of the rays from 8 w meet box b.
        let mut words = [0u64; 8];
        let mut at = 0;
        while at < 8 {
            let inf = token.splat(f32::INFINITY);
            let [mut low, mut high] = [[inf; 3]; 2];
            for k in 0..3 {
                (low[k], high[k]) = (token.load(&planes[k], at), token.load(&planes[k + 3], at));
            }
            let mut first = inf;
            let mut left = these;
            while left != 0 {
                let lane = left.trailing_zeros() as usize % 64;
                let i = (64 * word + lane) % N;
                left &= left - 1;
                let origins = [row(token, &self.padded[0], i), row(token, &self.padded[1], i)];
                let inverse = row(token, rays.inverse_columns(), i);
                let (t_min, t_max) = (token.splat(rays.t_min()[i]), token.splat(rays.t_max[i]));
                let (met, near) = padded(token, low, high, inverse, origins, t_min, t_max);
                if !ANY {
                    first = near.select(met, inf).min(first);
                }
                let met = met.bits() << at;
                meetings.boxes |= met;
                words[lane / 8] |= spread(met) << (lane % 8);
            }
            first.store(&mut meetings.near, at);
            at += <T::Narrow as Token>::LANES;
        }
        for (slot, rays) in meetings.rays.iter_mut().enumerate() {
            for (w, word) in words.iter().enumerate() {
                *rays |= (word >> (56 - 8 * slot) & 0xff) << (8 * w);
            }
        }
        meetings
    }

    /// One of the boxes `close` after the other, a bit each, against vectors of rays.
    #[inline(always)]
    fn by_box<T: Token>(
        &self,
        token: T,
        rays: &Rays<N>,
        planes: &Planes,
        word: usize,
        these: u64,
        close: u32,
    ) -> Meetings {
        let mut meetings = Meetings::NONE;
        let mut left = close;
        while left != 0 {
            let slot = left.trailing_zeros() as usize % 8;
            left &= left - 1;
            let (mut met, mut lane) = (0, 0);
            while lane < word_size(N) {
                let at = 64 * word + lane;
                if part::<T>(these, lane) != 0 {
                    let [mut low, mut high] = [[token.splat(0.0); 3]; 2];
                    for k in 0..3 {
                        (low[k], high[k]) = (token.splat(planes[k][slot]), token.splat(planes[k + 3][slot]));
                    }
                    let origins = [load3(token, &self.padded[0], at), load3(token, &self.padded[1], at)];
                    let (t_min, t_max) = (token.load(&rays.t_min()[..], at), token.load(&rays.t_max[..], at));
                    let inverse = load3(token, rays.inverse_columns(), at);
                    let (hit, _) = padded(token, low, high, inverse, origins, t_min, t_max);
                    met |= u64::from(hit.bits()) << lane;
                }
                lane += T::LANES;
            }
            meetings.rays[slot] = met & these;
            meetings.boxes |= u32::from(met & these != 0) << slot;
        }
        meetings
    }

    /// What the box tests of ray `i` as a single ray subtract: see [`padded_origin`].
    #[inline(always)]
    pub fn padded_origin(&self, i: usize) -> [[f32; 3]; 2] {
        let mut padded = [[0.0; 3]; 2];
        for (padded, columns) in padded.iter_mut().zip(&self.padded) {
            for (padded, column) in padded.iter_mut().zip(columns) {
                *padded = column[i];
            }
        }
        padded
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use mobula_simd::Scalar;

    use super::*;
    use crate::Properties;

    #[test]
    fn a_ray_from_infinitely_far_away_meets_what_it_may_meet() {
        let (token, far) = (Scalar::new(), f32::MAX);
        let mut rays = Rays::<2>::default();
        rays.reset(0..1, Properties::empty());
        rays.set_ray(0, Vec3::new(0.0, -far, 0.0), Vec3::new(0.1, 1.0, 0.1));
        rays.inverse_directions(token);
        let mut stream = Stream::default();
        // Its origin overflows in this frame.
        stream.derive(token, &rays, &Frame { center: [0.0, far, 0.0], size: 1.0, farthest: far }, 0);
        let planes = [[-1.0; 8], [-1.0; 8], [-1.0; 8], [1.0; 8], [f32::INFINITY; 8], [1.0; 8]];
        let any = stream.meetings::<_, true>(token, &rays, &planes, 0, 1);
        let closest = stream.meetings::<_, false>(token, &rays, &planes, 0, 1);
        assert_eq!((any.boxes, any.rays), (0xff, [1; 8]));
        assert_eq!((closest.boxes, closest.rays), (0xff, [1; 8]));
    }

    #[test]
    fn bounds_of_which_nothing_is_known_are_infinite_and_overlap_everything() {
        let frame = Frame { center: [f32::INFINITY, f32::MAX, 0.0], size: 1.0, farthest: f32::MAX };
        let [low, high] = frame.widen([f32::INFINITY, -f32::MAX, 0.0], [f32::INFINITY, f32::MAX, 1.0]);
        assert!(low.iter().chain(&high).all(|x| !x.is_nan()), "{low:?} {high:?}");
        let nan = [[f32::NAN; 8]; 6];
        assert_eq!(overlapping(Scalar::new(), &nan, &[[0.0; 3], [1.0; 3]]), 0xff);
    }
}
