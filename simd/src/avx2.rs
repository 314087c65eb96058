//! [`Avx2`]: eight fused lanes, on the vectors of `core::arch` (measured to be twice as fast here as `wide::f32x8`, which
//! chooses its instructions when the program is built).

use core::arch::x86_64::*;
use core::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Sub};

use crate::window::{window, window_mut};
use crate::{F32Lanes, I32Lanes, Level, MaskLanes, Task, Token};

/// The token of eight fused lanes: proof of AVX2, FMA, BMI1, BMI2 and POPCNT.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Avx2(());

/// Eight `f32`.
#[derive(Clone, Copy, Debug)]
pub struct Avx2F32(__m256);

/// Eight 32-bit integers.
#[derive(Clone, Copy, Debug)]
pub struct Avx2I32(__m256i);

/// Eight truth values; the bits of a lane are all zero or all one.
#[derive(Clone, Copy, Debug)]
pub struct Avx2Mask(__m256);

/// Executes intrinsics that touch no memory.
macro_rules! avx2 {
    ($intrinsics:expr) => {
        // SAFETY: this runs in a method of a token or of a lane value; lane values come only from tokens, and a token
        // only from `Avx2::detect`, which checked the features, or from a level that implies them.
        unsafe { $intrinsics }
    };
}

/// Its argument, about which the compiler forgets what it knew; no instruction.
///
/// Without it, the compiler turns a blend of new lanes with the old ones in memory, followed by a store, into a masked
/// store, from which the next load cannot be forwarded: the usual fate of a packet's hit distances. 64 distances that
/// are compared, blended and stored again and again took eight times as long that way on Zen 4, and twice as long with
/// the masked stores of AVX-512.
#[inline]
#[target_feature(enable = "avx")]
fn whole(mut x: __m256) -> __m256 {
    // SAFETY: an empty instruction that keeps its register.
    unsafe { core::arch::asm!("/* {0} */", inout(ymm_reg) x, options(pure, nomem, nostack, preserves_flags)) };
    x
}

cpufeatures::new!(detected, "avx2", "fma", "bmi1", "bmi2", "popcnt");

impl Avx2 {
    /// A token, if this machine (and its operating system) has the instructions.
    #[must_use]
    #[inline]
    pub fn detect() -> Option<Self> {
        detected::get().then_some(Self(()))
    }

    /// The same lanes.
    #[must_use]
    #[inline(always)]
    pub fn from_wide(self, x: wide::f32x8) -> Avx2F32 {
        Avx2F32(bytemuck::cast(x))
    }

    #[inline(always)]
    fn in_range(self, length: usize, at: usize) -> Avx2Mask {
        self.first(length.saturating_sub(at))
    }
}

impl Token for Avx2 {
    const LEVEL: Level = Level::Avx2;
    const LANES: usize = 8;
    const FUSED: bool = true;
    type F32 = Avx2F32;
    type I32 = Avx2I32;
    type Mask = Avx2Mask;
    type Narrow = Self;

    #[inline(always)]
    fn narrow(self) -> Self {
        self
    }

    #[inline(always)]
    fn run<K: Task>(self, task: K) -> K::Output {
        #[target_feature(enable = "avx2,fma,bmi1,bmi2,popcnt")]
        fn region<K: Task>(token: Avx2, task: K) -> K::Output {
            task.run(token)
        }
        // SAFETY: `Avx2::detect` checked these very features before it made this token.
        unsafe { region(self, task) }
    }

    #[inline(always)]
    fn splat(self, x: f32) -> Avx2F32 {
        Avx2F32(avx2!(_mm256_set1_ps(x)))
    }
    #[inline(always)]
    fn splat_i32(self, x: i32) -> Avx2I32 {
        Avx2I32(avx2!(_mm256_set1_epi32(x)))
    }
    #[inline(always)]
    fn iota(self) -> Avx2I32 {
        Avx2I32(avx2!(_mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7)))
    }
    #[inline(always)]
    fn load(self, src: &[f32], at: usize) -> Avx2F32 {
        match window::<f32, 8>(src, at) {
            // SAFETY: AVX by the token; eight floats may be read from an array of eight.
            Some(eight) => Avx2F32(unsafe { _mm256_loadu_ps(eight.as_ptr()) }),
            None => self.load_masked(src, at, self.in_range(src.len(), at)),
        }
    }
    #[inline(always)]
    fn load_masked(self, src: &[f32], at: usize, mask: Avx2Mask) -> Avx2F32 {
        match window::<f32, 8>(src, at) {
            Some(eight) => {
                // SAFETY: AVX by the token; eight floats may be read from an array of eight.
                let eight = unsafe { _mm256_loadu_ps(eight.as_ptr()) };
                Avx2F32(avx2!(_mm256_and_ps(eight, mask.0)))
            }
            None => {
                let mask = mask & self.in_range(src.len(), at);
                // SAFETY: AVX by the token; only lanes in the mask are read, and those lie within the slice.
                Avx2F32(unsafe { _mm256_maskload_ps(src.as_ptr().wrapping_add(at), _mm256_castps_si256(mask.0)) })
            }
        }
    }
    #[inline(always)]
    fn repeat(self, four: &[f32; 4], _at: usize) -> Avx2F32 {
        // SAFETY: AVX by the token; four floats may be read from an array of four.
        Avx2F32(unsafe { _mm256_broadcast_ps(&_mm_loadu_ps(four.as_ptr())) })
    }
    #[inline(always)]
    fn load_u32(self, src: &[u32], at: usize) -> Avx2I32 {
        match window::<u32, 8>(src, at) {
            // SAFETY: AVX by the token; eight integers may be read from an array of eight.
            Some(eight) => Avx2I32(unsafe { _mm256_loadu_si256(eight.as_ptr().cast()) }),
            None => {
                let mask = self.in_range(src.len(), at);
                let start = src.as_ptr().wrapping_add(at).cast();
                // SAFETY: AVX2 by the token; only lanes in the mask are read, and those lie within the slice.
                Avx2I32(unsafe { _mm256_maskload_epi32(start, _mm256_castps_si256(mask.0)) })
            }
        }
    }
    #[inline(always)]
    fn gather(self, src: &[f32], index: Avx2I32, mask: Avx2Mask) -> Avx2F32 {
        // The instruction reads indices as signed: it is shown no more of a slice than it can address.
        let length = src.len().min(i32::MAX as usize);
        let mask = mask & index.lt_unsigned(self.splat_i32(length as i32));
        let zero = self.splat(0.0);
        // SAFETY: AVX2 by the token; only lanes in the mask are read, whose indices are less than the slice's length
        // and than i32::MAX.
        Avx2F32(unsafe { _mm256_mask_i32gather_ps::<4>(zero.0, src.as_ptr(), index.0, mask.0) })
    }
    #[inline(always)]
    fn lookup(self, table: &[f32; 16], index: Avx2I32) -> Avx2F32 {
        let (low, high) = (self.load(table, 0).0, self.load(table, 8).0);
        // Bit 3 of the index chooses the half: it becomes the sign, by which lanes are blended.
        Avx2F32(avx2!({
            let (low, high) = (_mm256_permutevar8x32_ps(low, index.0), _mm256_permutevar8x32_ps(high, index.0));
            _mm256_blendv_ps(low, high, _mm256_castsi256_ps(_mm256_slli_epi32::<28>(index.0)))
        }))
    }
    #[inline(always)]
    fn gather_rows<const R: usize>(self, rows: &[[f32; 8]; R], index: Avx2I32) -> [Avx2F32; 8] {
        const { assert!(R.is_power_of_two()) };
        let mut at = [0; 8];
        index.store(&mut at, 0);
        let mut out = [self.splat(0.0); 8];
        for half in 0..2 {
            let mut quads = [self.splat(0.0).0; 4];
            for i in 0..4 {
                let (a, b) = (&rows[at[i] as usize % R], &rows[at[i + 4] as usize % R]);
                // SAFETY: AVX by the token; four floats are read, from 0 or 4 on, of rows of eight.
                quads[i] = unsafe {
                    let low = _mm256_castps128_ps256(_mm_loadu_ps(a.as_ptr().add(4 * half)));
                    _mm256_insertf128_ps::<1>(low, _mm_loadu_ps(b.as_ptr().add(4 * half)))
                };
            }
            // Four by four, in both halves.
            let columns = avx2!({
                let (a, b) = (_mm256_unpacklo_ps(quads[0], quads[1]), _mm256_unpackhi_ps(quads[0], quads[1]));
                let (c, d) = (_mm256_unpacklo_ps(quads[2], quads[3]), _mm256_unpackhi_ps(quads[2], quads[3]));
                [
                    _mm256_shuffle_ps::<0x44>(a, c),
                    _mm256_shuffle_ps::<0xee>(a, c),
                    _mm256_shuffle_ps::<0x44>(b, d),
                    _mm256_shuffle_ps::<0xee>(b, d),
                ]
            });
            for i in 0..4 {
                out[4 * half + i] = Avx2F32(columns[i]);
            }
        }
        out
    }
    #[inline(always)]
    fn is_member(self, set: &[u32; 4], index: Avx2I32) -> Avx2Mask {
        // SAFETY: AVX2 by the token; four words are read from an array of four.
        Avx2Mask(unsafe {
            let words = _mm256_castsi256_ps(_mm256_broadcastsi128_si256(_mm_loadu_si128(set.as_ptr().cast())));
            let word = _mm256_castps_si256(_mm256_permutevar_ps(words, _mm256_srli_epi32::<5>(index.0)));
            // The bit where the sign is, and from there everywhere.
            let up = _mm256_andnot_si256(index.0, _mm256_set1_epi32(31));
            _mm256_castsi256_ps(_mm256_srai_epi32::<31>(_mm256_sllv_epi32(word, up)))
        })
    }
    #[inline(always)]
    fn mask(self, bits: u32) -> Avx2Mask {
        let lane = avx2!(_mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128));
        let bits = self.splat_i32(bits as i32).0;
        Avx2Mask(avx2!(_mm256_castsi256_ps(_mm256_cmpeq_epi32(_mm256_and_si256(bits, lane), lane))))
    }
    #[inline(always)]
    fn first(self, n: usize) -> Avx2Mask {
        self.iota().lt(self.splat_i32(n.min(8) as i32))
    }
}

/// Binary operators that are one intrinsic each.
macro_rules! operators {
    ($lanes:ident: $($trait:ident $op:ident $intrinsic:ident),+) => {$(
        impl $trait for $lanes {
            type Output = Self;
            #[inline(always)]
            fn $op(self, other: Self) -> Self {
                Self(avx2!($intrinsic(self.0, other.0)))
            }
        }
    )+};
}
operators!(Avx2F32: Add add _mm256_add_ps, Sub sub _mm256_sub_ps, Mul mul _mm256_mul_ps, Div div _mm256_div_ps);
operators!(Avx2I32: Add add _mm256_add_epi32, Sub sub _mm256_sub_epi32, Mul mul _mm256_mullo_epi32);
operators!(Avx2I32: BitAnd bitand _mm256_and_si256, BitOr bitor _mm256_or_si256, BitXor bitxor _mm256_xor_si256);
operators!(Avx2Mask: BitAnd bitand _mm256_and_ps, BitOr bitor _mm256_or_ps, BitXor bitxor _mm256_xor_ps);

/// Comparisons of floats, by the predicate of the instruction.
macro_rules! comparisons {
    ($($method:ident $predicate:ident),+) => {$(
        #[inline(always)]
        fn $method(self, other: Self) -> Avx2Mask {
            Avx2Mask(avx2!(_mm256_cmp_ps::<$predicate>(self.0, other.0)))
        }
    )+};
}

/// Folds the halves, then the quarters, then the last two lanes.
macro_rules! reductions {
    ($($method:ident $vector:ident $last:ident),+) => {$(
        #[inline(always)]
        fn $method(self) -> f32 {
            avx2!({
                let four = $vector(_mm256_castps256_ps128(self.0), _mm256_extractf128_ps::<1>(self.0));
                let two = $vector(four, _mm_movehl_ps(four, four));
                _mm_cvtss_f32($last(two, _mm_movehdup_ps(two)))
            })
        }
    )+};
}

impl Avx2F32 {
    /// The same lanes.
    #[must_use]
    #[inline(always)]
    pub fn to_wide(self) -> wide::f32x8 {
        bytemuck::cast(self.0)
    }
}

impl Neg for Avx2F32 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(avx2!(_mm256_xor_ps(self.0, _mm256_set1_ps(-0.0))))
    }
}

impl F32Lanes for Avx2F32 {
    type Mask = Avx2Mask;
    type I32 = Avx2I32;

    #[inline(always)]
    fn mul_add(self, a: Self, b: Self) -> Self {
        Self(avx2!(_mm256_fmadd_ps(self.0, a.0, b.0)))
    }
    #[inline(always)]
    fn mul_sub(self, a: Self, b: Self) -> Self {
        Self(avx2!(_mm256_fmsub_ps(self.0, a.0, b.0)))
    }
    #[inline(always)]
    fn neg_mul_add(self, a: Self, b: Self) -> Self {
        Self(avx2!(_mm256_fnmadd_ps(self.0, a.0, b.0)))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(avx2!(_mm256_sqrt_ps(self.0)))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(avx2!(_mm256_andnot_ps(_mm256_set1_ps(-0.0), self.0)))
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(avx2!(_mm256_min_ps(self.0, other.0)))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(avx2!(_mm256_max_ps(self.0, other.0)))
    }
    comparisons!(lt _CMP_LT_OQ, le _CMP_LE_OQ, gt _CMP_GT_OQ, ge _CMP_GE_OQ, eq _CMP_EQ_OQ, ne _CMP_NEQ_UQ);
    #[inline(always)]
    fn select(self, mask: Avx2Mask, other: Self) -> Self {
        Self(avx2!(_mm256_blendv_ps(other.0, self.0, mask.0)))
    }
    #[inline(always)]
    fn to_bits(self) -> Avx2I32 {
        Avx2I32(avx2!(_mm256_castps_si256(self.0)))
    }
    #[inline(always)]
    fn to_i32(self) -> Avx2I32 {
        Avx2I32(avx2!(_mm256_cvttps_epi32(self.0)))
    }
    #[inline(always)]
    fn store(self, dst: &mut [f32], at: usize) {
        match window_mut::<f32, 8>(dst, at) {
            // SAFETY: AVX by the value; eight floats may be written to an array of eight.
            Some(eight) => unsafe { _mm256_storeu_ps(eight.as_mut_ptr(), whole(self.0)) },
            None => self.store_masked(dst, at, Avx2Mask(avx2!(_mm256_castsi256_ps(_mm256_set1_epi32(-1))))),
        }
    }
    #[inline(always)]
    fn store_masked(self, dst: &mut [f32], at: usize, mask: Avx2Mask) {
        match window_mut::<f32, 8>(dst, at) {
            // SAFETY: AVX by the value; eight floats may be read from and written to an array of eight.
            Some(eight) => unsafe {
                let old = _mm256_loadu_ps(eight.as_ptr());
                _mm256_storeu_ps(eight.as_mut_ptr(), whole(_mm256_blendv_ps(old, self.0, mask.0)));
            },
            None => {
                let mask = mask & Avx2(()).in_range(dst.len(), at);
                // SAFETY: AVX by the value; only lanes in the mask are written, and those lie within the slice.
                unsafe {
                    let start = dst.as_mut_ptr().wrapping_add(at);
                    _mm256_maskstore_ps(start, _mm256_castps_si256(mask.0), self.0);
                }
            }
        }
    }
    reductions!(reduce_min _mm_min_ps _mm_min_ss, reduce_max _mm_max_ps _mm_max_ss, reduce_add _mm_add_ps _mm_add_ss);
}

impl I32Lanes for Avx2I32 {
    type Mask = Avx2Mask;
    type F32 = Avx2F32;

    #[inline(always)]
    fn shl(self, n: u32) -> Self {
        Self(avx2!(_mm256_sll_epi32(self.0, _mm_cvtsi32_si128(n as i32))))
    }
    #[inline(always)]
    fn shr(self, n: u32) -> Self {
        Self(avx2!(_mm256_srl_epi32(self.0, _mm_cvtsi32_si128(n as i32))))
    }
    #[inline(always)]
    fn eq(self, other: Self) -> Avx2Mask {
        Avx2Mask(avx2!(_mm256_castsi256_ps(_mm256_cmpeq_epi32(self.0, other.0))))
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Avx2Mask {
        Avx2Mask(avx2!(_mm256_castsi256_ps(_mm256_cmpgt_epi32(other.0, self.0))))
    }
    #[inline(always)]
    fn lt_unsigned(self, other: Self) -> Avx2Mask {
        // There is no unsigned comparison: moving both by 2^31 turns it into the signed one.
        let sign = Self(avx2!(_mm256_set1_epi32(i32::MIN)));
        (self ^ sign).lt(other ^ sign)
    }
    #[inline(always)]
    fn select(self, mask: Avx2Mask, other: Self) -> Self {
        Self(avx2!(_mm256_blendv_epi8(other.0, self.0, _mm256_castps_si256(mask.0))))
    }
    #[inline(always)]
    fn to_f32(self) -> Avx2F32 {
        Avx2F32(avx2!(_mm256_cvtepi32_ps(self.0)))
    }
    #[inline(always)]
    fn from_bits_f32(self) -> Avx2F32 {
        Avx2F32(avx2!(_mm256_castsi256_ps(self.0)))
    }
    #[inline(always)]
    fn store(self, dst: &mut [u32], at: usize) {
        self.from_bits_f32().store(bytemuck::cast_slice_mut(dst), at);
    }
    #[inline(always)]
    fn store_masked(self, dst: &mut [u32], at: usize, mask: Avx2Mask) {
        self.from_bits_f32().store_masked(bytemuck::cast_slice_mut(dst), at, mask);
    }
}

impl Not for Avx2Mask {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self(avx2!(_mm256_xor_ps(self.0, _mm256_castsi256_ps(_mm256_set1_epi32(-1)))))
    }
}

impl MaskLanes for Avx2Mask {
    #[inline(always)]
    fn and_not(self, other: Self) -> Self {
        Self(avx2!(_mm256_andnot_ps(other.0, self.0)))
    }
    #[inline(always)]
    fn any(self) -> bool {
        self.bits() != 0
    }
    #[inline(always)]
    fn all(self) -> bool {
        self.bits() == 0xff
    }
    #[inline(always)]
    fn bits(self) -> u32 {
        avx2!(_mm256_movemask_ps(self.0)) as u32
    }
}
