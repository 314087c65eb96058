//! The clocks that kernels are measured with: a counter of constant rate, and the core's own clock, which drifts.

/// The processor's time stamp counter (x86_64); elsewhere nanoseconds with `std`, and 0 without. Its rate is constant and
/// is not that of the core.
#[must_use]
#[inline(always)]
pub fn ticks() -> u64 {
    #[cfg(target_arch = "x86_64")]
    {
        // SAFETY: every x86_64 processor has the counter; reading it has no effect.
        unsafe { core::arch::x86_64::_rdtsc() }
    }
    #[cfg(all(not(target_arch = "x86_64"), feature = "std"))]
    {
        use std::sync::LazyLock;
        use std::time::Instant;
        static START: LazyLock<Instant> = LazyLock::new(Instant::now);
        START.elapsed().as_nanos() as u64
    }
    #[cfg(all(not(target_arch = "x86_64"), not(feature = "std")))]
    0
}

/// `n` additions (rounded up to a multiple of 50), each of which waits for the one before: `n` cycles of the core's clock.
/// Timed beside a kernel it says how long a cycle is now.
#[inline(never)]
pub fn add_chain(n: u64) {
    let mut x = 0u64;
    for _ in 0..n.div_ceil(50) {
        #[cfg(target_arch = "x86_64")]
        // SAFETY: arithmetic on a register.
        unsafe {
            core::arch::asm!(
                ".rept 50", "add {x}, {k}", ".endr",
                x = inout(reg) x, k = in(reg) 1u64, options(pure, nomem, nostack)
            );
        }
        #[cfg(not(target_arch = "x86_64"))]
        for _ in 0..50 {
            x = core::hint::black_box(x + 1);
        }
    }
    core::hint::black_box(x);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_longer_chain_takes_longer() {
        let time = |n| {
            let least = (0..20).map(|_| {
                let start = ticks();
                add_chain(n);
                ticks() - start
            });
            least.min().unwrap_or(0)
        };
        assert!(time(100_000) > 5 * time(10_000));
    }
}
