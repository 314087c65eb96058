//! [`Avx512`]: sixteen fused lanes, with masks in mask registers.

use core::arch::x86_64::*;
use core::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Sub};

use crate::window::{window, window_mut};
use crate::{Avx2, F32Lanes, I32Lanes, Level, MaskLanes, Task, Token};

/// The token of sixteen fused lanes: proof of AVX-512 F, BW, DQ and VL, and of all that [`Avx2`] proves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Avx512(Avx2);

/// Sixteen `f32`.
#[derive(Clone, Copy, Debug)]
pub struct Avx512F32(__m512);

/// Sixteen 32-bit integers.
#[derive(Clone, Copy, Debug)]
pub struct Avx512I32(__m512i);

/// Sixteen truth values, a bit each.
#[derive(Clone, Copy, Debug)]
pub struct Avx512Mask(__mmask16);

/// Executes intrinsics that touch no memory.
macro_rules! avx512 {
    ($intrinsics:expr) => {
        // SAFETY: this runs in a method of a token or of a lane value; lane values come only from tokens, and a token
        // only from `Avx512::detect`, which checked the features.
        unsafe { $intrinsics }
    };
}

/// Its argument, about which the compiler forgets what it knew, so that it blends and stores and does not make a masked
/// store of it, from which a load that follows cannot be forwarded. No instruction.
#[inline]
#[target_feature(enable = "avx512f")]
fn whole(mut x: __m512) -> __m512 {
    // SAFETY: an empty instruction that keeps its register.
    unsafe { core::arch::asm!("/* {0} */", inout(zmm_reg) x, options(pure, nomem, nostack, preserves_flags)) };
    x
}

cpufeatures::new!(detected, "avx512f", "avx512bw", "avx512dq", "avx512vl");

impl Avx512 {
    /// A token, if this machine (and its operating system) has the instructions.
    #[must_use]
    #[inline]
    pub fn detect() -> Option<Self> {
        if detected::get() { Avx2::detect().map(Self) } else { None }
    }

    /// The level below of the same family, which this one includes.
    #[must_use]
    #[inline(always)]
    pub const fn avx2(self) -> Avx2 {
        self.0
    }

    /// The same lanes.
    #[must_use]
    #[inline(always)]
    pub fn from_wide(self, x: wide::f32x16) -> Avx512F32 {
        Avx512F32(bytemuck::cast(x))
    }
}

/// The lanes from `at` on that a slice of this length has.
#[inline(always)]
fn in_range(length: usize, at: usize) -> __mmask16 {
    let n = length.saturating_sub(at);
    if n >= 16 { !0 } else { (1 << n) - 1 }
}

impl Token for Avx512 {
    const LEVEL: Level = Level::Avx512;
    const LANES: usize = 16;
    const FUSED: bool = true;
    type F32 = Avx512F32;
    type I32 = Avx512I32;
    type Mask = Avx512Mask;
    type Narrow = crate::Avx2;

    #[inline(always)]
    fn narrow(self) -> crate::Avx2 {
        self.avx2()
    }

    #[inline(always)]
    fn run<K: Task>(self, task: K) -> K::Output {
        #[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx2,fma,bmi1,bmi2,popcnt")]
        fn region<K: Task>(token: Avx512, task: K) -> K::Output {
            task.run(token)
        }
        // SAFETY: `Avx512::detect` and the `Avx2::detect` that it calls checked these very features before this token
        // was made.
        unsafe { region(self, task) }
    }

    #[inline(always)]
    fn splat(self, x: f32) -> Avx512F32 {
        Avx512F32(avx512!(_mm512_set1_ps(x)))
    }
    #[inline(always)]
    fn splat_i32(self, x: i32) -> Avx512I32 {
        Avx512I32(avx512!(_mm512_set1_epi32(x)))
    }
    #[inline(always)]
    fn iota(self) -> Avx512I32 {
        Avx512I32(avx512!(_mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15)))
    }
    #[inline(always)]
    fn load(self, src: &[f32], at: usize) -> Avx512F32 {
        self.load_masked(src, at, Avx512Mask(!0))
    }
    #[inline(always)]
    fn load_masked(self, src: &[f32], at: usize, mask: Avx512Mask) -> Avx512F32 {
        match window::<f32, 16>(src, at) {
            // SAFETY: AVX-512 by the token; sixteen floats may be read from an array of sixteen.
            Some(sixteen) => Avx512F32(unsafe { _mm512_maskz_loadu_ps(mask.0, sixteen.as_ptr()) }),
            None => {
                let mask = mask.0 & in_range(src.len(), at);
                // SAFETY: AVX-512 by the token; only lanes in the mask are read, and those lie within the slice.
                Avx512F32(unsafe { _mm512_maskz_loadu_ps(mask, src.as_ptr().wrapping_add(at)) })
            }
        }
    }
    #[inline(always)]
    fn repeat(self, four: &[f32; 4], _at: usize) -> Avx512F32 {
        // SAFETY: AVX-512 by the token; four floats may be read from an array of four.
        Avx512F32(unsafe { _mm512_broadcast_f32x4(_mm_loadu_ps(four.as_ptr())) })
    }
    #[inline(always)]
    fn load_u32(self, src: &[u32], at: usize) -> Avx512I32 {
        match window::<u32, 16>(src, at) {
            // SAFETY: AVX-512 by the token; sixteen integers may be read from an array of sixteen.
            Some(sixteen) => Avx512I32(unsafe { _mm512_loadu_si512(sixteen.as_ptr().cast()) }),
            None => {
                let mask = in_range(src.len(), at);
                // SAFETY: AVX-512 by the token; only lanes in the mask are read, and those lie within the slice.
                Avx512I32(unsafe { _mm512_maskz_loadu_epi32(mask, src.as_ptr().wrapping_add(at).cast()) })
            }
        }
    }
    #[inline(always)]
    fn gather(self, src: &[f32], index: Avx512I32, mask: Avx512Mask) -> Avx512F32 {
        // The instruction reads indices as signed, so it is shown no more of a slice than it can address.
        let length = src.len().min(i32::MAX as usize);
        let mask = mask & index.lt_unsigned(self.splat_i32(length as i32));
        let zero = self.splat(0.0);
        // SAFETY: AVX-512 by the token; only lanes in the mask are read, whose indices are less than the slice's length
        // and than i32::MAX.
        Avx512F32(unsafe { _mm512_mask_i32gather_ps::<4>(zero.0, mask.0, index.0, src.as_ptr()) })
    }
    #[inline(always)]
    fn lookup(self, table: &[f32; 16], index: Avx512I32) -> Avx512F32 {
        let table = self.load(table, 0);
        Avx512F32(avx512!(_mm512_permutexvar_ps(index.0, table.0)))
    }
    #[inline(always)]
    fn gather_rows<const R: usize>(self, rows: &[[f32; 8]; R], index: Avx512I32) -> [Avx512F32; 8] {
        const { assert!(R.is_power_of_two()) };
        let mut at = [0; 16];
        index.store(&mut at, 0);
        let mut out = [self.splat(0.0); 8];
        for half in 0..2 {
            let mut quads = [self.splat(0.0).0; 4];
            for i in 0..4 {
                let [a, b, c, d] = [i, i + 4, i + 8, i + 12];
                let [a, b, c, d] = [
                    &rows[at[a] as usize % R],
                    &rows[at[b] as usize % R],
                    &rows[at[c] as usize % R],
                    &rows[at[d] as usize % R],
                ];
                // SAFETY: AVX-512 by the token; four floats are read, from 0 or 4 on, of rows of eight.
                quads[i] = unsafe {
                    let quad = _mm512_castps128_ps512(_mm_loadu_ps(a.as_ptr().add(4 * half)));
                    let quad = _mm512_mask_broadcast_f32x4(quad, 0x00f0, _mm_loadu_ps(b.as_ptr().add(4 * half)));
                    let quad = _mm512_mask_broadcast_f32x4(quad, 0x0f00, _mm_loadu_ps(c.as_ptr().add(4 * half)));
                    _mm512_mask_broadcast_f32x4(quad, 0xf000, _mm_loadu_ps(d.as_ptr().add(4 * half)))
                };
            }
            // Four by four, in all quarters.
            let columns = avx512!({
                let (a, b) = (_mm512_unpacklo_ps(quads[0], quads[1]), _mm512_unpackhi_ps(quads[0], quads[1]));
                let (c, d) = (_mm512_unpacklo_ps(quads[2], quads[3]), _mm512_unpackhi_ps(quads[2], quads[3]));
                [
                    _mm512_shuffle_ps::<0x44>(a, c),
                    _mm512_shuffle_ps::<0xee>(a, c),
                    _mm512_shuffle_ps::<0x44>(b, d),
                    _mm512_shuffle_ps::<0xee>(b, d),
                ]
            });
            for i in 0..4 {
                out[4 * half + i] = Avx512F32(columns[i]);
            }
        }
        out
    }
    #[inline(always)]
    fn is_member(self, set: &[u32; 4], index: Avx512I32) -> Avx512Mask {
        // SAFETY: AVX-512 by the token; four words are read from an array of four.
        Avx512Mask(unsafe {
            let words = _mm512_broadcast_f32x4(_mm_loadu_ps(set.as_ptr().cast()));
            let word = _mm512_permutevar_ps(words, _mm512_srli_epi32::<5>(index.0));
            let bit = _mm512_sllv_epi32(_mm512_set1_epi32(1), _mm512_and_si512(index.0, _mm512_set1_epi32(31)));
            _mm512_test_epi32_mask(_mm512_castps_si512(word), bit)
        })
    }
    #[inline(always)]
    fn mask(self, bits: u32) -> Avx512Mask {
        Avx512Mask(bits as u16)
    }
}

/// Binary operators that are one intrinsic each.
macro_rules! operators {
    ($lanes:ident: $($trait:ident $op:ident $intrinsic:ident),+) => {$(
        impl $trait for $lanes {
            type Output = Self;
            #[inline(always)]
            fn $op(self, other: Self) -> Self {
                Self(avx512!($intrinsic(self.0, other.0)))
            }
        }
    )+};
}
operators!(Avx512F32: Add add _mm512_add_ps, Sub sub _mm512_sub_ps, Mul mul _mm512_mul_ps, Div div _mm512_div_ps);
operators!(Avx512I32: Add add _mm512_add_epi32, Sub sub _mm512_sub_epi32, Mul mul _mm512_mullo_epi32);
operators!(Avx512I32: BitAnd bitand _mm512_and_si512, BitOr bitor _mm512_or_si512, BitXor bitxor _mm512_xor_si512);

/// Comparisons of floats, by the predicate of the instruction.
macro_rules! comparisons {
    ($($method:ident $predicate:ident),+) => {$(
        #[inline(always)]
        fn $method(self, other: Self) -> Avx512Mask {
            Avx512Mask(avx512!(_mm512_cmp_ps_mask::<$predicate>(self.0, other.0)))
        }
    )+};
}

/// Folds the halves, the quarters, the eighths, then the last two lanes.
macro_rules! reductions {
    ($($method:ident $eight:ident $four:ident $one:ident),+) => {$(
        #[inline(always)]
        fn $method(self) -> f32 {
            avx512!({
                let eight = $eight(_mm512_castps512_ps256(self.0), _mm512_extractf32x8_ps::<1>(self.0));
                let four = $four(_mm256_castps256_ps128(eight), _mm256_extractf128_ps::<1>(eight));
                let two = $four(four, _mm_movehl_ps(four, four));
                _mm_cvtss_f32($one(two, _mm_movehdup_ps(two)))
            })
        }
    )+};
}

impl Avx512F32 {
    /// The same lanes.
    #[must_use]
    #[inline(always)]
    pub fn to_wide(self) -> wide::f32x16 {
        bytemuck::cast(self.0)
    }
}

impl Neg for Avx512F32 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(avx512!(_mm512_xor_ps(self.0, _mm512_set1_ps(-0.0))))
    }
}

impl F32Lanes for Avx512F32 {
    type Mask = Avx512Mask;
    type I32 = Avx512I32;

    #[inline(always)]
    fn mul_add(self, a: Self, b: Self) -> Self {
        Self(avx512!(_mm512_fmadd_ps(self.0, a.0, b.0)))
    }
    #[inline(always)]
    fn mul_sub(self, a: Self, b: Self) -> Self {
        Self(avx512!(_mm512_fmsub_ps(self.0, a.0, b.0)))
    }
    #[inline(always)]
    fn neg_mul_add(self, a: Self, b: Self) -> Self {
        Self(avx512!(_mm512_fnmadd_ps(self.0, a.0, b.0)))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(avx512!(_mm512_sqrt_ps(self.0)))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(avx512!(_mm512_andnot_ps(_mm512_set1_ps(-0.0), self.0)))
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(avx512!(_mm512_min_ps(self.0, other.0)))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(avx512!(_mm512_max_ps(self.0, other.0)))
    }
    comparisons!(lt _CMP_LT_OQ, le _CMP_LE_OQ, gt _CMP_GT_OQ, ge _CMP_GE_OQ, eq _CMP_EQ_OQ, ne _CMP_NEQ_UQ);
    #[inline(always)]
    fn select(self, mask: Avx512Mask, other: Self) -> Self {
        Self(avx512!(_mm512_mask_blend_ps(mask.0, other.0, self.0)))
    }
    #[inline(always)]
    fn to_bits(self) -> Avx512I32 {
        Avx512I32(avx512!(_mm512_castps_si512(self.0)))
    }
    #[inline(always)]
    fn to_i32(self) -> Avx512I32 {
        Avx512I32(avx512!(_mm512_cvttps_epi32(self.0)))
    }
    #[inline(always)]
    fn store(self, dst: &mut [f32], at: usize) {
        match window_mut::<f32, 16>(dst, at) {
            // SAFETY: AVX-512 by the value; sixteen floats may be written to an array of sixteen.
            Some(sixteen) => unsafe { _mm512_storeu_ps(sixteen.as_mut_ptr(), whole(self.0)) },
            None => self.store_masked(dst, at, Avx512Mask(!0)),
        }
    }
    #[inline(always)]
    fn store_masked(self, dst: &mut [f32], at: usize, mask: Avx512Mask) {
        match window_mut::<f32, 16>(dst, at) {
            // SAFETY: AVX-512 by the value; sixteen floats may be read from and written to an array of sixteen.
            Some(sixteen) => unsafe {
                let old = _mm512_loadu_ps(sixteen.as_ptr());
                _mm512_storeu_ps(sixteen.as_mut_ptr(), whole(_mm512_mask_blend_ps(mask.0, old, self.0)));
            },
            None => {
                let mask = mask.0 & in_range(dst.len(), at);
                // SAFETY: AVX-512 by the value; only lanes in the mask are written, and those lie within the slice.
                unsafe { _mm512_mask_storeu_ps(dst.as_mut_ptr().wrapping_add(at), mask, self.0) }
            }
        }
    }
    reductions!(
        reduce_min _mm256_min_ps _mm_min_ps _mm_min_ss,
        reduce_max _mm256_max_ps _mm_max_ps _mm_max_ss,
        reduce_add _mm256_add_ps _mm_add_ps _mm_add_ss
    );
}

impl I32Lanes for Avx512I32 {
    type Mask = Avx512Mask;
    type F32 = Avx512F32;

    #[inline(always)]
    fn shl(self, n: u32) -> Self {
        Self(avx512!(_mm512_sll_epi32(self.0, _mm_cvtsi32_si128(n as i32))))
    }
    #[inline(always)]
    fn shr(self, n: u32) -> Self {
        Self(avx512!(_mm512_srl_epi32(self.0, _mm_cvtsi32_si128(n as i32))))
    }
    #[inline(always)]
    fn eq(self, other: Self) -> Avx512Mask {
        Avx512Mask(avx512!(_mm512_cmpeq_epi32_mask(self.0, other.0)))
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Avx512Mask {
        Avx512Mask(avx512!(_mm512_cmplt_epi32_mask(self.0, other.0)))
    }
    #[inline(always)]
    fn lt_unsigned(self, other: Self) -> Avx512Mask {
        Avx512Mask(avx512!(_mm512_cmplt_epu32_mask(self.0, other.0)))
    }
    #[inline(always)]
    fn select(self, mask: Avx512Mask, other: Self) -> Self {
        Self(avx512!(_mm512_mask_blend_epi32(mask.0, other.0, self.0)))
    }
    #[inline(always)]
    fn to_f32(self) -> Avx512F32 {
        Avx512F32(avx512!(_mm512_cvtepi32_ps(self.0)))
    }
    #[inline(always)]
    fn from_bits_f32(self) -> Avx512F32 {
        Avx512F32(avx512!(_mm512_castsi512_ps(self.0)))
    }
    #[inline(always)]
    fn store(self, dst: &mut [u32], at: usize) {
        self.from_bits_f32().store(bytemuck::cast_slice_mut(dst), at);
    }
    #[inline(always)]
    fn store_masked(self, dst: &mut [u32], at: usize, mask: Avx512Mask) {
        self.from_bits_f32().store_masked(bytemuck::cast_slice_mut(dst), at, mask);
    }
}

/// Masks are plain integers here; the compiler moves them to mask registers as it needs.
macro_rules! mask_operators {
    ($($trait:ident $op:ident),+) => {$(
        impl $trait for Avx512Mask {
            type Output = Self;
            #[inline(always)]
            fn $op(self, other: Self) -> Self {
                Self(self.0.$op(other.0))
            }
        }
    )+};
}
mask_operators!(BitAnd bitand, BitOr bitor, BitXor bitxor);

impl Not for Avx512Mask {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self(!self.0)
    }
}

impl MaskLanes for Avx512Mask {
    #[inline(always)]
    fn and_not(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }
    #[inline(always)]
    fn any(self) -> bool {
        self.0 != 0
    }
    #[inline(always)]
    fn all(self) -> bool {
        self.0 == !0
    }
    #[inline(always)]
    fn bits(self) -> u32 {
        u32::from(self.0)
    }
}
