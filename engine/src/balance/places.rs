//! One counter for each thread, on a cache line of its own.

use std::sync::atomic::{AtomicUsize, Ordering};

use crossbeam_utils::CachePadded;

use super::balancer::check;

/// How far each thread has come.
#[derive(Debug, Default)]
pub(super) struct Places(Vec<CachePadded<AtomicUsize>>);

impl Places {
    pub(super) fn reset(&mut self, threads: usize) {
        check(threads);
        self.0.resize_with(threads, Default::default);
        self.0.iter_mut().for_each(|counter| *counter.get_mut() = 0);
    }

    pub(super) fn threads(&self) -> usize {
        self.0.len()
    }

    /// How often this thread has asked before. None for a thread that has no share.
    pub(super) fn advance(&self, thread: usize) -> Option<usize> {
        // Relaxed: between two barriers a counter belongs to one thread.
        Some(self.0.get(thread)?.fetch_add(1, Ordering::Relaxed))
    }
}
