//! One counter for each thread, on a cache line of its own.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};

use crossbeam_utils::CachePadded;

use super::{MAX_THREADS, check};

const BLOCK: usize = 32;

type Counter = CachePadded<AtomicUsize>;

/// How far each thread has come. Blocks of counters are made when a pipeline first has so many threads.
#[derive(Debug)]
pub(super) struct Places {
    blocks: [OnceLock<[Counter; BLOCK]>; MAX_THREADS / BLOCK],
    items: AtomicUsize,
    threads: AtomicUsize,
}

impl Places {
    pub(super) fn reset(&self, items: usize, threads: usize) {
        check(threads);
        // Relaxed, all here: the barrier orders a reset and the frames around it; between two barriers a counter belongs
        // to one thread.
        self.items.store(items, Ordering::Relaxed);
        self.threads.store(threads, Ordering::Relaxed);
        for block in &self.blocks[..threads.div_ceil(BLOCK)] {
            for counter in block.get_or_init(Default::default) {
                counter.store(0, Ordering::Relaxed);
            }
        }
    }

    /// How often this thread has asked before, and the numbers of items and threads. None for a thread that has no share.
    pub(super) fn advance(&self, thread: usize) -> Option<(usize, usize, usize)> {
        let threads = self.threads.load(Ordering::Relaxed);
        if thread >= threads {
            return None;
        }
        let counter = &self.blocks[thread / BLOCK].get()?[thread % BLOCK];
        let place = counter.fetch_add(1, Ordering::Relaxed);
        Some((place, self.items.load(Ordering::Relaxed), threads))
    }
}

impl Default for Places {
    fn default() -> Self {
        Self {
            blocks: [const { OnceLock::new() }; MAX_THREADS / BLOCK],
            items: AtomicUsize::new(0),
            threads: AtomicUsize::new(0),
        }
    }
}
