//! How many render threads there may be, and which core each is pinned to.
//!
//! Pinning is best effort: a pipeline pins its threads only while it has no more of them than the process has cores, and
//! never to a core that another pipeline of the process uses. What was not pinned is in the notes of the
//! [`Report`](super::Report).

use std::sync::{Mutex, OnceLock};

use core_affinity::CoreId;

/// The most render threads a pipeline may have.
pub const MAX_THREADS: usize = crate::balance::MAX_THREADS;

/// A thread count outside `1..=`[`MAX_THREADS`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a pipeline has 1 to {MAX_THREADS} threads, not {0}")]
pub struct ThreadCountError(pub usize);

/// Checks a thread count.
pub fn check_thread_count(threads: usize) -> Result<(), ThreadCountError> {
    if (1..=MAX_THREADS).contains(&threads) { Ok(()) } else { Err(ThreadCountError(threads)) }
}

/// The cores that this process may run on, read once before any thread was pinned (a pinned thread sees only its own).
pub fn cores() -> &'static [CoreId] {
    static CORES: OnceLock<Vec<CoreId>> = OnceLock::new();
    CORES.get_or_init(|| core_affinity::get_core_ids().unwrap_or_default())
}

/// Whether a pipeline with so many threads may pin them.
pub(crate) fn may_pin(threads: usize) -> bool {
    threads <= cores().len()
}

/// A core that the current thread is pinned to; given back when dropped.
#[derive(Debug)]
pub(crate) struct Pinned(usize);

/// Cores in use by pinned threads of this process, by their place in [`cores`].
static TAKEN: Mutex<Vec<usize>> = Mutex::new(Vec::new());

/// Pins the current thread to a core that no other pinned thread has. None if there is no such core, or if the system
/// refuses.
pub(crate) fn pin_current() -> Option<Pinned> {
    let mut taken = TAKEN.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    // Processes with few threads each should not all begin with the first core.
    let first = std::process::id() as usize;
    let free = (0..cores().len()).map(|place| (first + place) % cores().len()).find(|place| !taken.contains(place))?;
    core_affinity::set_for_current(cores()[free]).then(|| {
        taken.push(free);
        Pinned(free)
    })
}

impl Drop for Pinned {
    fn drop(&mut self) {
        let mut taken = TAKEN.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        taken.retain(|&place| place != self.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thread_counts_are_checked() {
        assert_eq!(check_thread_count(0), Err(ThreadCountError(0)));
        assert_eq!(check_thread_count(1), Ok(()));
        assert_eq!(check_thread_count(1024), Ok(()));
        assert!(check_thread_count(1025).unwrap_err().to_string().contains("1 to 1024 threads, not 1025"));
    }

    #[test]
    fn two_threads_never_share_a_pinned_core() {
        // Both are pinned before either lets go.
        let both = std::sync::Barrier::new(2);
        std::thread::scope(|scope| {
            let pin = || {
                let pinned = pin_current();
                both.wait();
                pinned.as_ref().map(|pinned| pinned.0)
            };
            let (one, two) = (scope.spawn(pin), scope.spawn(pin));
            let (one, two) = (one.join().unwrap(), two.join().unwrap());
            assert!(one.is_none() || one != two);
        });
    }
}
