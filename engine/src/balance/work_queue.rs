//! The work queue: large assignments first, single items at the end.
//!
//! Source: Bigler, Stephens and Parker 2006, section 5.4 ("the larger assignments help reduce communication costs while
//! the smaller assignments help even out the work distribution at the end"); the sizes are those of factoring (Hummel,
//! Schonberg and Flynn 1992). The sizes follow from an assignment's number alone, so taking one is a single `fetch_add`:
//! no lock, no retry, no table.

use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

use crossbeam_utils::CachePadded;

use super::balancer::{LoadBalancer, check};

/// Hands out assignments of decreasing size, whoever asks first gets the next.
#[derive(Debug)]
pub struct WorkQueue {
    granularity: usize,
    /// Number of the next assignment. All threads write it, so it has its own cache line.
    next: CachePadded<AtomicUsize>,
    items: usize,
    threads: usize,
}

impl WorkQueue {
    /// The granularity of the default: in the simulation of `mobula scale` more even on many processors than a coarser
    /// one, and no worse than a finer one.
    pub const GRANULARITY: usize = 8;

    /// A queue that hands out `1 / granularity` of what is left in each round of one assignment per thread. 1: one round
    /// of equal shares; larger: smaller assignments from the start, more of them, and a more even end.
    pub fn new(granularity: usize) -> Self {
        Self { granularity: granularity.max(1), next: CachePadded::new(AtomicUsize::new(0)), items: 0, threads: 1 }
    }

    /// Assignment `number` of the queue.
    fn assignment(&self, number: usize) -> Option<Range<usize>> {
        let (items, threads) = (self.items, self.threads);
        let (mut round, mut start) = (number / threads, 0);
        loop {
            let left = items - start;
            let size = left / threads.saturating_mul(self.granularity);
            if size <= 1 {
                // Single items from here on: `round` whole rounds of them lie between, and this round's own.
                let start = start.saturating_add(round.saturating_mul(threads)).saturating_add(number % threads);
                return (start < items).then(|| start..start + 1);
            }
            if round == 0 {
                let start = start + number % threads * size;
                return Some(start..start + size);
            }
            start += size * threads;
            round -= 1;
        }
    }
}

impl Default for WorkQueue {
    fn default() -> Self {
        Self::new(Self::GRANULARITY)
    }
}

impl LoadBalancer for WorkQueue {
    fn reset(&mut self, items: usize, threads: usize) {
        check(threads);
        (self.items, self.threads) = (items, threads);
        *self.next.get_mut() = 0;
    }

    fn another(&self) -> Box<dyn LoadBalancer> {
        Box::new(Self::new(self.granularity))
    }

    fn next_touching(&self, _thread: usize, touched: &mut dyn FnMut(usize)) -> Option<Range<usize>> {
        touched(0);
        // Relaxed: that no two threads get one number is all that is needed; the items' data is ordered by the barrier.
        let number = self.next.fetch_add(1, Ordering::Relaxed);
        self.assignment(number)
    }
}
