//! All interleavings of two and three threads, by loom.
//!
//! `bash tests/loom.sh`. Groups are of two threads here: three need both levels of the barrier.

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
fn cross_and_look(threads: usize, crossings: usize, cores: usize) {
    let barrier = Arc::new(Barrier::with_cores(threads, cores));
    let work: Arc<Vec<_>> = Arc::new((0..threads).map(|_| AtomicUsize::new(0)).collect());
    let sum = Arc::new(AtomicUsize::new(0));
    let body = move |index: usize| {
        for crossing in 1..=crossings {
            work[index].store(crossing, Ordering::Relaxed);
            let cross = barrier.cross(index, |_| {
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
    model(3, || cross_and_look(2, 3, 0));
}

#[test]
fn two_threads_that_spin_cross_twice() {
    model(3, || cross_and_look(2, 2, 2));
}

#[test]
fn three_threads_that_spin_cross_once() {
    model(2, || cross_and_look(3, 1, 3));
}

#[test]
fn three_threads_cross_twice() {
    model(2, || cross_and_look(3, 2, 0));
}

#[test]
fn an_abort_is_never_missed() {
    for cores in [0, 3] {
        model(2, move || abort_two_waiters(cores));
    }
}

fn abort_two_waiters(cores: usize) {
    let barrier = Arc::new(Barrier::with_cores(3, cores));
    let note = Arc::new(AtomicUsize::new(0));
    let waiter = |index, barrier: Arc<Barrier>, note: Arc<AtomicUsize>| {
        move || {
            assert_eq!(barrier.cross(index, |_| unreachable!("one thread never arrives")), Err(Aborted));
            note.load(Ordering::Relaxed)
        }
    };
    let one = thread::spawn(waiter(0, barrier.clone(), note.clone()));
    let two = thread::spawn(waiter(2, barrier.clone(), note.clone()));
    note.store(7, Ordering::Relaxed);
    barrier.abort();
    assert_eq!((one.join().unwrap(), two.join().unwrap()), (7, 7));
}

#[test]
fn an_abort_may_race_with_the_release() {
    model(3, || {
        let barrier = Arc::new(Barrier::with_cores(2, 0));
        let other = Arc::clone(&barrier);
        let aborter = Arc::clone(&barrier);
        let other = thread::spawn(move || other.cross(1, |_| ()));
        let aborter = thread::spawn(move || aborter.abort());
        let _ = barrier.cross(0, |_| ());
        let _ = other.join().unwrap();
        aborter.join().unwrap();
        assert_eq!(barrier.cross(0, |_| ()), Err(Aborted));
    });
}

/// In the group of the thread that is there already, and in a group of its own.
#[test]
fn a_newcomer_joins_behind_the_crossing() {
    for present in [1, 2] {
        model(2, move || a_newcomer_joins(present));
    }
}

fn a_newcomer_joins(present: usize) {
    let barrier = Arc::new(Barrier::with_cores(present, 0));
    let seen = Arc::new(AtomicUsize::new(0));
    let newcomer = Arc::new(std::sync::Mutex::new(None));
    let body = {
        let (barrier, newcomer) = (Arc::clone(&barrier), Arc::clone(&newcomer));
        move |index: usize| {
            let crossed = barrier.cross(index, |turn| {
                let pass = turn.pass(present);
                let (barrier, told) = (Arc::clone(&barrier), Arc::clone(&seen));
                *newcomer.lock().unwrap() = Some(thread::spawn(move || {
                    barrier.join(pass).unwrap();
                    assert_eq!(told.load(Ordering::Relaxed), 1);
                    barrier.cross(present, |_| ()).unwrap();
                }));
                turn.set_threads(present + 1);
                seen.store(1, Ordering::Relaxed);
            });
            crossed.unwrap();
            barrier.cross(index, |_| ()).unwrap();
        }
    };
    let other = (present == 2).then(|| {
        let body = body.clone();
        thread::spawn(move || body(1))
    });
    body(0);
    other.into_iter().for_each(|other| other.join().unwrap());
    newcomer.lock().unwrap().take().unwrap().join().unwrap();
}

/// Three threads become one: those who leave go past a gate that nobody will open again, not even a slow leaver that
/// was the last to arrive. A pass made at the next crossing stays good until its own is over.
#[test]
fn leavers_are_let_go() {
    model(2, || {
        let barrier = Arc::new(Barrier::with_cores(3, 0));
        let leave = |index: usize| {
            let barrier = Arc::clone(&barrier);
            move || barrier.cross(index, |turn| turn.set_threads(1)).unwrap()
        };
        let leavers = [thread::spawn(leave(1)), thread::spawn(leave(2))];
        leave(0)();
        let mut pass = None;
        barrier.cross(0, |turn| pass = Some(turn.pass(2))).unwrap();
        for leaver in leavers {
            leaver.join().unwrap();
        }
        assert_eq!(barrier.groups[1].gate.load(Ordering::Relaxed) & !SLEEPERS, pass.unwrap().epoch);
    });
}
