//! What values look like: a transfer function, piecewise linear in the value, and what it is on average between two values.
//!
//! Between two samples along a ray the value is taken to change linearly. Of the extinction and of what is emitted (extinction times
//! colour) the average over that stretch is exact, however steep the function is: their integrals over the value are known at all
//! knots (pre-integration as in Engel, Kraus and Ertl, "High-Quality Pre-Integrated Volume Rendering Using Hardware-Accelerated Pixel
//! Shading", 2001, section 4.3; we need no table of a finite resolution, as pieces are polynomials). Light that is emitted and
//! absorbed within the same stretch is dealt with by [`absorb`](super::absorb).
//!
//! - NaN: a value that is NaN has no extinction.
//! - Where two values are so close that the difference of integrals would be lost in rounding, the average of both ends counts.

use alloc::vec::Vec;

use mobula_simd::{F32Lanes, I32Lanes, MaskLanes, Token};

/// A knot of a transfer function. Two of the same value are a jump.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Knot {
    /// The value, as samples are stored.
    pub value: f32,
    /// Linear RGB.
    pub color: [f32; 3],
    /// Part of the light that is lost in a unit of length, for short lengths; not negative.
    pub extinction: f32,
}

/// As many pieces are looked up in registers; of more, by searching in memory.
const FEW: usize = 16;

/// A transfer function: linear between its knots, constant below the first and above the last.
#[derive(Clone, Debug)]
pub struct Transfer {
    /// The values where pieces begin, but for the first piece; padded with infinities to a power of two less one.
    ends: Vec<f32>,
    pieces: usize,
    /// The value that a piece is described from.
    origin: Table,
    /// Extinction and colours there, and how fast they change.
    at: [Table; 4],
    slope: [Table; 4],
    /// Integrals over the value, of the extinction and of extinction times colour, from the first knot to the origin.
    integral: [Table; 4],
    /// Two values that are not closer can be told apart in the integrals.
    apart: f32,
    /// Between which values there is any extinction, ascending.
    visible: Vec<[f32; 2]>,
}

/// A number for each piece, at least [`FEW`].
type Table = Vec<f32>;

impl Transfer {
    /// The function with these knots, by ascending value. Knots out of order or with values that are not finite are left out; no knots
    /// are a function that is nowhere visible.
    pub fn new(knots: &[Knot]) -> Self {
        let mut sound: Vec<Knot> = Vec::with_capacity(knots.len());
        for knot in knots {
            let finite =
                knot.value.is_finite() && knot.extinction.is_finite() && knot.color.iter().all(|c| c.is_finite());
            if finite && sound.last().is_none_or(|last| last.value <= knot.value) {
                sound.push(Knot { extinction: knot.extinction.max(0.0), ..*knot });
            }
        }
        let outside = Knot { value: 0.0, color: [0.0; 3], extinction: 0.0 };
        let (first, last) = (*sound.first().unwrap_or(&outside), *sound.last().unwrap_or(&outside));
        let mut transfer = Self {
            ends: Vec::new(),
            pieces: 0,
            origin: Table::new(),
            at: Default::default(),
            slope: Default::default(),
            integral: Default::default(),
            apart: (last.value - first.value) * (1.0 / 4096.0),
            visible: Vec::new(),
        };
        let mut sums = [0.0; 4];
        transfer.add(first, None, f32::NEG_INFINITY, &mut sums);
        for pair in sound.windows(2).filter(|pair| pair[0].value < pair[1].value) {
            transfer.add(pair[0], Some(pair[1]), pair[0].value, &mut sums);
        }
        transfer.add(last, None, last.value, &mut sums);
        let padded = transfer.ends.len().next_power_of_two().max(FEW) * 2 - 1;
        transfer.ends.resize(padded, f32::INFINITY);
        let Self { origin, at, slope, integral, .. } = &mut transfer;
        for table in [origin].into_iter().chain(at).chain(slope).chain(integral) {
            table.resize(table.len().max(FEW), 0.0);
        }
        transfer
    }

    /// Adds the piece from `start` on: from one knot to another, or constant.
    fn add(&mut self, from: Knot, to: Option<Knot>, start: f32, sums: &mut [f64; 4]) {
        if self.pieces > 0 {
            self.ends.push(start);
        }
        self.pieces += 1;
        self.origin.push(from.value);
        let end = to.unwrap_or(from);
        let width = f64::from(end.value) - f64::from(from.value);
        let numbers = |knot: &Knot| [knot.extinction, knot.color[0], knot.color[1], knot.color[2]];
        let (a, b) = (numbers(&from), numbers(&end));
        for i in 0..4 {
            let slope = if width > 0.0 { (f64::from(b[i]) - f64::from(a[i])) / width } else { 0.0 };
            self.at[i].push(a[i]);
            self.slope[i].push(slope as f32);
            self.integral[i].push(sums[i] as f32);
            // Simpson's rule: a product of two linear functions is integrated exactly.
            let (s0, s1) = (f64::from(a[0]), f64::from(b[0]));
            let (c0, c1) = if i == 0 { (1.0, 1.0) } else { (f64::from(a[i]), f64::from(b[i])) };
            sums[i] += width * (s0 * c0 + (s0 + s1) * (c0 + c1) + s1 * c1) / 6.0;
        }
        if from.extinction > 0.0 || end.extinction > 0.0 {
            let last = if to.is_some() || start == f32::NEG_INFINITY { end.value } else { f32::INFINITY };
            match self.visible.last_mut() {
                Some(before) if before[1] >= start => before[1] = last,
                _ => self.visible.push([start, last]),
            }
        }
    }

    /// Can anything be seen where all values are from `low` to `high`? NaN: no.
    pub fn is_visible(&self, low: f32, high: f32) -> bool {
        self.visible.iter().any(|&[from, to]| low <= to && high >= from)
    }

    /// The values where anything is seen: from the first to the last of these.
    pub fn visible(&self) -> &[[f32; 2]] {
        &self.visible
    }

    /// A number for the pieces of lanes.
    #[inline(always)]
    fn look<T: Token>(&self, token: T, table: &Table, piece: T::I32) -> T::F32 {
        match table.first_chunk() {
            Some(few) if self.pieces <= FEW => token.lookup(few, piece),
            _ => token.gather(table, piece, token.mask(u32::MAX)),
        }
    }

    /// The pieces that values are in. NaN is in the first.
    #[inline(always)]
    fn piece<T: Token>(&self, token: T, value: T::F32) -> T::I32 {
        let (zero, one) = (token.splat_i32(0), token.splat_i32(1));
        let mut piece = zero;
        if self.pieces <= FEW {
            for &end in &self.ends[..(self.pieces - 1).min(FEW)] {
                piece = piece + one.select(value.ge(token.splat(end)), zero);
            }
            return piece;
        }
        // The number of ends that are not above the value, from its highest bit down.
        let mut half = self.ends.len().div_ceil(2);
        while half > 0 {
            let end = token.gather(&self.ends, piece + token.splat_i32(half as i32 - 1), token.mask(u32::MAX));
            piece = piece + token.splat_i32(half as i32).select(value.ge(end), zero);
            half /= 2;
        }
        piece
    }
}

/// What a value looks like, a lane each.
#[derive(Clone, Copy, Debug)]
pub struct Look<T: Token> {
    value: T::F32,
    piece: T::I32,
    /// Extinction, and the colour.
    pub seen: [T::F32; 4],
}

impl<T: Token> Look<T> {
    /// Of values.
    #[inline(always)]
    pub fn new(token: T, transfer: &Transfer, value: T::F32) -> Self {
        let (zero, known) = (token.splat(0.0), value.eq(value));
        let piece = transfer.piece(token, value);
        let from = (value - transfer.look(token, &transfer.origin, piece)).select(known, zero);
        let mut seen = [zero; 4];
        for (i, seen) in seen.iter_mut().enumerate() {
            let (at, slope) =
                (transfer.look(token, &transfer.at[i], piece), transfer.look(token, &transfer.slope[i], piece));
            *seen = slope.mul_add(from, at);
        }
        seen[0] = seen[0].max(zero).select(known, zero);
        Self { value, piece, seen }
    }

    /// Averages from here to `end`, where the value changes linearly: the extinction, and extinction times each colour.
    #[inline(always)]
    pub fn until(&self, token: T, transfer: &Transfer, end: &Self) -> [T::F32; 4] {
        let sixth = token.splat(1.0 / 6.0);
        let mut average = [(self.seen[0] + end.seen[0]) * token.splat(0.5); 4];
        for i in 1..4 {
            average[i] = simpson::<T>(self.seen[0], self.seen[i], end.seen[0], end.seen[i]) * sixth;
        }
        let distance = end.value - self.value;
        let apart = distance.abs().gt(token.splat(transfer.apart)).and_not(I32Lanes::eq(self.piece, end.piece));
        if apart.any() {
            let (from, to) = (self.integrals(token, transfer), end.integrals(token, transfer));
            for i in 0..4 {
                average[i] = ((to[i] - from[i]) / distance).select(apart, average[i]);
            }
        }
        average
    }

    /// The integrals from the first knot to the value.
    #[inline(always)]
    fn integrals(&self, token: T, transfer: &Transfer) -> [T::F32; 4] {
        let width = self.value - transfer.look(token, &transfer.origin, self.piece);
        let at = transfer.look(token, &transfer.at[0], self.piece);
        let mut out = [width; 4];
        out[0] = ((at + self.seen[0]) * token.splat(0.5))
            .mul_add(width, transfer.look(token, &transfer.integral[0], self.piece));
        let sixth = width * token.splat(1.0 / 6.0);
        for i in 1..4 {
            let color = transfer.look(token, &transfer.at[i], self.piece);
            let sum = transfer.look(token, &transfer.integral[i], self.piece);
            out[i] = simpson::<T>(at, color, self.seen[0], self.seen[i]).mul_add(sixth, sum);
        }
        out
    }
}

/// Six times the average of the product of two functions that are linear from `a0`, `b0` to `a1`, `b1`.
#[inline(always)]
fn simpson<T: Token>(a0: T::F32, b0: T::F32, a1: T::F32, b1: T::F32) -> T::F32 {
    (a0 + a1).mul_add(b0 + b1, a1.mul_add(b1, a0 * b0))
}
