//! How far work that takes long has come: counted by who does it, in whatever unit suits, and shown by who likes to.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// A count of what is done and of what there is to do. Clones count together.
#[derive(Clone, Debug, Default)]
pub struct Progress(Arc<Counts>);

// Relaxed throughout: nothing else is read by what these say.
#[derive(Debug, Default)]
struct Counts {
    done: AtomicU64,
    expected: AtomicU64,
}

impl Progress {
    /// There is so much more to do.
    pub fn expect(&self, units: u64) {
        self.0.expected.fetch_add(units, Ordering::Relaxed);
    }

    /// So much more is done.
    pub fn advance(&self, units: u64) {
        self.0.done.fetch_add(units, Ordering::Relaxed);
    }

    /// The part of the work that is done, from 0 to 1; `None` if nobody knows how much there is to do.
    pub fn share(&self) -> Option<f64> {
        let [done, expected] = [&self.0.done, &self.0.expected].map(|count| count.load(Ordering::Relaxed));
        (expected > 0).then(|| done.min(expected) as f64 / expected as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_counted_together() {
        let progress = Progress::default();
        assert_eq!(progress.share(), None);
        progress.expect(6);
        progress.clone().expect(2);
        progress.clone().advance(2);
        assert_eq!(progress.share(), Some(0.25));
        progress.advance(100);
        assert_eq!(progress.share(), Some(1.0));
    }
}
