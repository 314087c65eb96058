//! What the pipeline itself costs: an empty frame, a transaction, a component's scope.
//!
//! `cargo run --release --example pipeline_costs`

use std::error::Error;
use std::hint::black_box;
use std::time::{Duration, Instant};

use mobula::balance::BalancerKind;
use mobula::image::{FrameBuffer, Size};
use mobula::pipeline::fault::scope;
use mobula::pipeline::{Balance, Config, DisplayStage, Frame, NullDisplay, Pipeline, Report, stage};
use mobula::traverse::{Fragment, RenderStage, TileSize, TraverserKind};

const SENDERS: u64 = 4;
const PER_SECOND: u64 = 100_000;

fn empty_frames(threads: usize, traverser: &str) -> Result<Report, Box<dyn Error>> {
    let mut pipeline = Pipeline::new((), Config::with_threads(threads))?;
    pipeline.add_channel("main", Size::new(1024, 768)?);
    let traverser = traverser.parse::<TraverserKind>()?.build(TileSize::default(), BalancerKind::default());
    pipeline.add_stage(RenderStage::new(traverser, |_: &Frame<'_, ()>, _: &Fragment, _: &FrameBuffer| ()));
    pipeline.add_stage(DisplayStage::new().with(0, NullDisplay));
    Ok(pipeline.run(20_000)?)
}

/// Frames of about 2 ms on two threads, while four senders together send 100 000 transactions a second.
fn storm() -> Result<Report, Box<dyn Error>> {
    let mut pipeline = Pipeline::new(0_u64, Config::with_threads(2))?;
    pipeline.add_stage(stage("spin", Balance::Balanced, |_: &Frame<'_, u64>| {
        let start = Instant::now();
        while start.elapsed() < Duration::from_millis(2) {
            std::hint::spin_loop();
        }
    }));
    let handle = pipeline.handle();
    let report = std::thread::scope(|scope| {
        let run = scope.spawn(|| pipeline.run_until_stopped());
        let senders: Vec<_> = (0..SENDERS)
            .map(|_| {
                let handle = handle.clone();
                scope.spawn(move || {
                    // A second's worth in bursts of a millisecond.
                    for _ in 0..1000 {
                        for _ in 0..PER_SECOND / SENDERS / 1000 {
                            drop(handle.send("add", |sum| *sum += 1));
                        }
                        std::thread::sleep(Duration::from_micros(900));
                    }
                })
            })
            .collect();
        senders.into_iter().for_each(|sender| sender.join().expect("senders do not panic"));
        let _ = handle.stop().wait();
        run.join().expect("runs do not panic")
    })?;
    assert_eq!(pipeline.into_state(), PER_SECOND);
    Ok(report)
}

/// Seconds at the barrier for a transaction that is carried out, the least of some runs.
fn transaction() -> Result<f64, Box<dyn Error>> {
    let mut least = f64::INFINITY;
    for _ in 0..20 {
        let mut pipeline = Pipeline::new(0_u64, Config::with_threads(1))?;
        let handle = pipeline.handle();
        let sender = std::thread::spawn(move || {
            (0..PER_SECOND / 10).for_each(|_| drop(handle.send("add", |sum| *sum += 1)));
        });
        sender.join().expect("senders do not panic");
        let report = pipeline.run(1)?;
        assert_eq!(pipeline.into_state(), PER_SECOND / 10);
        least = least.min(report.serial_seconds / report.transactions as f64);
    }
    Ok(least)
}

fn main() -> Result<(), Box<dyn Error>> {
    for traverser in ["null", "tiled"] {
        for threads in [1, 2] {
            let times = empty_frames(threads, traverser)?.frame_times;
            println!("empty frame, {traverser:5}, {threads} threads: median {:.2} us", times.median * 1e6);
        }
    }
    println!("a transaction: {:.0} ns at the barrier", transaction()? * 1e9);
    let report = storm()?;
    println!(
        "{} transactions in {:.2} s: {:.2} % of the time at the barrier (which others may have taken too)",
        report.transactions,
        report.seconds,
        report.serial_seconds / report.seconds * 100.0
    );
    let start = Instant::now();
    let sum = (0..100_000_000_u64).fold(0, |sum, item| scope("component", || black_box(sum + item)));
    assert_eq!(sum, 4_999_999_950_000_000);
    println!("a scope: {:.2} ns", start.elapsed().as_secs_f64() * 10.0);
    Ok(())
}
