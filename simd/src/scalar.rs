//! [`Scalar`]: one lane, unfused, on every processor. The twin of [`Sse2`](crate::Sse2).

use crate::one_lane::{OneLane, one_lane_token, sealed::Sealed};
use crate::{Level, Task, Token};

/// The token of one unfused lane. Every machine has it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Scalar(());

impl Scalar {
    /// Always there.
    #[must_use]
    #[inline(always)]
    #[expect(clippy::new_without_default, reason = "tokens are asked for by name, never defaulted")]
    pub const fn new() -> Self {
        Self(())
    }
}

impl Token for Scalar {
    const LEVEL: Level = Level::Scalar;
    const FUSED: bool = false;

    #[inline(always)]
    fn run<K: Task>(self, task: K) -> K::Output {
        /// Kept out of line, as at the other levels, so that they compare like with like.
        #[inline(never)]
        fn region<K: Task>(token: Scalar, task: K) -> K::Output {
            task.run(token)
        }
        region(self, task)
    }
    one_lane_token!();
}

impl Sealed for Scalar {}

impl OneLane for Scalar {
    #[inline(always)]
    fn mul_add(self, a: f32, b: f32, c: f32) -> f32 {
        a * b + c
    }
    #[inline(always)]
    fn sqrt(self, x: f32) -> f32 {
        sqrt(x)
    }
}

#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn sqrt(x: f32) -> f32 {
    use core::arch::x86_64::{_mm_cvtss_f32, _mm_set_ss, _mm_sqrt_ss};
    // SAFETY: SSE is part of every x86_64 processor, and so of this target.
    unsafe { _mm_cvtss_f32(_mm_sqrt_ss(_mm_set_ss(x))) }
}

#[cfg(not(target_arch = "x86_64"))]
#[inline(always)]
pub(crate) fn sqrt(x: f32) -> f32 {
    libm::sqrtf(x)
}
