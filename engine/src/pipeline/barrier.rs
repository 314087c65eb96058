//! The barrier: the one place where the render threads meet.
//!
//! Source: Bigler, Stephens and Parker 2006, section 5.2 ("synchronization occurs at a barrier at the end of the
//! pipeline"). Departure: the thread that arrives last does the serial work before it lets the others go, so a frame
//! needs one crossing and not two. The protocol is explained in `README.md` beside this file.

use std::time::{Duration, Instant};

use crossbeam_utils::CachePadded;

use super::sync::atomic::{AtomicUsize, Ordering};
use super::sync::{Condvar, Mutex, MutexGuard};

/// Somebody is parked, or about to be: the thread that opens the gate must ring.
const SLEEPERS: usize = 1;
/// The barrier was aborted: nobody waits here any more.
const ABORTED: usize = 2;
/// One crossing. The epoch is what lies above the two flags; it wraps, and only equality is ever asked.
const EPOCH: usize = 4;

/// How long a waiter spins before it parks: about what parking and being woken costs, so that waiting is never much
/// worse than the better of the two.
const SPIN_TIME: Duration = Duration::from_micros(20);

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
    /// From this many threads on waiters park at once.
    cores: usize,
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
        // Relaxed: this thread has already seen this epoch (it left the last crossing by it), and the epoch cannot move
        // on before this thread arrives.
        let gate = self.gate.load(Ordering::Relaxed);
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
            let start = Instant::now();
            loop {
                for _ in 0..16 {
                    if let Some(verdict) = verdict(gate) {
                        return verdict;
                    }
                    std::hint::spin_loop();
                    gate = self.gate.load(Ordering::Acquire);
                }
                if start.elapsed() > SPIN_TIME {
                    break;
                }
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

#[cfg(all(test, not(loom)))]
mod tests {
    use std::sync::atomic::{AtomicBool, AtomicU64};
    use std::thread;

    use super::*;

    /// All threads count crossings; the serial part checks that all have arrived and that it is alone.
    fn cross_often(threads: usize, crossings: u64, barrier: &Barrier) {
        let (arrived, serial) = (AtomicU64::new(0), AtomicU64::new(0));
        let inside = AtomicBool::new(false);
        thread::scope(|scope| {
            for _ in 0..threads {
                scope.spawn(|| {
                    for crossing in 1..=crossings {
                        arrived.fetch_add(1, Ordering::Relaxed);
                        let cross = barrier.cross(|_| {
                            assert!(!inside.swap(true, Ordering::Relaxed));
                            assert_eq!(arrived.load(Ordering::Relaxed), crossing * threads as u64);
                            serial.fetch_add(1, Ordering::Relaxed);
                            inside.store(false, Ordering::Relaxed);
                        });
                        cross.unwrap();
                        assert_eq!(serial.load(Ordering::Relaxed), crossing);
                    }
                });
            }
        });
    }

    #[test]
    fn all_meet_at_every_crossing() {
        for (threads, crossings) in [(1, 10_000), (2, 20_000), (3, 3000), (8, 1000), (64, 200)] {
            cross_often(threads, crossings, &Barrier::new(threads));
        }
    }

    #[test]
    fn all_meet_whether_they_spin_or_park() {
        for threads in [2, 5] {
            cross_often(threads, 2000, &Barrier::with_cores(threads, 0));
            cross_often(threads, 200, &Barrier::with_cores(threads, usize::MAX));
        }
    }

    /// A minute at 1 to 64 threads: run with `cargo test --release -- --ignored`.
    #[test]
    #[ignore = "takes a minute"]
    fn all_meet_for_a_minute() {
        let start = Instant::now();
        while start.elapsed() < Duration::from_secs(60) {
            for threads in 1..=64 {
                cross_often(threads, 500, &Barrier::new(threads));
            }
        }
    }

    /// Each member has a number of its own; who is no longer on the list leaves. (The list and not the count: a slow
    /// leaver may look only when the count has grown again.)
    #[test]
    fn threads_come_and_go_at_the_barrier() {
        let plan = [1_usize, 5, 64, 3, 1, 2, 2, 40, 1];
        let barrier = Barrier::new(1);
        let (crossed, members, step) = (AtomicU64::new(0), Mutex::new(vec![0]), AtomicUsize::new(0));
        fn work<'scope>(
            (index, number): (usize, usize),
            pass: Option<Pass>,
            scope: &'scope thread::Scope<'scope, '_>,
            shared: (&'scope Barrier, &'scope AtomicU64, &'scope Mutex<Vec<usize>>, &'scope AtomicUsize),
            plan: &'scope [usize],
        ) {
            let (barrier, crossed, members, step) = shared;
            if let Some(pass) = pass {
                barrier.join(pass).unwrap();
            }
            while members.lock().unwrap().get(index) == Some(&number) {
                crossed.fetch_add(1, Ordering::Relaxed);
                let cross = barrier.cross(|turn| {
                    let step = step.fetch_add(1, Ordering::Relaxed) + 1;
                    let Some(&threads) = plan.get(step) else { return barrier.abort() };
                    let mut members = members.lock().unwrap();
                    members.truncate(threads);
                    for index in members.len()..threads {
                        let member = (index, step * 100 + index);
                        members.push(member.1);
                        let pass = Some(turn.pass());
                        scope.spawn(move || work(member, pass, scope, shared, plan));
                    }
                    turn.set_threads(threads);
                });
                if cross.is_err() {
                    return;
                }
            }
        }
        thread::scope(|scope| work((0, 0), None, scope, (&barrier, &crossed, &members, &step), &plan));
        assert_eq!(crossed.into_inner(), plan.iter().sum::<usize>() as u64);
    }

    #[test]
    fn an_abort_wakes_sleepers_and_spinners() {
        for cores in [0, usize::MAX] {
            let barrier = Barrier::with_cores(4, cores);
            thread::scope(|scope| {
                let waiters: Vec<_> = (0..3).map(|_| scope.spawn(|| barrier.cross(|_| ()))).collect();
                thread::sleep(Duration::from_millis(5));
                barrier.abort();
                assert!(waiters.into_iter().all(|waiter| waiter.join().unwrap() == Err(Aborted)));
            });
            assert_eq!(barrier.cross(|_| ()), Err(Aborted));
        }
    }

    #[test]
    fn a_panic_in_the_serial_part_sends_all_away() {
        super::super::fault::install_quiet_hook();
        let barrier = Barrier::new(3);
        thread::scope(|scope| {
            let cross = || super::super::fault::catch("serial", || barrier.cross(|_| panic!("oops")));
            let threads: Vec<_> = (0..3).map(|_| scope.spawn(cross)).collect();
            let results: Vec<_> = threads.into_iter().map(|thread| thread.join().unwrap()).collect();
            assert_eq!(results.iter().filter(|result| result.is_err()).count(), 1);
            assert_eq!(results.iter().filter(|result| **result == Ok(Err(Aborted))).count(), 2);
        });
    }
}

/// `RUSTFLAGS="--cfg loom" cargo test --release -p mobula --lib barrier`
#[cfg(all(test, loom))]
mod models {
    use std::sync::Arc;

    use loom::thread;

    use super::*;

    fn model(preemptions: usize, body: impl Fn() + Sync + Send + 'static) {
        let mut builder = loom::model::Builder::new();
        builder.preemption_bound = Some(preemptions);
        builder.check(body);
    }

    /// Relaxed accesses see each other only through the barrier's own ordering: before it to the serial part, from there
    /// to all behind it.
    fn cross_and_look(threads: usize, crossings: usize) {
        let barrier = Arc::new(Barrier::with_cores(threads, 0));
        let work: Arc<Vec<_>> = Arc::new((0..threads).map(|_| AtomicUsize::new(0)).collect());
        let sum = Arc::new(AtomicUsize::new(0));
        let body = move |index: usize| {
            for crossing in 1..=crossings {
                work[index].store(crossing, Ordering::Relaxed);
                let cross = barrier.cross(|_| {
                    let total = work.iter().map(|one| one.load(Ordering::Relaxed)).sum();
                    assert_eq!(total, crossing * work.len());
                    sum.store(total, Ordering::Relaxed);
                });
                cross.unwrap();
                assert_eq!(sum.load(Ordering::Relaxed), crossing * work.len());
            }
        };
        let body = Arc::new(body);
        let others: Vec<_> = (1..threads)
            .map(|index| {
                let body = Arc::clone(&body);
                thread::spawn(move || body(index))
            })
            .collect();
        body(0);
        others.into_iter().for_each(|thread| thread.join().unwrap());
    }

    #[test]
    fn two_threads_cross_three_times() {
        model(3, || cross_and_look(2, 3));
    }

    #[test]
    fn three_threads_cross_twice() {
        model(2, || cross_and_look(3, 2));
    }

    #[test]
    fn an_abort_is_never_missed() {
        model(3, || {
            let barrier = Arc::new(Barrier::with_cores(3, 0));
            let note = Arc::new(AtomicUsize::new(0));
            let waiter = |barrier: Arc<Barrier>, note: Arc<AtomicUsize>| {
                move || {
                    assert_eq!(barrier.cross(|_| unreachable!("one thread never arrives")), Err(Aborted));
                    note.load(Ordering::Relaxed)
                }
            };
            let one = thread::spawn(waiter(barrier.clone(), note.clone()));
            let two = thread::spawn(waiter(barrier.clone(), note.clone()));
            note.store(7, Ordering::Relaxed);
            barrier.abort();
            one.join().unwrap();
            two.join().unwrap();
        });
    }

    #[test]
    fn an_abort_may_race_with_the_release() {
        model(3, || {
            let barrier = Arc::new(Barrier::with_cores(2, 0));
            let other = Arc::clone(&barrier);
            let aborter = Arc::clone(&barrier);
            let other = thread::spawn(move || other.cross(|_| ()));
            let aborter = thread::spawn(move || aborter.abort());
            let _ = barrier.cross(|_| ());
            let _ = other.join().unwrap();
            aborter.join().unwrap();
            assert_eq!(barrier.cross(|_| ()), Err(Aborted));
        });
    }

    #[test]
    fn a_newcomer_joins_behind_the_crossing() {
        model(3, || {
            let barrier = Arc::new(Barrier::with_cores(1, 0));
            let seen = Arc::new(AtomicUsize::new(0));
            let mut newcomer = None;
            let crossed = barrier.cross(|turn| {
                let pass = turn.pass();
                let (barrier, told) = (Arc::clone(&barrier), Arc::clone(&seen));
                newcomer = Some(thread::spawn(move || {
                    barrier.join(pass).unwrap();
                    assert_eq!(told.load(Ordering::Relaxed), 1);
                    barrier.cross(|_| ()).unwrap();
                }));
                turn.set_threads(2);
                seen.store(1, Ordering::Relaxed);
            });
            assert_eq!(crossed, Ok(true));
            barrier.cross(|_| ()).unwrap();
            newcomer.unwrap().join().unwrap();
        });
    }
}
