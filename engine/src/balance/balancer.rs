//! What a load balancer is, and even shares.

use std::fmt::Debug;
use std::ops::Range;

/// The most threads that a balancer serves, and so the most that a pipeline may have.
pub const MAX_THREADS: usize = 1024;

/// Hands out `0..items` to threads: every item exactly once, whichever threads ask, in whichever order, how often.
///
/// A balancer that gives threads shares of their own ([`Static`](super::Static), [`Cyclic`](super::Cyclic), the first ones of [`ByCost`](super::ByCost)) hands out
/// everything only if each thread asks until it gets nothing.
pub trait LoadBalancer: Debug + Send + Sync {
    /// Begins anew.
    ///
    /// # Panics
    /// When `threads` is not in `1..=`[`MAX_THREADS`].
    fn reset(&mut self, items: usize, threads: usize);

    /// Begins anew, and tells what each item is expected to cost, in any unit. Most balancers only count the items.
    ///
    /// # Panics
    /// As [`reset`](Self::reset) does.
    fn reset_with_costs(&mut self, costs: &[f32], threads: usize) {
        self.reset(costs.len(), threads);
    }

    /// Whether knowing costs makes it better for so many threads.
    fn wants_costs(&self, _threads: usize) -> bool {
        false
    }

    /// Another one of the same kind.
    fn another(&self) -> Box<dyn LoadBalancer>;

    /// The next assignment of a thread, never empty. None: there is nothing left for this thread.
    fn next(&self, thread: usize) -> Option<Range<usize>> {
        self.next_touching(thread, &mut |_| ())
    }

    /// As [`next`](Self::next); calls `touched` with the number of each cache line that it shares with other threads and
    /// goes to, for simulations.
    fn next_touching(&self, thread: usize, touched: &mut dyn FnMut(usize)) -> Option<Range<usize>>;
}

/// Share `index` of `count` even shares of `0..items`; they differ by one item at most.
pub fn even_share(items: usize, index: usize, count: usize) -> Range<usize> {
    let (each, extra) = (items / count, items % count);
    let start = index * each + index.min(extra);
    start..start + each + usize::from(index < extra)
}

/// # Panics
/// When `threads` is not in `1..=`[`MAX_THREADS`].
pub(super) fn check(threads: usize) {
    assert!((1..=MAX_THREADS).contains(&threads), "a load balancer serves 1 to {MAX_THREADS} threads, not {threads}");
}
