//! How much memory steps of time may take.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// How much memory steps of time may take, in bytes. Clones count together.
#[derive(Clone, Debug)]
pub struct Memory {
    limit: u64,
    taken: Arc<AtomicU64>,
}

impl Default for Memory {
    /// Without a limit.
    fn default() -> Self {
        Self::new(u64::MAX)
    }
}

impl Memory {
    /// So many bytes, of which none is taken.
    pub fn new(limit: u64) -> Self {
        Self { limit, taken: Arc::default() }
    }

    /// How many bytes there are, taken or not.
    pub fn limit(&self) -> u64 {
        self.limit
    }

    /// Takes some, also if there are not as many.
    pub fn take(&self, bytes: u64) {
        // Relaxed: nothing else is read by what this says.
        self.taken.fetch_add(bytes, Ordering::Relaxed);
    }

    /// Is as much taken as there is?
    pub fn is_full(&self) -> bool {
        self.taken.load(Ordering::Relaxed) >= self.limit
    }
}
