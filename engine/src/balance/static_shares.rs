//! Static shares: each thread gets one even part, in one piece.
//!
//! Source: what the work queue of Bigler, Stephens and Parker 2006, section 5.4, is there to beat.

use std::ops::Range;

use super::places::Places;
use super::{LoadBalancer, even_share};

/// Cuts the items into one even share for each thread.
#[derive(Debug, Default)]
pub struct Static {
    places: Places,
}

impl LoadBalancer for Static {
    fn reset(&self, items: usize, threads: usize) {
        self.places.reset(items, threads);
    }

    fn next(&self, thread: usize) -> Option<Range<usize>> {
        let (place, items, threads) = self.places.advance(thread)?;
        let share = even_share(items, thread, threads);
        (place == 0 && !share.is_empty()).then_some(share)
    }
}
