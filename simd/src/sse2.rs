//! [`Sse2`]: four unfused lanes, the baseline that every processor has.
//!
//! On `wide`, whose four lanes are SSE2 on x86_64, NEON on aarch64, simd128 on wasm, and an array elsewhere. Where the
//! processors differ (NaN in a minimum, conversion out of range) this file says what x86 does.

use core::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Sub};

use bytemuck::cast;
use wide::{f32x4, i32x4, u32x4};

use crate::window::{window, window_mut};
use crate::{F32Lanes, I32Lanes, Level, MaskLanes, Task, Token};

/// The token of four unfused lanes. Every machine has it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sse2(());

/// Four `f32`.
#[derive(Clone, Copy, Debug)]
pub struct Sse2F32(f32x4);

/// Four 32-bit integers.
#[derive(Clone, Copy, Debug)]
pub struct Sse2I32(i32x4);

/// Four truth values; the bits of a lane are all zero or all one.
#[derive(Clone, Copy, Debug)]
pub struct Sse2Mask(u32x4);

impl Sse2 {
    /// Always there.
    #[must_use]
    #[inline(always)]
    #[expect(clippy::new_without_default, reason = "tokens are asked for by name, never defaulted")]
    pub const fn new() -> Self {
        Self(())
    }

    /// The same lanes.
    #[must_use]
    #[inline(always)]
    pub fn from_wide(self, x: f32x4) -> Sse2F32 {
        Sse2F32(x)
    }
}

impl Token for Sse2 {
    const LEVEL: Level = Level::Sse2;
    const LANES: usize = 4;
    const FUSED: bool = false;
    type F32 = Sse2F32;
    type I32 = Sse2I32;
    type Mask = Sse2Mask;
    type Narrow = Self;

    #[inline(always)]
    fn narrow(self) -> Self {
        self
    }

    #[inline(always)]
    fn run<K: Task>(self, task: K) -> K::Output {
        /// Kept out of line, as at the other levels, so that they compare like with like.
        #[inline(never)]
        fn region<K: Task>(token: Sse2, task: K) -> K::Output {
            task.run(token)
        }
        region(self, task)
    }

    #[inline(always)]
    fn splat(self, x: f32) -> Sse2F32 {
        Sse2F32(f32x4::splat(x))
    }
    #[inline(always)]
    fn splat_i32(self, x: i32) -> Sse2I32 {
        Sse2I32(i32x4::splat(x))
    }
    #[inline(always)]
    fn iota(self) -> Sse2I32 {
        Sse2I32(i32x4::new([0, 1, 2, 3]))
    }
    #[inline(always)]
    fn load(self, src: &[f32], at: usize) -> Sse2F32 {
        match window::<f32, 4>(src, at) {
            Some(four) => Sse2F32(f32x4::new(*four)),
            None => Sse2F32(f32x4::new(tail(src, at))),
        }
    }
    #[inline(always)]
    fn repeat(self, four: &[f32; 4], _at: usize) -> Sse2F32 {
        Sse2F32(f32x4::new(*four))
    }
    #[inline(always)]
    fn load_masked(self, src: &[f32], at: usize, mask: Sse2Mask) -> Sse2F32 {
        Sse2F32(self.load(src, at).0 & mask.as_f32())
    }
    #[inline(always)]
    fn load_u32(self, src: &[u32], at: usize) -> Sse2I32 {
        match window::<u32, 4>(src, at) {
            Some(four) => Sse2I32(cast(*four)),
            None => Sse2I32(cast(tail(src, at))),
        }
    }
    #[inline(always)]
    fn gather(self, src: &[f32], index: Sse2I32, mask: Sse2Mask) -> Sse2F32 {
        let index: [u32; 4] = cast(index.0);
        let mut lanes = [0.0; 4];
        for i in 0..4 {
            if let Some(&x) = src.get(index[i] as usize) {
                lanes[i] = x;
            }
        }
        Sse2F32(f32x4::new(lanes) & mask.as_f32())
    }
    #[inline(always)]
    fn lookup(self, table: &[f32; 16], index: Sse2I32) -> Sse2F32 {
        let index: [u32; 4] = cast(index.0);
        Sse2F32(f32x4::new([
            table[(index[0] & 15) as usize],
            table[(index[1] & 15) as usize],
            table[(index[2] & 15) as usize],
            table[(index[3] & 15) as usize],
        ]))
    }
    #[inline(always)]
    fn gather_rows<const R: usize>(self, rows: &[[f32; 8]; R], index: Sse2I32) -> [Sse2F32; 8] {
        const { assert!(R.is_power_of_two()) };
        let index: [u32; 4] = cast(index.0);
        let mut halves = [[f32x4::ZERO; 4]; 2];
        for i in 0..4 {
            let [a, b, c, d, e, f, g, h] = rows[index[i] as usize % R];
            (halves[0][i], halves[1][i]) = (f32x4::new([a, b, c, d]), f32x4::new([e, f, g, h]));
        }
        let ([a, b, c, d], [e, f, g, h]) = (f32x4::transpose(halves[0]), f32x4::transpose(halves[1]));
        [Sse2F32(a), Sse2F32(b), Sse2F32(c), Sse2F32(d), Sse2F32(e), Sse2F32(f), Sse2F32(g), Sse2F32(h)]
    }
    #[inline(always)]
    fn is_member(self, set: &[u32; 4], index: Sse2I32) -> Sse2Mask {
        let index: [u32; 4] = cast(index.0);
        let mut lanes = [0; 4];
        for i in 0..4 {
            lanes[i] = (set[(index[i] / 32 % 4) as usize] >> (index[i] % 32) & 1).wrapping_neg();
        }
        Sse2Mask(u32x4::new(lanes))
    }
    #[inline(always)]
    fn mask(self, bits: u32) -> Sse2Mask {
        let lane = u32x4::new([1, 2, 4, 8]);
        Sse2Mask((u32x4::splat(bits) & lane).simd_eq(lane))
    }
    #[inline(always)]
    fn first(self, n: usize) -> Sse2Mask {
        self.iota().lt(self.splat_i32(n.min(4) as i32))
    }
}

/// What there is of `src[at..at + 4]`, and then zeros. Lane by lane, as a copy of unknown length would be a call.
#[inline(always)]
fn tail<X: Copy + Default>(src: &[X], at: usize) -> [X; 4] {
    let mut four = [X::default(); 4];
    for (i, lane) in four.iter_mut().enumerate() {
        // No slice reaches index usize::MAX: where the sum saturates there is nothing to read.
        if let Some(&x) = src.get(at.saturating_add(i)) {
            *lane = x;
        }
    }
    four
}

/// Writes the lanes in `bits`, of those that `dst` has.
#[inline(always)]
fn store_tail<X: Copy>(four: [X; 4], dst: &mut [X], at: usize, bits: u32) {
    for (i, x) in four.into_iter().enumerate() {
        if bits >> i & 1 == 1
            && let Some(lane) = dst.get_mut(at.saturating_add(i))
        {
            *lane = x;
        }
    }
}

/// Binary operators that are one operator of `wide` each.
macro_rules! operators {
    ($lanes:ident: $($trait:ident $op:ident),+) => {$(
        impl $trait for $lanes {
            type Output = Self;
            #[inline(always)]
            fn $op(self, other: Self) -> Self {
                Self(self.0.$op(other.0))
            }
        }
    )+};
}
operators!(Sse2F32: Add add, Sub sub, Mul mul, Div div);
operators!(Sse2I32: Add add, Sub sub, Mul mul, BitAnd bitand, BitOr bitor, BitXor bitxor);
operators!(Sse2Mask: BitAnd bitand, BitOr bitor, BitXor bitxor);

/// Comparisons of floats.
macro_rules! comparisons {
    ($($method:ident $simd:ident),+) => {$(
        #[inline(always)]
        fn $method(self, other: Self) -> Sse2Mask {
            Sse2Mask(cast(self.0.$simd(other.0)))
        }
    )+};
}

/// Minimum and maximum by the NaN rule: the instruction on x86, a comparison and a blend elsewhere.
macro_rules! extrema {
    ($($method:ident $comparison:ident $intrinsic:ident),+) => {$(
        #[inline(always)]
        fn $method(self, other: Self) -> Self {
            #[cfg(target_arch = "x86_64")]
            {
                // SAFETY: SSE is part of every x86_64 processor, and so of this target.
                Self(cast(unsafe { core::arch::x86_64::$intrinsic(cast(self.0), cast(other.0)) }))
            }
            #[cfg(not(target_arch = "x86_64"))]
            {
                self.select(self.$comparison(other), other)
            }
        }
    )+};
}

/// Folds the halves, then the last two lanes.
macro_rules! reductions {
    ($($method:ident |$a:ident, $b:ident| $fold:expr),+) => {$(
        #[inline(always)]
        fn $method(self) -> f32 {
            #[inline(always)]
            fn fold($a: f32, $b: f32) -> f32 {
                $fold
            }
            let [x, y, z, w] = self.0.to_array();
            fold(fold(x, z), fold(y, w))
        }
    )+};
}

impl Sse2F32 {
    /// The same lanes.
    #[must_use]
    #[inline(always)]
    pub fn to_wide(self) -> f32x4 {
        self.0
    }
}

impl Neg for Sse2F32 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(self.0 ^ f32x4::splat(-0.0))
    }
}

impl F32Lanes for Sse2F32 {
    type Mask = Sse2Mask;
    type I32 = Sse2I32;

    // `wide`'s own mul_add fuses when the build has FMA; this family must not.
    #[inline(always)]
    fn mul_add(self, a: Self, b: Self) -> Self {
        self * a + b
    }
    #[inline(always)]
    fn mul_sub(self, a: Self, b: Self) -> Self {
        self * a - b
    }
    #[inline(always)]
    fn neg_mul_add(self, a: Self, b: Self) -> Self {
        b - self * a
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        #[cfg(any(target_arch = "x86_64", target_arch = "aarch64", target_feature = "simd128"))]
        {
            Self(self.0.sqrt())
        }
        #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64", target_feature = "simd128")))]
        {
            Self(f32x4::new(self.0.to_array().map(crate::scalar::sqrt)))
        }
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0 & f32x4::splat(f32::from_bits(0x7fff_ffff)))
    }
    extrema!(min lt _mm_min_ps, max gt _mm_max_ps);
    comparisons!(lt simd_lt, le simd_le, gt simd_gt, ge simd_ge, eq simd_eq, ne simd_ne);
    #[inline(always)]
    fn select(self, mask: Sse2Mask, other: Self) -> Self {
        Self(mask.as_f32().bitselect(self.0, other.0))
    }
    #[inline(always)]
    fn to_bits(self) -> Sse2I32 {
        Sse2I32(cast(self.0))
    }
    #[inline(always)]
    fn to_i32(self) -> Sse2I32 {
        let converted = Sse2I32(self.0.fast_trunc_int());
        #[cfg(target_arch = "x86_64")]
        {
            converted
        }
        #[cfg(not(target_arch = "x86_64"))]
        {
            let limit = Self(f32x4::splat(2_147_483_648.0));
            converted.select(self.ge(-limit) & self.lt(limit), Sse2I32(i32x4::splat(i32::MIN)))
        }
    }
    #[inline(always)]
    fn store(self, dst: &mut [f32], at: usize) {
        match window_mut::<f32, 4>(dst, at) {
            Some(four) => *four = self.0.to_array(),
            None => store_tail(self.0.to_array(), dst, at, 0b1111),
        }
    }
    #[inline(always)]
    fn store_masked(self, dst: &mut [f32], at: usize, mask: Sse2Mask) {
        match window_mut::<f32, 4>(dst, at) {
            Some(four) => *four = mask.as_f32().bitselect(self.0, f32x4::new(*four)).to_array(),
            None => store_tail(self.0.to_array(), dst, at, mask.bits()),
        }
    }
    reductions!(
        reduce_min | a,
        b | if a < b { a } else { b },
        reduce_max | a,
        b | if a > b { a } else { b },
        reduce_add | a,
        b | a + b
    );
}

impl I32Lanes for Sse2I32 {
    type Mask = Sse2Mask;
    type F32 = Sse2F32;

    #[inline(always)]
    fn shl(self, n: u32) -> Self {
        Self(cast(cast::<_, u32x4>(self.0).unbounded_shl_scalar(n)))
    }
    #[inline(always)]
    fn shr(self, n: u32) -> Self {
        Self(cast(cast::<_, u32x4>(self.0).unbounded_shr_scalar(n)))
    }
    #[inline(always)]
    fn eq(self, other: Self) -> Sse2Mask {
        Sse2Mask(cast(self.0.simd_eq(other.0)))
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Sse2Mask {
        Sse2Mask(cast(self.0.simd_lt(other.0)))
    }
    #[inline(always)]
    fn lt_unsigned(self, other: Self) -> Sse2Mask {
        // SSE2 has no unsigned comparison: moving both by 2^31 turns it into the signed one.
        let sign = Self(i32x4::splat(i32::MIN));
        (self ^ sign).lt(other ^ sign)
    }
    #[inline(always)]
    fn select(self, mask: Sse2Mask, other: Self) -> Self {
        Self(cast::<_, i32x4>(mask.0).bitselect(self.0, other.0))
    }
    #[inline(always)]
    fn to_f32(self) -> Sse2F32 {
        Sse2F32(f32x4::from_i32x4(self.0))
    }
    #[inline(always)]
    fn from_bits_f32(self) -> Sse2F32 {
        Sse2F32(cast(self.0))
    }
    #[inline(always)]
    fn store(self, dst: &mut [u32], at: usize) {
        self.from_bits_f32().store(bytemuck::cast_slice_mut(dst), at);
    }
    #[inline(always)]
    fn store_masked(self, dst: &mut [u32], at: usize, mask: Sse2Mask) {
        self.from_bits_f32().store_masked(bytemuck::cast_slice_mut(dst), at, mask);
    }
}

impl Sse2Mask {
    #[inline(always)]
    fn as_f32(self) -> f32x4 {
        cast(self.0)
    }
}

impl Not for Sse2Mask {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self(self.0 ^ u32x4::splat(u32::MAX))
    }
}

impl MaskLanes for Sse2Mask {
    #[inline(always)]
    fn and_not(self, other: Self) -> Self {
        self & !other
    }
    #[inline(always)]
    fn any(self) -> bool {
        self.0.any()
    }
    #[inline(always)]
    fn all(self) -> bool {
        self.0.all()
    }
    #[inline(always)]
    fn bits(self) -> u32 {
        self.0.to_bitmask()
    }
}
