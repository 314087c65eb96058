//! The barrier: the one place where the render threads meet.
//!
//! Source: Bigler, Stephens and Parker 2006, section 5.2 ("synchronization occurs at a barrier at the end of the
//! pipeline"). Departure: the thread that arrives last does the serial work before it lets the others go, so a frame
//! needs one crossing and not two. Arrivals are combined in two levels, as in the software combining trees of Yew, Tzeng
//! and Lawrie 1987. The protocol is explained in `README.md` beside this file.

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

/// How long a waiter spins before it parks: somewhat more than parking and being woken takes, so that who waits for one
/// that is being woken meets it. Halved each time it was in vain, [`HALVINGS`] times, and restored when it was not: on a
/// machine that others keep busy, a spinning waiter only keeps the one it waits for from running.
const SPIN_TIME: Duration = Duration::from_micros(50);

/// How often the spin time may be halved.
const HALVINGS: usize = 5;

/// After so many times in vain it is tried in full again: threads that all park, since they wait for each other to wake up,
/// would never find out that they need not.
const IN_VAIN: usize = 32;

/// How often a spinning waiter looks at the gate before it looks at the clock. The model checker, which has no clock,
/// lets it look once.
const LOOKS: usize = if cfg!(loom) { 1 } else { 16 };

/// The barrier was aborted because a participant failed: leave.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the barrier was aborted")]
pub struct Aborted;

/// Threads that share one counter and one gate. Few enough that passing a cache line around among them is quick, many
/// enough that two levels serve every pipeline. The model checker has groups of two, so that three threads need both levels.
pub const GROUP: usize = if cfg!(loom) { 2 } else { 32 };

/// The most threads that a barrier is for.
const MOST: usize = if cfg!(loom) { 4 } else { crate::balance::MAX_THREADS };

/// A reusable barrier for a known number of threads, the last of which does serial work before the others may go on.
///
/// Threads are numbered from 0. Each [`GROUP`] of them meets at a counter of its own, and who arrives last there arrives
/// for the group. Waiters spin for a short time, then park. More threads than cores: they park at once.
#[derive(Debug)]
pub struct Barrier {
    groups: Box<[Group]>,
    /// Groups still to arrive at the present crossing. The last of each group writes it, so it has its own cache line.
    missing: CachePadded<AtomicUsize>,
    /// How many threads take part. Written only by the last arrival.
    threads: CachePadded<AtomicUsize>,
    /// With more threads than this, waiters park at once.
    cores: usize,
    /// How often spinning has been in vain. Beside the other rarely written things.
    impatience: AtomicUsize,
}

/// Where one group of threads meets.
#[derive(Debug)]
struct Group {
    /// Threads of the group still to arrive. All of them write it, so it has its own cache line.
    missing: CachePadded<AtomicUsize>,
    /// Epoch and flags. Waiters read it in a loop, so it has its own cache line.
    gate: CachePadded<AtomicUsize>,
    lock: Mutex<()>,
    bell: Condvar,
}

/// What the last arrival may do while the others wait.
#[derive(Debug)]
pub struct Turn<'a> {
    barrier: &'a Barrier,
    threads: usize,
}

/// A newcomer's pass: it joins when the crossing in which the pass was made is over.
#[derive(Debug)]
pub struct Pass {
    group: usize,
    epoch: usize,
}

impl Barrier {
    /// A barrier for `threads` participants (at least one).
    pub fn new(threads: usize) -> Self {
        Self::with_cores(threads, std::thread::available_parallelism().map_or(1, usize::from))
    }

    /// A barrier that believes in `cores` processors: with more threads than cores nobody spins. 0: never spin.
    pub fn with_cores(threads: usize, cores: usize) -> Self {
        let barrier = Self {
            groups: (0..MOST / GROUP).map(|_| Group::new()).collect(),
            missing: CachePadded::new(AtomicUsize::new(0)),
            threads: CachePadded::new(AtomicUsize::new(0)),
            cores,
            impatience: AtomicUsize::new(0),
        };
        barrier.expect(threads);
        barrier
    }

    /// Waits for all participants. The last to arrive runs `serial`, alone, and then all go on. `thread` is the caller's
    /// number, which no other participant has.
    ///
    /// Everything a thread did before `cross` is visible to `serial`; everything `serial` did is visible to every thread
    /// after `cross`. Returns true in the thread that ran `serial`. A panic in `serial` aborts the barrier and goes on
    /// unwinding.
    pub fn cross(&self, thread: usize, serial: impl FnOnce(&mut Turn<'_>)) -> Result<bool, Aborted> {
        let group = &self.groups[thread / GROUP];
        // Acquire: pairs with the release in `abort`, in case it is aborted. For the epoch relaxed would do: this thread has
        // already seen it (it left the last crossing by it), and it cannot move on before this thread arrives.
        let gate = group.gate.load(Ordering::Acquire);
        if gate & ABORTED != 0 {
            return Err(Aborted);
        }
        if self.arrive(group) {
            // Relaxed: this thread has already seen it, as it has the epoch.
            let before = self.threads.load(Ordering::Relaxed);
            let mut turn = Turn { barrier: self, threads: before };
            let panicking = AbortOnDrop(self);
            serial(&mut turn);
            std::mem::forget(panicking);
            let threads = turn.threads;
            self.expect(threads);
            // Groups that nobody is left in are opened too, for those who leave them, and before the others: the next
            // crossing, which may make passes for them, must wait until this one has opened all gates. Group 0, which
            // always has somebody, is the last.
            self.groups[..before.max(threads).div_ceil(GROUP)].iter().rev().for_each(Group::open);
            return if self.is_aborted() { Err(Aborted) } else { Ok(true) };
        }
        self.wait_for_release(group, gate & !(SLEEPERS | ABORTED)).map(|()| false)
    }

    /// Joins with a pass: returns when the crossing in which the pass was made is over.
    pub fn join(&self, pass: Pass) -> Result<(), Aborted> {
        self.wait_for_release(&self.groups[pass.group], pass.epoch)
    }

    /// Whether somebody aborted the barrier.
    pub fn is_aborted(&self) -> bool {
        // Relaxed: a hint; who must not miss it reads its own gate with acquire in `wait_for_release`.
        self.groups[0].gate.load(Ordering::Relaxed) & ABORTED != 0
    }

    /// Sends everybody away, now and for ever: each present and later [`cross`](Self::cross) returns [`Aborted`].
    pub fn abort(&self) {
        for group in &self.groups {
            // Release: what the aborting thread noted (the fault) is visible to those who leave; pairs with the acquire
            // loads in `wait_for_release`.
            group.gate.fetch_or(ABORTED, Ordering::Release);
            group.ring();
        }
    }

    /// Sets how many are to arrive. Relaxed, all: published to the others by the release of the gates.
    fn expect(&self, threads: usize) {
        assert!((1..=MOST).contains(&threads), "a barrier is for 1 to {MOST} threads, not {threads}");
        let groups = threads.div_ceil(GROUP);
        for (index, group) in self.groups[..groups].iter().enumerate() {
            group.missing.store((threads - index * GROUP).min(GROUP), Ordering::Relaxed);
        }
        self.missing.store(groups, Ordering::Relaxed);
        self.threads.store(threads, Ordering::Relaxed);
    }

    /// Whether the caller is the last of all.
    fn arrive(&self, group: &Group) -> bool {
        // Both counters alike. Release: pairs with the acquire of the last one's own fetch_sub, through the chain of
        // read-modify-writes on the counter, and through the last of each group on to the last of all: the work of all is
        // visible to `serial`. Acquire: the other half of that pair.
        group.missing.fetch_sub(1, Ordering::AcqRel) == 1 && self.missing.fetch_sub(1, Ordering::AcqRel) == 1
    }

    fn wait_for_release(&self, group: &Group, epoch: usize) -> Result<(), Aborted> {
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
        let mut gate = group.gate.load(Ordering::Acquire);
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
                    gate = group.gate.load(Ordering::Acquire);
                }
                if cfg!(loom) || start.elapsed() > SPIN_TIME / (1 << impatience.min(HALVINGS)) {
                    break;
                }
            }
            self.impatience.store((impatience + 1) % IN_VAIN, Ordering::Relaxed);
        }
        let mut guard = group.guard();
        loop {
            if let Some(verdict) = verdict(gate) {
                return verdict;
            }
            // Relaxed on success: the flag carries no data, and `open` takes it in a read-modify-write of the same word,
            // so it is never lost. Acquire on failure: the value may be the opened gate.
            match group.gate.compare_exchange(gate, gate | SLEEPERS, Ordering::Relaxed, Ordering::Acquire) {
                Ok(_) => {
                    guard = group.bell.wait(guard).unwrap_or_else(|poisoned| poisoned.into_inner());
                    gate = group.gate.load(Ordering::Acquire);
                }
                Err(now) => gate = now,
            }
        }
    }
}

impl Group {
    fn new() -> Self {
        Self {
            missing: CachePadded::new(AtomicUsize::new(0)),
            gate: CachePadded::new(AtomicUsize::new(0)),
            lock: Mutex::new(()),
            bell: Condvar::new(),
        }
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

    fn guard(&self) -> MutexGuard<'_, ()> {
        self.lock.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
    }
}

impl Turn<'_> {
    /// How many threads take part in the next crossing.
    pub fn threads(&self) -> usize {
        self.threads
    }

    /// Sets how many threads take part in the next crossing: those that leave must not arrive again, and those that come
    /// must first [`Barrier::join`]. A leaver may be slow to find out: tell it by something that is never taken back.
    pub fn set_threads(&mut self, threads: usize) {
        assert!((1..=MOST).contains(&threads), "a barrier is for 1 to {MOST} threads, not {threads}");
        self.threads = threads;
    }

    /// A pass for a newcomer of this number.
    pub fn pass(&self, thread: usize) -> Pass {
        let group = thread / GROUP;
        // Relaxed: whoever opened this gate last did so before it opened one that a thread of this crossing came by.
        let gate = self.barrier.groups[group].gate.load(Ordering::Relaxed);
        Pass { group, epoch: gate & !(SLEEPERS | ABORTED) }
    }
}

struct AbortOnDrop<'a>(&'a Barrier);

impl Drop for AbortOnDrop<'_> {
    fn drop(&mut self) {
        self.0.abort();
    }
}
