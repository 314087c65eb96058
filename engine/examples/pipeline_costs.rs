//! What the pipeline itself costs: an empty frame, a transaction, a storm of them, a slow display, a component's scope.
//!
//! `cargo run --release --example pipeline_costs`

use std::error::Error;
use std::hint::black_box;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use mobula::balance::BalancerKind;
use mobula::image::{FrameBuffer, Size};
use mobula::pipeline::fault::scope;
use mobula::pipeline::{
    Balance, Config, DisplayStage, Frame, NullDisplay, Picture, Pipeline, Report, Shown, display, stage,
};
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

/// Work that is the same at each time: about so many nanoseconds.
fn work(nanoseconds: u64) {
    black_box((0..nanoseconds).fold(1_u64, |x, step| black_box(x.wrapping_mul(0x9e37_79b9).wrapping_add(step))));
}

/// Frames of some 2 ms of work on two threads, for half a second, with or without four senders that together send 100 000
/// transactions a second. Frames per second.
fn frames_in_a_storm(storm: bool) -> Result<f64, Box<dyn Error>> {
    const BURSTS: u64 = 500;
    let mut pipeline = Pipeline::new(0_u64, Config::with_threads(2))?;
    pipeline.add_stage(stage("work", Balance::Balanced, |_: &Frame<'_, u64>| work(1_500_000)));
    let handle = pipeline.handle();
    let report = std::thread::scope(|scope| {
        let run = scope.spawn(|| pipeline.run_until_stopped());
        let senders: Vec<_> = (0..SENDERS)
            .map(|_| {
                let handle = handle.clone();
                scope.spawn(move || {
                    let start = Instant::now();
                    for burst in 1..=BURSTS {
                        for _ in 0..if storm { PER_SECOND / SENDERS / 1000 } else { 0 } {
                            drop(handle.send("add", |sum| *sum += 1));
                        }
                        std::thread::sleep(
                            (start + Duration::from_millis(burst)).saturating_duration_since(Instant::now()),
                        );
                    }
                })
            })
            .collect();
        senders.into_iter().for_each(|sender| sender.join().expect("senders do not panic"));
        let _ = handle.stop().wait();
        run.join().expect("runs do not panic")
    })?;
    assert_eq!(pipeline.into_state(), if storm { PER_SECOND * BURSTS / 1000 } else { 0 });
    Ok(report.frames_per_second())
}

/// Frames of some 40 ms of work, dealt out in tiles, with a display that takes (and sleeps) so long: median frame time, and
/// how many frames behind the one that is being rendered the shown one is at most.
fn slow_display(threads: usize, nap: Duration) -> Result<(f64, u64), Box<dyn Error>> {
    let mut pipeline = Pipeline::new((), Config::with_threads(threads))?;
    pipeline.add_channel("main", Size::new(320, 320)?);
    let newest = Arc::new(AtomicU64::new(0));
    let (rendering, behind) = (Arc::clone(&newest), Arc::new(AtomicU64::new(0)));
    let traverser = TraverserKind::Tiled.build(TileSize::default(), BalancerKind::default());
    pipeline.add_stage(RenderStage::new(traverser, move |frame: &Frame<'_, ()>, _: &Fragment, _: &FrameBuffer| {
        rendering.fetch_max(frame.number, Ordering::Relaxed);
        work(75_000);
    }));
    let late = Arc::clone(&behind);
    pipeline.add_stage(DisplayStage::new().with(
        0,
        display("slow", move |picture: &Picture<'_>| {
            late.fetch_max(newest.load(Ordering::Relaxed).saturating_sub(picture.frame), Ordering::Relaxed);
            std::thread::sleep(nap);
            late.fetch_max(newest.load(Ordering::Relaxed).saturating_sub(picture.frame), Ordering::Relaxed);
            Ok(Shown::Continue)
        }),
    ));
    let median = pipeline.run(20)?.frame_times.median;
    Ok((median, behind.load(Ordering::Relaxed)))
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
    // In turns, so that what else the machine does strikes both alike.
    let mut ratios = Vec::new();
    for _ in 0..21 {
        ratios.push(frames_in_a_storm(true)? / frames_in_a_storm(false)?);
    }
    ratios.sort_by(f64::total_cmp);
    let (median, low, high) = (ratios[10], ratios[5], ratios[15]);
    println!("frame rate with {PER_SECOND} transactions a second: {median:.4} of that without ({low:.4} to {high:.4})");
    for threads in [2, 3] {
        let ((alone, _), (slow, behind)) =
            (slow_display(threads, Duration::ZERO)?, slow_display(threads, Duration::from_millis(10))?);
        println!(
            "{threads} threads: a frame takes {:.2} ms, with a display of 10 ms {:.2} ms, which is {behind} frame behind",
            alone * 1e3,
            slow * 1e3
        );
    }
    let start = Instant::now();
    let sum = (0..100_000_000_u64).fold(0, |sum, item| scope("component", || black_box(sum + item)));
    assert_eq!(sum, 4_999_999_950_000_000);
    println!("a scope: {:.2} ns", start.elapsed().as_secs_f64() * 10.0);
    Ok(())
}
