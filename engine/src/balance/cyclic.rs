//! Cyclic shares: thread t of n gets the items t, t + n, t + 2n and so on.
//!
//! Source: the classic alternative to the work queue of Bigler, Stephens and Parker 2006, section 5.4. Threads never
//! meet, but a slow one is not helped.

use std::ops::Range;

use super::LoadBalancer;
use super::places::Places;

/// Deals the items out like cards.
#[derive(Debug, Default)]
pub struct Cyclic {
    places: Places,
}

impl LoadBalancer for Cyclic {
    fn reset(&self, items: usize, threads: usize) {
        self.places.reset(items, threads);
    }

    fn next(&self, thread: usize) -> Option<Range<usize>> {
        let (place, items, threads) = self.places.advance(thread)?;
        let item = place.checked_mul(threads)?.checked_add(thread)?;
        (item < items).then(|| item..item + 1)
    }
}
