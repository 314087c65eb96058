//! One lane: what [`Scalar`](crate::Scalar) and the fused twin have in common, which is everything but `mul_add`.
//!
//! This is the definition that every other level must equal bit for bit, so it is written to be read, not to be fast.

use core::fmt::Debug;
use core::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Sub};

use crate::{F32Lanes, I32Lanes, MaskLanes};

/// What a one-lane token adds to plain arithmetic. Only this crate can implement it.
pub trait OneLane: Copy + Debug + Send + Sync + 'static + sealed::Sealed {
    /// `a * b + c`, rounded as the family does.
    fn mul_add(self, a: f32, b: f32, c: f32) -> f32;
    /// The exactly rounded square root.
    fn sqrt(self, x: f32) -> f32;
}

pub(crate) mod sealed {
    pub trait Sealed {}
}

/// One `f32`, and the token it came from.
#[derive(Clone, Copy, Debug)]
pub struct OneF32<T>(pub(crate) f32, pub(crate) T);

/// One 32-bit integer, and the token it came from.
#[derive(Clone, Copy, Debug)]
pub struct OneI32<T>(pub(crate) i32, pub(crate) T);

/// One truth value.
#[derive(Clone, Copy, Debug)]
pub struct OneMask(pub(crate) bool);

macro_rules! float_operations {
    ($($trait:ident $op:ident),+) => {$(
        impl<T: OneLane> $trait for OneF32<T> {
            type Output = Self;
            #[inline(always)]
            fn $op(self, other: Self) -> Self {
                Self(self.0.$op(other.0), self.1)
            }
        }
    )+};
}
float_operations!(Add add, Sub sub, Mul mul, Div div);

impl<T: OneLane> Neg for OneF32<T> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0, self.1)
    }
}

impl<T: OneLane> F32Lanes for OneF32<T> {
    type Mask = OneMask;
    type I32 = OneI32<T>;

    #[inline(always)]
    fn mul_add(self, a: Self, b: Self) -> Self {
        Self(self.1.mul_add(self.0, a.0, b.0), self.1)
    }
    #[inline(always)]
    fn mul_sub(self, a: Self, b: Self) -> Self {
        Self(self.1.mul_add(self.0, a.0, -b.0), self.1)
    }
    #[inline(always)]
    fn neg_mul_add(self, a: Self, b: Self) -> Self {
        Self(self.1.mul_add(-self.0, a.0, b.0), self.1)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.1.sqrt(self.0), self.1)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.abs(), self.1)
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        if self.0 < other.0 { self } else { other }
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        if self.0 > other.0 { self } else { other }
    }
    #[inline(always)]
    fn lt(self, other: Self) -> OneMask {
        OneMask(self.0 < other.0)
    }
    #[inline(always)]
    fn le(self, other: Self) -> OneMask {
        OneMask(self.0 <= other.0)
    }
    #[inline(always)]
    fn gt(self, other: Self) -> OneMask {
        OneMask(self.0 > other.0)
    }
    #[inline(always)]
    fn ge(self, other: Self) -> OneMask {
        OneMask(self.0 >= other.0)
    }
    #[inline(always)]
    fn eq(self, other: Self) -> OneMask {
        OneMask(self.0 == other.0)
    }
    #[inline(always)]
    fn ne(self, other: Self) -> OneMask {
        OneMask(self.0 != other.0)
    }
    #[inline(always)]
    fn select(self, mask: OneMask, other: Self) -> Self {
        if mask.0 { self } else { other }
    }
    #[inline(always)]
    fn to_bits(self) -> OneI32<T> {
        OneI32(self.0.to_bits() as i32, self.1)
    }
    #[inline(always)]
    fn to_i32(self) -> OneI32<T> {
        // 2^31 is the first float out of range; -2^31 is the last one in range.
        let in_range = self.0 >= -2_147_483_648.0 && self.0 < 2_147_483_648.0;
        OneI32(if in_range { self.0 as i32 } else { i32::MIN }, self.1)
    }
    #[inline(always)]
    fn store(self, dst: &mut [f32], at: usize) {
        if let Some(lane) = dst.get_mut(at) {
            *lane = self.0;
        }
    }
    #[inline(always)]
    fn store_masked(self, dst: &mut [f32], at: usize, mask: OneMask) {
        // Reads what it may keep, as the other levels do: a choice is cheaper than a branch that cannot be foretold.
        if let Some(lane) = dst.get_mut(at) {
            *lane = if mask.0 { self.0 } else { *lane };
        }
    }
    #[inline(always)]
    fn reduce_min(self) -> f32 {
        self.0
    }
    #[inline(always)]
    fn reduce_max(self) -> f32 {
        self.0
    }
    #[inline(always)]
    fn reduce_add(self) -> f32 {
        self.0
    }
}

macro_rules! integer_operations {
    ($($trait:ident $op:ident $method:ident),+) => {$(
        impl<T: OneLane> $trait for OneI32<T> {
            type Output = Self;
            #[inline(always)]
            fn $op(self, other: Self) -> Self {
                Self(self.0.$method(other.0), self.1)
            }
        }
    )+};
}
integer_operations!(Add add wrapping_add, Sub sub wrapping_sub, Mul mul wrapping_mul);
integer_operations!(BitAnd bitand bitand, BitOr bitor bitor, BitXor bitxor bitxor);

impl<T: OneLane> I32Lanes for OneI32<T> {
    type Mask = OneMask;
    type F32 = OneF32<T>;

    #[inline(always)]
    fn shl(self, n: u32) -> Self {
        Self(if n < 32 { self.0 << n } else { 0 }, self.1)
    }
    #[inline(always)]
    fn shr(self, n: u32) -> Self {
        Self(if n < 32 { (self.0 as u32 >> n) as i32 } else { 0 }, self.1)
    }
    #[inline(always)]
    fn eq(self, other: Self) -> OneMask {
        OneMask(self.0 == other.0)
    }
    #[inline(always)]
    fn lt(self, other: Self) -> OneMask {
        OneMask(self.0 < other.0)
    }
    #[inline(always)]
    fn lt_unsigned(self, other: Self) -> OneMask {
        OneMask((self.0 as u32) < other.0 as u32)
    }
    #[inline(always)]
    fn select(self, mask: OneMask, other: Self) -> Self {
        if mask.0 { self } else { other }
    }
    #[inline(always)]
    fn to_f32(self) -> OneF32<T> {
        OneF32(self.0 as f32, self.1)
    }
    #[inline(always)]
    fn from_bits_f32(self) -> OneF32<T> {
        OneF32(f32::from_bits(self.0 as u32), self.1)
    }
    #[inline(always)]
    fn store(self, dst: &mut [u32], at: usize) {
        if let Some(lane) = dst.get_mut(at) {
            *lane = self.0 as u32;
        }
    }
    #[inline(always)]
    fn store_masked(self, dst: &mut [u32], at: usize, mask: OneMask) {
        // Reads what it may keep, as the other levels do: a choice is cheaper than a branch that cannot be foretold.
        if let Some(lane) = dst.get_mut(at) {
            *lane = if mask.0 { self.0 as u32 } else { *lane };
        }
    }
}

macro_rules! mask_operations {
    ($($trait:ident $op:ident),+) => {$(
        impl $trait for OneMask {
            type Output = Self;
            #[inline(always)]
            fn $op(self, other: Self) -> Self {
                Self(self.0.$op(other.0))
            }
        }
    )+};
}
mask_operations!(BitAnd bitand, BitOr bitor, BitXor bitxor);

impl Not for OneMask {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self(!self.0)
    }
}

impl MaskLanes for OneMask {
    #[inline(always)]
    fn and_not(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }
    #[inline(always)]
    fn any(self) -> bool {
        self.0
    }
    #[inline(always)]
    fn all(self) -> bool {
        self.0
    }
    #[inline(always)]
    fn bits(self) -> u32 {
        u32::from(self.0)
    }
}

/// The part of [`Token`](crate::Token) that both one-lane tokens share.
macro_rules! one_lane_token {
    () => {
        const LANES: usize = 1;
        type F32 = $crate::one_lane::OneF32<Self>;
        type I32 = $crate::one_lane::OneI32<Self>;
        type Mask = $crate::one_lane::OneMask;
        type Narrow = Self;

        #[inline(always)]
        fn narrow(self) -> Self {
            self
        }

        #[inline(always)]
        fn splat(self, x: f32) -> Self::F32 {
            $crate::one_lane::OneF32(x, self)
        }
        #[inline(always)]
        fn splat_i32(self, x: i32) -> Self::I32 {
            $crate::one_lane::OneI32(x, self)
        }
        #[inline(always)]
        fn iota(self) -> Self::I32 {
            self.splat_i32(0)
        }
        #[inline(always)]
        fn load(self, src: &[f32], at: usize) -> Self::F32 {
            self.splat(if at < src.len() { src[at] } else { 0.0 })
        }
        #[inline(always)]
        fn repeat(self, four: &[f32; 4], at: usize) -> Self::F32 {
            self.splat(four[at % 4])
        }
        #[inline(always)]
        fn load_masked(self, src: &[f32], at: usize, mask: Self::Mask) -> Self::F32 {
            self.splat(if mask.0 && at < src.len() { src[at] } else { 0.0 })
        }
        #[inline(always)]
        fn load_u32(self, src: &[u32], at: usize) -> Self::I32 {
            self.splat_i32(if at < src.len() { src[at] as i32 } else { 0 })
        }
        #[inline(always)]
        fn gather(self, src: &[f32], index: Self::I32, mask: Self::Mask) -> Self::F32 {
            self.load_masked(src, index.0 as u32 as usize, mask)
        }
        #[inline(always)]
        fn lookup(self, table: &[f32; 16], index: Self::I32) -> Self::F32 {
            self.splat(table[(index.0 & 15) as usize])
        }
        #[inline(always)]
        fn gather_rows<const R: usize>(self, rows: &[[f32; 8]; R], index: Self::I32) -> [Self::F32; 8] {
            const { assert!(R.is_power_of_two()) };
            let [a, b, c, d, e, f, g, h] = rows[index.0 as u32 as usize % R];
            [
                self.splat(a),
                self.splat(b),
                self.splat(c),
                self.splat(d),
                self.splat(e),
                self.splat(f),
                self.splat(g),
                self.splat(h),
            ]
        }
        #[inline(always)]
        fn is_member(self, set: &[u32; 4], index: Self::I32) -> Self::Mask {
            let index = index.0 as u32;
            $crate::one_lane::OneMask(set[(index / 32 % 4) as usize] >> (index % 32) & 1 == 1)
        }
        #[inline(always)]
        fn mask(self, bits: u32) -> Self::Mask {
            $crate::one_lane::OneMask(bits & 1 == 1)
        }
    };
}
pub(crate) use one_lane_token;
