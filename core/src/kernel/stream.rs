//! Rays that have nothing in common, up to 64 together: each box is tested against each ray (a stream of rays).
//!
//! Benthin et al., "Combining Single and Packet-Ray Tracing for Arbitrary Ray Distributions on the Intel MIC
//! Architecture", TVCG 2012.
//!
//! - NaN: an axis on which a ray has a NaN, or on which products overflow, is passed over: its box may be met, not missed.
//! - Zero direction and grazing rays: as [`super::aabb::padded`]; boxes are widened by the margin of [`super::margin`].

use mobula_simd::{F32Lanes, Token};

use super::aabb::{padded, padded_origin};
use super::boxes::{Planes, overlapping};
use super::margin::{Frame, PAD};
use crate::vector::load3;
use crate::{Column, Rays};

/// What box tests need of a stream of `W` rays, worked out once.
#[derive(Clone, Copy, Debug)]
pub struct Stream<const W: usize> {
    /// See [`padded_origin`].
    padded: [[Column<f32, W>; 3]; 2],
    /// The least and the greatest coordinates that the rays pass, in the tree's frame, moved outwards by the margin.
    around: [[f32; 3]; 2],
}

impl<const W: usize> Stream<W> {
    /// Of the active rays, whose inverse directions are derived.
    #[inline(always)]
    pub fn new<T: Token>(token: T, rays: &Rays<W>, frame: &Frame) -> Self {
        let zero = [Column::splat(0.0); 3];
        let mut stream = Self { padded: [zero; 2], around: [[0.0; 3]; 2] };
        let (inf, minus_inf, nan) = (token.splat(f32::INFINITY), token.splat(f32::NEG_INFINITY), token.splat(f32::NAN));
        let (mut least, mut greatest) = ([inf; 3], [minus_inf; 3]);
        let mut at = 0;
        while at < W {
            let origins = frame.origins(token, load3(token, rays.origins(), at));
            let mut away = token.splat(0.0);
            for origin in origins {
                away = origin.abs().max(away);
            }
            let margin = away * token.splat(PAD);
            let (t_min, t_max) = (token.load(&rays.t_min()[..], at), token.load(&rays.t_max[..], at));
            let searching = rays.active(token, at) & t_min.le(t_max);
            // Where it starts: at the origin, unless behind it.
            let t_min = t_min.min(token.splat(0.0));
            for (k, origin) in origins.into_iter().enumerate() {
                let inverse = token.load(&rays.inverse_columns()[k][..], at);
                let [low, high] = padded_origin(token, origin, inverse, margin, away);
                low.store(&mut stream.padded[0][k][..], at);
                high.store(&mut stream.padded[1][k][..], at);
                // A NaN on the left of `min` and `max` is passed over: rays that are done, and 0 times infinity, which leads nowhere.
                let direction = token.load(&rays.directions()[k][..], at);
                let (start, end) = (direction.mul_add(t_min, origin), direction.mul_add(t_max, origin));
                let low = end.min(start.min(origin)).select(searching, nan);
                let high = end.max(start.max(origin)).select(searching, nan);
                least[k] = (low - margin).min(least[k]);
                greatest[k] = (high + margin).max(greatest[k]);
            }
            at += T::LANES;
        }
        for k in 0..3 {
            stream.around[0][k] = least[k].reduce_min();
            stream.around[1][k] = greatest[k].reduce_max();
        }
        stream
    }

    /// Which of eight boxes overlap the box around all rays, a bit each: few, where rays are short.
    #[inline(always)]
    pub fn boxes<T: Token>(&self, token: T, planes: &Planes) -> u32 {
        overlapping(token, planes, &self.around)
    }

    /// Which of the rays from `at` meet box `slot`, and where they enter it.
    #[inline(always)]
    pub fn rays<T: Token>(
        &self,
        token: T,
        rays: &Rays<W>,
        planes: &Planes,
        slot: usize,
        at: usize,
    ) -> (T::Mask, T::F32) {
        let [mut low, mut high] = [[token.splat(0.0); 3]; 2];
        for k in 0..3 {
            (low[k], high[k]) = (token.splat(planes[k][slot % 8]), token.splat(planes[k + 3][slot % 8]));
        }
        let origins = [load3(token, &self.padded[0], at), load3(token, &self.padded[1], at)];
        let (t_min, t_max) = (token.load(&rays.t_min()[..], at), token.load(&rays.t_max[..], at));
        padded(token, low, high, load3(token, rays.inverse_columns(), at), origins, t_min, t_max)
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
