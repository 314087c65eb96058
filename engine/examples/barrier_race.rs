//! Mobula's barrier against the standard library's: time per crossing, both measured in turns in one run.
//!
//! `cargo run --release --example barrier_race -- [THREADS...]`

use std::sync::Barrier as Standard;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use mobula::pipeline::barrier::Barrier;

const ROUNDS: usize = 15;

/// Seconds per crossing of `threads` threads that do nothing else.
fn time(threads: usize, crossings: u64, cross: &(impl Fn(usize) + Sync)) -> f64 {
    let start = Instant::now();
    std::thread::scope(|scope| {
        for thread in 0..threads {
            scope.spawn(move || (0..crossings).for_each(|_| cross(thread)));
        }
    });
    start.elapsed().as_secs_f64() / crossings as f64
}

/// Medians of interleaved rounds: ours, the standard library's.
fn race(threads: usize) -> (f64, f64) {
    let crossings = (40_000 / (threads * threads).min(1000)).max(100) as u64;
    let (mut ours, mut standard) = (Vec::new(), Vec::new());
    for _ in 0..ROUNDS {
        let serial = AtomicU64::new(0);
        let barrier = Barrier::new(threads);
        ours.push(time(threads, crossings, &|thread| {
            let crossed = barrier.cross(thread, |_| {
                serial.fetch_add(1, Ordering::Relaxed);
            });
            crossed.expect("nobody aborts");
        }));
        assert_eq!(serial.into_inner(), crossings, "every crossing has one serial part");
        let barrier = Standard::new(threads);
        standard.push(time(threads, crossings, &|_| {
            barrier.wait();
        }));
    }
    let median = |times: &mut Vec<f64>| {
        times.sort_by(f64::total_cmp);
        times[times.len() / 2]
    };
    (median(&mut ours), median(&mut standard))
}

fn main() {
    let given: Vec<usize> = std::env::args().skip(1).map(|text| text.parse().expect("a thread count")).collect();
    let counts = if given.is_empty() { vec![1, 2, 3, 4, 8, 16, 64] } else { given };
    println!("threads   mobula us   std us   ratio");
    for threads in counts {
        let (ours, standard) = race(threads);
        println!("{threads:7} {:11.3} {:8.3} {:7.2}", ours * 1e6, standard * 1e6, ours / standard);
    }
}
