//! Stress: all meet, whoever comes, goes or fails.

use std::sync::atomic::{AtomicBool, AtomicU64};
use std::thread;

use super::*;

/// All threads count crossings; the serial part checks that all have arrived and that it is alone.
fn cross_often(threads: usize, crossings: u64, barrier: &Barrier) {
    let (arrived, serial) = (AtomicU64::new(0), AtomicU64::new(0));
    let inside = AtomicBool::new(false);
    thread::scope(|scope| {
        for thread in 0..threads {
            let (arrived, serial, inside) = (&arrived, &serial, &inside);
            scope.spawn(move || {
                for crossing in 1..=crossings {
                    arrived.fetch_add(1, Ordering::Relaxed);
                    let cross = barrier.cross(thread, |_| {
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
    for (threads, crossings) in [(1, 10_000), (2, 20_000), (3, 3000), (8, 1000), (33, 300), (64, 200), (200, 20)] {
        cross_often(threads, crossings, &Barrier::new(threads));
    }
}

#[test]
fn all_meet_whether_they_spin_or_park() {
    for threads in [2, 5, 35] {
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
            let cross = barrier.cross(index, |turn| {
                let step = step.fetch_add(1, Ordering::Relaxed) + 1;
                let Some(&threads) = plan.get(step) else { return barrier.abort() };
                let mut members = members.lock().unwrap();
                members.truncate(threads);
                for index in members.len()..threads {
                    let member = (index, step * 100 + index);
                    members.push(member.1);
                    let pass = Some(turn.pass(index));
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
        let barrier = Barrier::with_cores(70, cores);
        thread::scope(|scope| {
            let barrier = &barrier;
            let waiters = [0, 31, 32, 69].map(|index| scope.spawn(move || barrier.cross(index, |_| ())));
            thread::sleep(Duration::from_millis(5));
            barrier.abort();
            assert!(waiters.into_iter().all(|waiter| waiter.join().unwrap() == Err(Aborted)));
        });
        assert_eq!(barrier.cross(69, |_| ()), Err(Aborted));
    }
}

#[test]
fn a_panic_in_the_serial_part_sends_all_away() {
    crate::pipeline::fault::install_quiet_hook();
    let barrier = Barrier::new(3);
    thread::scope(|scope| {
        let cross = |index| crate::pipeline::fault::catch("serial", || barrier.cross(index, |_| panic!("oops")));
        let threads: Vec<_> = (0..3).map(|index| scope.spawn(move || cross(index))).collect();
        let results: Vec<_> = threads.into_iter().map(|thread| thread.join().unwrap()).collect();
        assert_eq!(results.iter().filter(|result| result.is_err()).count(), 1);
        assert_eq!(results.iter().filter(|result| **result == Ok(Err(Aborted))).count(), 2);
    });
}
