//! The barrier: the one place where the render threads meet.
//!
//! Source: Bigler, Stephens and Parker 2006, section 5.2 ("synchronization occurs at a barrier at the end of the
//! pipeline"). Departure: the thread that arrives last does the serial work before it lets the others go, so a frame
//! needs one crossing and not two. The protocol is explained in `README.md` beside this file.

use std::time::{Duration, Instant};

use crossbeam_utils::CachePadded;

use super::sync::atomic::{AtomicUsize, Ordering};
use super::sync::{Condvar, Mutex, MutexGuard, hint};

#[cfg(all(test, loom))]
mod models;
#[cfg(all(test, not(loom)))]
mod tests;

/// Somebody is parked, or about to be: the thread that opens the gate must ring.
const SLEEPERS: usize = 1;
/// The barrier was aborted: nobody waits here any more.
const ABORTED: usize = 2;
/// One crossing. The epoch is what lies above the two flags; it wraps, and only equality is ever asked.
const EPOCH: usize = 4;

/// How long a waiter spins before it parks: about what parking and being woken costs, so that waiting is never much
/// worse than the better of the two. Halved each time it was in vain, down to [`LEAST_PATIENCE`], and restored when it
/// was not: on a machine that others keep busy, a spinning waiter only keeps the one it waits for from running.
const SPIN_TIME: Duration = Duration::from_micros(20);

/// How often the spin time may be halved.
const LEAST_PATIENCE: usize = 5;

/// How often a spinning waiter looks at the gate before it looks at the clock. The model checker, which has no clock,
/// lets it look once.
const LOOKS: usize = if cfg!(loom) { 1 } else { 16 };

/// The barrier was aborted because a participant failed: leave.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the barrier was aborted")]
pub struct Aborted;

/// A reusable barrier for a known number of threads, the last of which does serial work before the others may go on.
///
/// Waiters spin for a short time, then park. More threads than cores: they park at once.
#[derive(Debug)]
pub struct Barrier {
    /// Threads still to arrive at the present crossing. Everybody writes it, so it has its own cache line.
    missing: CachePadded<AtomicUsize>,
    /// Epoch and flags. Waiters read it in a loop, so it has its own cache line.
    gate: CachePadded<AtomicUsize>,
    /// How many threads take part. Written only by the last arrival.
    threads: CachePadded<AtomicUsize>,
    /// With more threads than this, waiters park at once.
    cores: usize,
    /// How often the spin time has been halved. Beside the other rarely written things.
    impatience: AtomicUsize,
    lock: Mutex<()>,
    bell: Condvar,
}

/// What the last arrival may do while the others wait.
#[derive(Debug)]
pub struct Turn {
    threads: usize,
    epoch: usize,
}

/// A newcomer's pass: it joins when the crossing in which the pass was made is over.
#[derive(Debug)]
pub struct Pass {
    epoch: usize,
}

impl Barrier {
    /// A barrier for `threads` participants (at least one).
    pub fn new(threads: usize) -> Self {
        Self::with_cores(threads, std::thread::available_parallelism().map_or(1, usize::from))
    }

    /// A barrier that believes in `cores` processors: with more threads than cores nobody spins. 0: never spin.
    pub fn with_cores(threads: usize, cores: usize) -> Self {
        assert!(threads > 0, "a barrier needs at least one thread");
        Self {
            missing: CachePadded::new(AtomicUsize::new(threads)),
            gate: CachePadded::new(AtomicUsize::new(0)),
            threads: CachePadded::new(AtomicUsize::new(threads)),
            cores,
            impatience: AtomicUsize::new(0),
            lock: Mutex::new(()),
            bell: Condvar::new(),
        }
    }

    /// Waits for all participants. The last to arrive runs `serial`, alone, and then all go on.
    ///
    /// Everything a thread did before `cross` is visible to `serial`; everything `serial` did is visible to every thread
    /// after `cross`. Returns true in the thread that ran `serial`. A panic in `serial` aborts the barrier and goes on
    /// unwinding.
    pub fn cross(&self, serial: impl FnOnce(&mut Turn)) -> Result<bool, Aborted> {
        // Acquire: pairs with the release in `abort`, in case it is aborted. For the epoch relaxed would do: this thread has
        // already seen it (it left the last crossing by it), and it cannot move on before this thread arrives.
        let gate = self.gate.load(Ordering::Acquire);
        if gate & ABORTED != 0 {
            return Err(Aborted);
        }
        let epoch = gate & !(SLEEPERS | ABORTED);
        // Release: pairs with the acquire of the last arrival's own fetch_sub, through the chain of read-modify-writes
        // on `missing`: the work of all is visible to `serial`. Acquire: the other half of that pair.
        if self.missing.fetch_sub(1, Ordering::AcqRel) == 1 {
            let mut turn = Turn { threads: self.threads.load(Ordering::Relaxed), epoch };
            let panicking = AbortOnDrop(self);
            serial(&mut turn);
            std::mem::forget(panicking);
            let threads = turn.threads;
            // Relaxed, both: published to the others by the release of the gate below.
            self.threads.store(threads, Ordering::Relaxed);
            self.missing.store(threads, Ordering::Relaxed);
            self.open();
            return if self.is_aborted() { Err(Aborted) } else { Ok(true) };
        }
        self.wait_for_release(epoch).map(|()| false)
    }

    /// Joins with a pass: returns when the crossing in which the pass was made is over.
    pub fn join(&self, pass: Pass) -> Result<(), Aborted> {
        self.wait_for_release(pass.epoch)
    }

    /// Whether somebody aborted the barrier.
    pub fn is_aborted(&self) -> bool {
        // Relaxed: a hint; who must not miss it reads the gate with acquire in `wait_for_release`.
        self.gate.load(Ordering::Relaxed) & ABORTED != 0
    }

    /// Sends everybody away, now and for ever: each present and later [`cross`](Self::cross) returns [`Aborted`].
    pub fn abort(&self) {
        // Release: what the aborting thread noted (the fault) is visible to those who leave; pairs with the acquire
        // loads in `wait_for_release`.
        self.gate.fetch_or(ABORTED, Ordering::Release);
        self.ring();
    }

    /// Moves the epoch on and wakes the sleepers.
    fn open(&self) {
        // Release: publishes the serial work; pairs with the acquire loads in `wait_for_release`. A compare-and-swap
        // loop, since others set flags at the same time: ABORTED stays, SLEEPERS is taken.
        let next = |gate: usize| Some(gate.wrapping_add(EPOCH) & !SLEEPERS);
        let before = self.gate.fetch_update(Ordering::Release, Ordering::Relaxed, next).unwrap_or_else(|gate| gate);
        if before & SLEEPERS != 0 {
            self.ring();
        }
    }

    fn ring(&self) {
        // A sleeper sets its flag and goes to sleep under the lock; taking the lock once means that whoever set the
        // flag we saw is now asleep (and hears the bell) or has left.
        drop(self.guard());
        self.bell.notify_all();
    }

    fn wait_for_release(&self, epoch: usize) -> Result<(), Aborted> {
        let verdict = |gate: usize| {
            if gate & ABORTED != 0 {
                Some(Err(Aborted))
            } else if gate & !SLEEPERS != epoch {
                Some(Ok(()))
            } else {
                None
            }
        };
        // Acquire, here and below: pairs with the release in `open` and `abort`.
        let mut gate = self.gate.load(Ordering::Acquire);
        if self.threads.load(Ordering::Relaxed) <= self.cores {
            // Relaxed, all of `impatience`: it is a guess.
            let (start, impatience) = (Instant::now(), self.impatience.load(Ordering::Relaxed));
            loop {
                for _ in 0..LOOKS {
                    if let Some(verdict) = verdict(gate) {
                        if impatience > 0 {
                            self.impatience.store(0, Ordering::Relaxed);
                        }
                        return verdict;
                    }
                    hint::spin_loop();
                    gate = self.gate.load(Ordering::Acquire);
                }
                if cfg!(loom) || start.elapsed() > SPIN_TIME / (1 << impatience) {
                    break;
                }
            }
            if impatience < LEAST_PATIENCE {
                self.impatience.store(impatience + 1, Ordering::Relaxed);
            }
        }
        let mut guard = self.guard();
        loop {
            if let Some(verdict) = verdict(gate) {
                return verdict;
            }
            // Relaxed on success: the flag carries no data, and `open` takes it in a read-modify-write of the same word,
            // so it is never lost. Acquire on failure: the value may be the opened gate.
            match self.gate.compare_exchange(gate, gate | SLEEPERS, Ordering::Relaxed, Ordering::Acquire) {
                Ok(_) => {
                    guard = self.bell.wait(guard).unwrap_or_else(|poisoned| poisoned.into_inner());
                    gate = self.gate.load(Ordering::Acquire);
                }
                Err(now) => gate = now,
            }
        }
    }

    fn guard(&self) -> MutexGuard<'_, ()> {
        self.lock.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
    }
}

impl Turn {
    /// How many threads take part in the next crossing.
    pub fn threads(&self) -> usize {
        self.threads
    }

    /// Sets how many threads take part in the next crossing: those that leave must not arrive again, and those that come
    /// must first [`Barrier::join`]. A leaver may be slow to find out: tell it by something that is never taken back.
    pub fn set_threads(&mut self, threads: usize) {
        assert!(threads > 0, "a barrier needs at least one thread");
        self.threads = threads;
    }

    /// A pass for one newcomer.
    pub fn pass(&self) -> Pass {
        Pass { epoch: self.epoch }
    }
}

struct AbortOnDrop<'a>(&'a Barrier);

impl Drop for AbortOnDrop<'_> {
    fn drop(&mut self) {
        self.0.abort();
    }
}
