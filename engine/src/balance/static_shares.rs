//! Static shares: each thread gets one even part, in one piece.
//!
//! Source: what the work queue of Bigler, Stephens and Parker 2006, section 5.4, is there to beat.

use std::ops::Range;

use super::balancer::{LoadBalancer, even_share};
use super::places::Places;

/// Cuts the items into one even share for each thread.
#[derive(Debug, Default)]
pub struct Static {
    items: usize,
    places: Places,
}

impl LoadBalancer for Static {
    fn reset(&mut self, items: usize, threads: usize) {
        self.items = items;
        self.places.reset(threads);
    }

    fn another(&self) -> Box<dyn LoadBalancer> {
        Box::new(Self::default())
    }

    fn next_touching(&self, thread: usize, _: &mut dyn FnMut(usize)) -> Option<Range<usize>> {
        let place = self.places.advance(thread)?;
        let share = even_share(self.items, thread, self.places.threads());
        (place == 0 && !share.is_empty()).then_some(share)
    }
}
