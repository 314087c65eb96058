//! Threads to build with.

use std::sync::atomic::{AtomicUsize, Ordering};

use mobula_core::bvh::Join;

/// Does two things at once while there are spare threads, else one after the other.
#[derive(Debug)]
pub(super) struct Threads {
    spare: AtomicUsize,
}

impl Threads {
    /// As many threads as the system gives this program.
    pub(super) fn available() -> Self {
        let threads = std::thread::available_parallelism().map_or(1, |n| n.get());
        Self { spare: AtomicUsize::new(threads - 1) }
    }
}

impl Join for Threads {
    fn join<A: Send, B: Send>(&self, a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
        // Relaxed: the count is all that is shared; the scope orders everything else.
        let take = |spare: usize| spare.checked_sub(1);
        if self.spare.fetch_update(Ordering::Relaxed, Ordering::Relaxed, take).is_err() {
            return (a(), b());
        }
        std::thread::scope(|scope| {
            let b = scope.spawn(|| {
                let result = b();
                // This thread ends: another may start.
                self.spare.fetch_add(1, Ordering::Relaxed);
                result
            });
            let a = a();
            match b.join() {
                Ok(b) => (a, b),
                Err(panic) => std::panic::resume_unwind(panic),
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_are_done_with_and_without_spare_threads() {
        for spare in 0..3 {
            let threads = Threads { spare: AtomicUsize::new(spare) };
            let sum = |low: u64| move || (low..low + 10).sum::<u64>();
            let ((a, b), c) = threads.join(|| threads.join(sum(0), sum(10)), sum(20));
            assert_eq!(a + b + c, (0..30).sum::<u64>());
            assert_eq!(threads.spare.load(Ordering::Relaxed), spare);
        }
    }
}
