//! What values look like: a transfer function, piecewise linear in the value, and what it is on average between two values.
//!
//! Between two samples along a ray the value is taken to change linearly. Of the extinction and of what is emitted (extinction times
//! colour) the average over that stretch is exact, however steep the function is: their integrals over the value are known at all
//! knots (pre-integration as in Engel, Kraus and Ertl, "High-Quality Pre-Integrated Volume Rendering Using Hardware-Accelerated Pixel
//! Shading", 2001, section 4.3; we need no table of a finite resolution, as pieces are polynomials). Light that is emitted and
//! absorbed within the same stretch is dealt with by [`absorb`](super::absorb).
//!
//! - NaN: a value that is NaN has no extinction.
//! - Where two values are so close that the difference of integrals would be lost in rounding, or so far apart that it is no float, the
//!   average of both ends counts.

use alloc::vec::Vec;

use mobula_simd::{F32Lanes, I32Lanes, MaskLanes, Token};

/// A knot of a transfer function. Two of the same value are a jump.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Knot {
    /// The value, as samples are stored. Beyond 10^31 either way counts as that, so that distances from it are floats.
    pub value: f32,
    /// Linear RGB; more than 10^9 counts as that.
    pub color: [f32; 3],
    /// Part of the light that is lost in a unit of length, for short lengths. Less than 0 counts as 0, more than 10^18 as that.
    pub extinction: f32,
}

/// As many pieces are looked up in registers; of more, by searching in memory.
const FEW: usize = 16;

/// A transfer function: linear between its knots, constant below the first and above the last.
#[derive(Clone, Debug)]
pub struct Transfer {
    /// The pieces, if there are few.
    few: Tables<[f32; FEW]>,
    /// The pieces, if there are many.
    many: Option<Tables<Vec<f32>>>,
    /// Two values that are not closer can be told apart in the integrals.
    apart: f32,
    /// Between which values there is any extinction, ascending.
    visible: Vec<[f32; 2]>,
}

/// A number for each piece.
#[derive(Clone, Debug, Default)]
struct Tables<L> {
    /// The values where the pieces but the first begin, padded with infinities to a power of two less one.
    ends: L,
    /// The value that a piece is described from.
    origin: L,
    /// Extinction and colours there, and how fast they change.
    at: [L; 4],
    slope: [L; 4],
    /// Integrals over the value, of the extinction and of extinction times colour, from the first knot to the origin.
    integral: [L; 4],
}

impl Transfer {
    /// The function with these knots, by ascending value. Knots out of order or with values that are not finite are left out; no knots
    /// are a function that is nowhere visible.
    pub fn new(knots: &[Knot]) -> Self {
        let mut sound: Vec<Knot> = Vec::with_capacity(knots.len());
        for knot in knots {
            let finite =
                knot.value.is_finite() && knot.extinction.is_finite() && knot.color.iter().all(|c| c.is_finite());
            if finite && sound.last().is_none_or(|last| last.value <= knot.value) {
                let color = knot.color.map(|channel| channel.clamp(-1e9, 1e9));
                let (value, extinction) = (knot.value.clamp(-1e31, 1e31), knot.extinction.clamp(0.0, 1e18));
                sound.push(Knot { value, color, extinction });
            }
        }
        let outside = Knot { value: 0.0, color: [0.0; 3], extinction: 0.0 };
        let (first, last) = (*sound.first().unwrap_or(&outside), *sound.last().unwrap_or(&outside));
        let (mut all, mut visible, mut sums) = (Tables::default(), Vec::new(), [0.0; 4]);
        all.add([first; 2], f32::NEG_INFINITY, &mut sums);
        show(&mut visible, [first; 2], [f32::NEG_INFINITY, first.value]);
        for pair in sound.windows(2).filter(|pair| pair[0].value < pair[1].value) {
            let pair = [pair[0], pair[1]];
            all.add(pair, pair[0].value, &mut sums);
            show(&mut visible, pair, [pair[0].value, pair[1].value]);
        }
        all.add([last; 2], last.value, &mut sums);
        show(&mut visible, [last; 2], [last.value, f32::INFINITY]);
        let apart = (last.value - first.value) * (1.0 / 4096.0);
        let (few, many) = match all.few() {
            Some(few) => (few, None),
            None => (Tables::default(), Some(all.padded())),
        };
        Self { few, many, apart, visible }
    }

    /// Can anything be seen where all values are from `low` to `high`? NaN: no.
    pub fn is_visible(&self, low: f32, high: f32) -> bool {
        self.visible.iter().any(|&[from, to]| low <= to && high >= from)
    }

    /// The values where anything is seen: from the first to the second of each.
    pub fn visible(&self) -> &[[f32; 2]] {
        &self.visible
    }
}

/// Adds a piece to what is visible, if it is.
fn show(visible: &mut Vec<[f32; 2]>, ends: [Knot; 2], [from, to]: [f32; 2]) {
    if ends[0].extinction > 0.0 || ends[1].extinction > 0.0 {
        match visible.last_mut() {
            Some(before) if before[1] >= from => before[1] = to,
            _ => visible.push([from, to]),
        }
    }
}

impl Tables<Vec<f32>> {
    /// Adds the piece between two knots, from `start` on.
    fn add(&mut self, [from, to]: [Knot; 2], start: f32, sums: &mut [f64; 4]) {
        if !self.origin.is_empty() {
            self.ends.push(start);
        }
        self.origin.push(from.value);
        let width = f64::from(to.value) - f64::from(from.value);
        let numbers = |knot: Knot| [knot.extinction, knot.color[0], knot.color[1], knot.color[2]].map(f64::from);
        let (a, b) = (numbers(from), numbers(to));
        for i in 0..4 {
            // What rises more steeply than a float can say is as good as a jump.
            let slope = if width > 0.0 { ((b[i] - a[i]) / width) as f32 } else { 0.0 };
            self.at[i].push(a[i] as f32);
            self.slope[i].push(if slope.is_finite() { slope } else { 0.0 });
            self.integral[i].push(sums[i].clamp(f32::MIN.into(), f32::MAX.into()) as f32);
            // Simpson's rule: a product of two linear functions is integrated exactly.
            let (c0, c1) = if i == 0 { (1.0, 1.0) } else { (a[i], b[i]) };
            sums[i] += width * (a[0] * c0 + (a[0] + b[0]) * (c0 + c1) + b[0] * c1) / 6.0;
        }
    }

    /// The same in registers, if there are few.
    fn few(&self) -> Option<Tables<[f32; FEW]>> {
        if self.origin.len() > FEW {
            return None;
        }
        let few = |list: &Vec<f32>, padding: f32| core::array::from_fn(|i| *list.get(i).unwrap_or(&padding));
        Some(Tables {
            ends: few(&self.ends, f32::INFINITY),
            origin: few(&self.origin, 0.0),
            at: [0, 1, 2, 3].map(|i| few(&self.at[i], 0.0)),
            slope: [0, 1, 2, 3].map(|i| few(&self.slope[i], 0.0)),
            integral: [0, 1, 2, 3].map(|i| few(&self.integral[i], 0.0)),
        })
    }

    fn padded(mut self) -> Self {
        self.ends.resize((self.ends.len() + 1).next_power_of_two() - 1, f32::INFINITY);
        self
    }
}

/// Tables that lanes look things up in.
trait LookUp {
    /// Number `i` of a list in each lane.
    fn look<T: Token>(&self, token: T, list: &Self::List, i: T::I32) -> T::F32;
    /// A list of numbers.
    type List;
    /// The pieces that values are in. NaN is in the first.
    fn piece<T: Token>(&self, token: T, value: T::F32) -> T::I32;
}

impl LookUp for Tables<[f32; FEW]> {
    type List = [f32; FEW];

    #[inline(always)]
    fn look<T: Token>(&self, token: T, list: &[f32; FEW], i: T::I32) -> T::F32 {
        token.lookup(list, i)
    }

    #[inline(always)]
    fn piece<T: Token>(&self, token: T, value: T::F32) -> T::I32 {
        let piece = step(token, token.splat_i32(0), value, token.splat(self.ends[FEW / 2 - 1]), FEW / 2);
        let piece = step(token, piece, value, token.lookup(&self.ends, piece + token.splat_i32(3)), 4);
        let piece = step(token, piece, value, token.lookup(&self.ends, piece + token.splat_i32(1)), 2);
        step(token, piece, value, token.lookup(&self.ends, piece), 1)
    }
}

impl LookUp for Tables<Vec<f32>> {
    type List = Vec<f32>;

    #[inline(always)]
    fn look<T: Token>(&self, token: T, list: &Vec<f32>, i: T::I32) -> T::F32 {
        token.gather(list, i, token.mask(u32::MAX))
    }

    #[inline(always)]
    fn piece<T: Token>(&self, token: T, value: T::F32) -> T::I32 {
        let (mut piece, mut half) = (token.splat_i32(0), self.ends.len().div_ceil(2));
        while half > 0 {
            let end = self.look(token, &self.ends, piece + token.splat_i32(half as i32 - 1));
            piece = step(token, piece, value, end, half);
            half /= 2;
        }
        piece
    }
}

/// A step of the search for the number of ends that are not above a value, from its highest bit down.
#[inline(always)]
fn step<T: Token>(token: T, piece: T::I32, value: T::F32, end: T::F32, half: usize) -> T::I32 {
    (piece + token.splat_i32(half as i32)).select(value.ge(end), piece)
}

impl<L> Tables<L> {
    #[inline(always)]
    fn seen<T: Token>(&self, token: T, value: T::F32) -> Look<T>
    where
        Self: LookUp<List = L>,
    {
        let (zero, known) = (token.splat(0.0), value.eq(value));
        let piece = self.piece(token, value);
        let from = (value - self.look(token, &self.origin, piece)).select(known, zero);
        let mut seen = [zero; 4];
        for i in 0..4 {
            let (at, slope) = (self.look(token, &self.at[i], piece), self.look(token, &self.slope[i], piece));
            seen[i] = slope.mul_add(from, at);
        }
        seen[0] = seen[0].max(zero).select(known, zero);
        Look { value, piece, seen }
    }

    /// The integrals from the first knot to a value.
    #[inline(always)]
    fn integrals<T: Token>(&self, token: T, look: &Look<T>) -> [T::F32; 4]
    where
        Self: LookUp<List = L>,
    {
        let Look { value, piece, seen } = *look;
        let width = value - self.look(token, &self.origin, piece);
        let at = self.look(token, &self.at[0], piece);
        let mut out = [width; 4];
        out[0] = ((at + seen[0]) * token.splat(0.5)).mul_add(width, self.look(token, &self.integral[0], piece));
        let sixth = width * token.splat(1.0 / 6.0);
        for i in 1..4 {
            let color = self.look(token, &self.at[i], piece);
            let sum = self.look(token, &self.integral[i], piece);
            out[i] = simpson::<T>(at, color, seen[0], seen[i]).mul_add(sixth, sum);
        }
        out
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
        match &transfer.many {
            None => transfer.few.seen(token, value),
            Some(many) => many.seen(token, value),
        }
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
                let exact = (to[i] - from[i]) / distance;
                let sound = exact.abs().le(token.splat(f32::MAX));
                average[i] = exact.select(apart & sound, average[i]);
            }
        }
        average
    }

    /// The integrals from the first knot to the value.
    #[inline(always)]
    fn integrals(&self, token: T, transfer: &Transfer) -> [T::F32; 4] {
        match &transfer.many {
            None => transfer.few.integrals(token, self),
            Some(many) => many.integrals(token, self),
        }
    }
}

/// Six times the average of the product of two functions that are linear from `a0`, `b0` to `a1`, `b1`.
#[inline(always)]
fn simpson<T: Token>(a0: T::F32, b0: T::F32, a1: T::F32, b1: T::F32) -> T::F32 {
    (a0 + a1).mul_add(b0 + b1, a1.mul_add(b1, a0 * b0))
}
