//! Cyclic shares: thread t of n gets the items t, t + n, t + 2n and so on.
//!
//! Source: the classic alternative to the work queue of Bigler, Stephens and Parker 2006, section 5.4. Threads never
//! meet, but a slow one is not helped.

use std::ops::Range;

use super::balancer::LoadBalancer;
use super::places::Places;

/// Deals the items out like cards.
#[derive(Debug, Default)]
pub struct Cyclic {
    items: usize,
    places: Places,
}

impl LoadBalancer for Cyclic {
    fn reset(&mut self, items: usize, threads: usize) {
        self.items = items;
        self.places.reset(threads);
    }

    fn another(&self) -> Box<dyn LoadBalancer> {
        Box::new(Self::default())
    }

    fn next_touching(&self, thread: usize, _: &mut dyn FnMut(usize)) -> Option<Range<usize>> {
        let item = self.places.advance(thread)?.checked_mul(self.places.threads())?.checked_add(thread)?;
        (item < self.items).then(|| item..item + 1)
    }
}
