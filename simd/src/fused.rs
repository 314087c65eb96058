//! [`Fused`]: one lane whose `mul_add` rounds once. The twin of [`Avx2`] and `Avx512`.

use core::arch::x86_64::{_mm_cvtss_f32, _mm_fmadd_ss, _mm_set_ss, _mm_sqrt_ss};

use crate::one_lane::{OneLane, one_lane_token, sealed::Sealed};
use crate::{Avx2, Level, Task, Token};

/// The token of one fused lane. It stands on [`Avx2`], without which there is no telling that the machine can fuse.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fused(Avx2);

impl Fused {
    /// A token, if this machine has the instructions.
    #[must_use]
    #[inline]
    pub fn detect() -> Option<Self> {
        Avx2::detect().map(Avx2::fused)
    }
}

impl Avx2 {
    /// The one-lane twin, which needs no more than this.
    #[must_use]
    #[inline(always)]
    pub const fn fused(self) -> Fused {
        Fused(self)
    }
}

impl Token for Fused {
    /// What it needs; it has one lane all the same.
    const LEVEL: Level = Level::Avx2;
    const FUSED: bool = true;

    #[inline(always)]
    fn run<K: Task>(self, task: K) -> K::Output {
        #[target_feature(enable = "avx2,fma,bmi1,bmi2,popcnt")]
        fn region<K: Task>(token: Fused, task: K) -> K::Output {
            task.run(token)
        }
        // SAFETY: this token holds an `Avx2`, for which detection checked these very features.
        unsafe { region(self, task) }
    }
    one_lane_token!();
}

impl Sealed for Fused {}

impl OneLane for Fused {
    #[inline(always)]
    fn mul_add(self, a: f32, b: f32, c: f32) -> f32 {
        // SAFETY: this token holds an `Avx2`, for which detection checked FMA.
        unsafe { _mm_cvtss_f32(_mm_fmadd_ss(_mm_set_ss(a), _mm_set_ss(b), _mm_set_ss(c))) }
    }
    #[inline(always)]
    fn sqrt(self, x: f32) -> f32 {
        // SAFETY: SSE is part of every x86_64 processor.
        unsafe { _mm_cvtss_f32(_mm_sqrt_ss(_mm_set_ss(x))) }
    }
}
