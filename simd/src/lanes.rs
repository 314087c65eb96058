//! The lane traits: what every level can do, written once.
//!
//! A [`Token`] proves that its instruction set is there; lane values come only from a token, so their methods are safe.
//! Two families of numerics: *unfused* ([`Scalar`](crate::Scalar), [`Sse2`](crate::Sse2)) and *fused* (`Fused`, `Avx2`,
//! `Avx512`; x86_64 only). Inside a family every operation gives the same bits at every level, for all inputs, with one
//! exception: where arithmetic (`+ - * /`, `mul_add` and its kin, `sqrt`, `reduce_add`) gives a NaN, it gives a NaN at
//! every level, but sign and payload of that NaN are not promised, because compilers may swap operands. What merely moves
//! lanes keeps the bits of a NaN.

use core::fmt::Debug;
use core::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Sub};

use crate::Level;

/// A value that proves that a level's instructions may be executed here, and that makes its lanes.
///
/// Loads and stores are total: a lane beyond the end of the slice reads as zero and is not written.
pub trait Token: Copy + Debug + Send + Sync + 'static {
    /// The level that this token proves.
    const LEVEL: Level;
    /// Lanes per vector (the lane width W), at most 16.
    const LANES: usize;
    /// Does [`F32Lanes::mul_add`] round once (fused) or twice?
    const FUSED: bool;
    /// Vector of `f32`.
    type F32: F32Lanes<Mask = Self::Mask, I32 = Self::I32>;
    /// Vector of 32-bit integers.
    type I32: I32Lanes<Mask = Self::Mask, F32 = Self::F32>;
    /// One truth value a lane.
    type Mask: MaskLanes;
    /// The level of the same family with at most eight lanes: for work that has only eight, as the children of a node.
    type Narrow: Token;

    /// This level's narrow one, which it implies.
    fn narrow(self) -> Self::Narrow;

    /// Enters a region compiled for this level and runs `task` in it. Everything from `task` down to the lane
    /// operation must be `#[inline(always)]`.
    fn run<K: Task>(self, task: K) -> K::Output;

    /// All lanes equal to `x`.
    fn splat(self, x: f32) -> Self::F32;
    /// All lanes equal to `x`.
    fn splat_i32(self, x: i32) -> Self::I32;
    /// 0, 1, 2, ...
    fn iota(self) -> Self::I32;
    /// Lanes `src[at..at + LANES]`; lanes beyond the end are zero.
    fn load(self, src: &[f32], at: usize) -> Self::F32;
    /// As [`load`](Self::load), of the lanes set in `mask`; the others are zero.
    fn load_masked(self, src: &[f32], at: usize, mask: Self::Mask) -> Self::F32;
    /// `four[0]`, ..., `four[3]`, `four[0]`, ...: the same four in each four lanes. Of one lane `four[at % 4]`.
    fn repeat(self, four: &[f32; 4], at: usize) -> Self::F32;
    /// Lanes `src[at..at + LANES]`; lanes beyond the end are zero.
    fn load_u32(self, src: &[u32], at: usize) -> Self::I32;
    /// `src[index]` in each lane of `mask`; zero where the mask is off or the index (read as unsigned) is out of range.
    fn gather(self, src: &[f32], index: Self::I32, mask: Self::Mask) -> Self::F32;
    /// `table[index]` in each lane, by the lowest four bits of the index: a permutation of registers where there is one, and then much
    /// faster than a gather.
    fn lookup(self, table: &[f32; 16], index: Self::I32) -> Self::F32;
    /// Rows of eight, one a lane, as eight vectors: lane i of vector k is `rows[index[i] % R][k]`. A row is read at once and all of them are
    /// transposed: several times faster than eight gathers. R is a power of two.
    fn gather_rows<const R: usize>(self, rows: &[[f32; 8]; R], index: Self::I32) -> [Self::F32; 8];
    /// Is `index % 128` in the set? Bit i of word w says it of 32 w + i.
    fn is_member(self, set: &[u32; 4], index: Self::I32) -> Self::Mask;
    /// Lane i is set when bit i is.
    fn mask(self, bits: u32) -> Self::Mask;
    /// The first `n` lanes (all of them when `n >= LANES`).
    #[inline(always)]
    fn first(self, n: usize) -> Self::Mask {
        self.mask(if n >= 32 { u32::MAX } else { (1u32 << n) - 1 })
    }
}

/// Work generic over the level, entered once per packet through [`Token::run`] or [`AnyToken::run`](crate::AnyToken::run).
pub trait Task {
    /// What it returns.
    type Output;
    /// The work. Mark the implementation `#[inline(always)]`.
    fn run<T: Token>(self, token: T) -> Self::Output;
}

/// Lanes of `f32`. All arithmetic is IEEE-754 single precision, round to nearest even; no estimates.
///
/// Negation and [`abs`](Self::abs) change the sign bit only, of a NaN too.
///
/// The NaN rule of [`min`](Self::min) and [`max`](Self::max), the only one: `a.min(b)` is `if a < b { a } else { b }`, so
/// a NaN on either side, or two zeros, gives `b`. Comparisons with a NaN are false ([`ne`](Self::ne) is true).
pub trait F32Lanes:
    Copy + Debug + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// Truth values of the same lanes.
    type Mask: MaskLanes;
    /// Integers of the same lanes.
    type I32: Copy;
    /// `self * a + b`: rounded once in the fused family, twice in the other.
    fn mul_add(self, a: Self, b: Self) -> Self;
    /// `self * a - b`, rounded as [`mul_add`](Self::mul_add).
    fn mul_sub(self, a: Self, b: Self) -> Self;
    /// `b - self * a`, rounded as [`mul_add`](Self::mul_add).
    fn neg_mul_add(self, a: Self, b: Self) -> Self;
    /// Exactly rounded square root.
    fn sqrt(self) -> Self;
    /// Clears the sign bit.
    fn abs(self) -> Self;
    /// `if self < other { self } else { other }`.
    fn min(self, other: Self) -> Self;
    /// `if self > other { self } else { other }`.
    fn max(self, other: Self) -> Self;
    /// `self < other`
    fn lt(self, other: Self) -> Self::Mask;
    /// `self <= other`
    fn le(self, other: Self) -> Self::Mask;
    /// `self > other`
    fn gt(self, other: Self) -> Self::Mask;
    /// `self >= other`
    fn ge(self, other: Self) -> Self::Mask;
    /// `self == other`
    fn eq(self, other: Self) -> Self::Mask;
    /// `self != other`
    fn ne(self, other: Self) -> Self::Mask;
    /// `if mask { self } else { other }`, bit for bit.
    fn select(self, mask: Self::Mask, other: Self) -> Self;
    /// The bits, unchanged.
    fn to_bits(self) -> Self::I32;
    /// Towards zero; out of range or NaN gives `i32::MIN`, as x86 does.
    fn to_i32(self) -> Self::I32;
    /// Writes `dst[at..at + LANES]`; lanes beyond the end are dropped.
    fn store(self, dst: &mut [f32], at: usize);
    /// As [`store`](Self::store), of the lanes set in `mask`; the others keep their value.
    fn store_masked(self, dst: &mut [f32], at: usize, mask: Self::Mask);
    /// Folds all lanes with [`min`](Self::min): repeatedly lane i with lane i + W/2. With no NaN, the least lane.
    fn reduce_min(self) -> f32;
    /// Folds all lanes with [`max`](Self::max): repeatedly lane i with lane i + W/2. With no NaN, the greatest lane.
    fn reduce_max(self) -> f32;
    /// Folds all lanes with `+`: repeatedly lane i with lane i + W/2.
    fn reduce_add(self) -> f32;
}

/// Lanes of 32-bit integers, wrapping; the operation says whether it reads them as signed.
pub trait I32Lanes:
    Copy
    + Debug
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + BitAnd<Output = Self>
    + BitOr<Output = Self>
    + BitXor<Output = Self>
{
    /// Truth values of the same lanes.
    type Mask: MaskLanes;
    /// Floats of the same lanes.
    type F32: Copy;
    /// Shift left by `n` bits; zero from 32 on.
    fn shl(self, n: u32) -> Self;
    /// Logical shift right by `n` bits; zero from 32 on.
    fn shr(self, n: u32) -> Self;
    /// Equal.
    fn eq(self, other: Self) -> Self::Mask;
    /// Less, read as signed.
    fn lt(self, other: Self) -> Self::Mask;
    /// Less, read as unsigned.
    fn lt_unsigned(self, other: Self) -> Self::Mask;
    /// `if mask { self } else { other }`.
    fn select(self, mask: Self::Mask, other: Self) -> Self;
    /// The nearest float, read as signed, ties to even.
    fn to_f32(self) -> Self::F32;
    /// The bits, unchanged.
    #[expect(clippy::wrong_self_convention, reason = "named after `f32::from_bits`, of which it is the vector form")]
    fn from_bits_f32(self) -> Self::F32;
    /// Writes `dst[at..at + LANES]`; lanes beyond the end are dropped.
    fn store(self, dst: &mut [u32], at: usize);
    /// As [`store`](Self::store), of the lanes set in `mask`; the others keep their value.
    fn store_masked(self, dst: &mut [u32], at: usize, mask: Self::Mask);
}

/// One truth value a lane.
pub trait MaskLanes:
    Copy + Debug + BitAnd<Output = Self> + BitOr<Output = Self> + BitXor<Output = Self> + Not<Output = Self>
{
    /// `self & !other`
    fn and_not(self, other: Self) -> Self;
    /// Is a lane set?
    fn any(self) -> bool;
    /// Are all lanes set?
    fn all(self) -> bool;
    /// Bit i is lane i; bits from LANES up are zero.
    fn bits(self) -> u32;
}
