//! The measurement: frames on 1, 2, ... threads in turns, and what the parts of a frame cost.
//!
//! Rounds are interleaved, so that what else the machine does strikes all thread counts alike, and medians are taken.
//! The machine's own limit is measured in the same rounds, by arithmetic that shares nothing.

use std::cell::RefCell;
use std::hint::black_box;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use crossbeam_utils::CachePadded;

use super::median;
use super::simulate::Costs;
use crate::app::State;
use crate::balance::{BalancerKind, LoadBalancer};
use crate::image::Size;
use crate::pipeline::barrier::Barrier;
use crate::pipeline::{Fault, Pipeline, Report};
use crate::traverse::{Fragment, FragmentRenderer, ImageTraverser, TileSize, TraverserKind};

/// What is to be measured.
#[derive(Clone, Copy, Debug)]
pub struct Plan {
    /// The most threads.
    pub threads: usize,
    /// How often each thread count has its turn.
    pub rounds: usize,
    /// Frames of a turn.
    pub frames: u64,
    /// Size of the picture.
    pub size: Size,
    /// Size of a tile.
    pub tile: TileSize,
    /// The load balancer.
    pub balancer: BalancerKind,
}

/// Frames on so many threads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThreadRun {
    /// How many.
    pub threads: usize,
    /// Median time of a frame.
    pub seconds: f64,
    /// Times faster than one thread: the median over the rounds.
    pub speedup: f64,
    /// Times faster than one thread in arithmetic that shares nothing: the median over the rounds.
    pub limit: f64,
}

/// What was measured.
#[derive(Clone, Debug)]
pub struct Measurement {
    /// By thread count.
    pub runs: Vec<ThreadRun>,
    /// What the parts of a frame cost.
    pub costs: Costs,
}

/// Measures a pipeline that has one channel and its stages. It is left with another traverser and thread count.
///
/// # Errors
/// If a component fails.
pub fn measure(
    pipeline: &mut Pipeline<State>,
    plan: &Plan,
    mut progress: impl FnMut(usize),
) -> Result<Measurement, Fault> {
    let traverser = || TraverserKind::Tiled.build(plan.tile, plan.balancer);
    let samples = Arc::<Samples>::default();
    let counts: Vec<usize> = (1..=plan.threads.max(1)).collect();
    let (mut frames, mut loops) = (vec![Vec::new(); counts.len()], vec![Vec::new(); counts.len()]);
    let (mut serial, mut display) = (Vec::new(), Vec::new());
    let (mut crossing, mut handover) = (f64::INFINITY, f64::INFINITY);
    pipeline.state().traverser = traverser();
    turn(pipeline, 1, 1)?; // warm caches
    for round in 0..plan.rounds.max(1) {
        progress(round);
        for (place, &threads) in counts.iter().enumerate() {
            loops[place].push(arithmetic(threads));
            pipeline.state().traverser = traverser();
            let report = turn(pipeline, threads, plan.frames)?;
            frames[place].push(report.frame_times.median);
            let per_frame = |seconds: f64| seconds / report.frames.max(1) as f64;
            if threads == 1 {
                serial.push(per_frame(report.serial_seconds));
                let shown = report.stages.iter().filter(|stage| stage.name == "display");
                display.push(per_frame(shown.map(|stage| stage.seconds).sum()));
            }
        }
        pipeline.state().traverser =
            Box::new(Timed { inner: traverser(), tile: plan.tile, size: plan.size, samples: Arc::clone(&samples) });
        turn(pipeline, 1, plan.frames)?;
        // The least of the rounds: whatever disturbs these only adds to them.
        crossing = crossing.min(crossing_of_two());
        handover = handover.min(handover_of_two());
    }
    pipeline.state().traverser = traverser();
    let tiles = samples.medians();
    let quotients = |times: &[Vec<f64>], place: usize, threads: usize| {
        let mut quotients: Vec<f64> = times[0].iter().zip(&times[place]).map(|(one, many)| one / many).collect();
        median(&mut quotients) * threads as f64
    };
    let runs = counts.iter().enumerate().map(|(place, &threads)| ThreadRun {
        threads,
        seconds: median(&mut frames[place].clone()),
        speedup: quotients(&frames, place, 1),
        limit: quotients(&loops, place, threads),
    });
    let costs = Costs { tiles, crossing, serial: median(&mut serial), display: median(&mut display), handover };
    Ok(Measurement { runs: runs.collect(), costs })
}

/// Seconds that a balancer's own arithmetic takes for one assignment of so many items for so many processors.
pub fn take_cost(balancer: &dyn LoadBalancer, items: usize, processors: usize) -> f64 {
    let mut costs: Vec<f64> = (0..9).map(|_| drain(balancer, items, processors)).collect();
    median(&mut costs)
}

fn drain(balancer: &dyn LoadBalancer, items: usize, processors: usize) -> f64 {
    balancer.reset(items, processors);
    let (mut asked, start) = (0_u32, Instant::now());
    for thread in 0..processors {
        while black_box(balancer.next(thread)).is_some() {
            asked += 1;
        }
        asked += 1;
    }
    start.elapsed().as_secs_f64() / f64::from(asked)
}

fn turn(pipeline: &mut Pipeline<State>, threads: usize, frames: u64) -> Result<Report, Fault> {
    let ticket = pipeline.handle().set_threads(threads);
    debug_assert!(ticket.is_ok(), "the caller gives counts that there can be");
    pipeline.run(frames.max(1))
}

/// Seconds that each of so many threads takes for the same arithmetic, all at once.
fn arithmetic(threads: usize) -> f64 {
    const STEPS: u64 = 20_000_000;
    let start = Instant::now();
    std::thread::scope(|scope| {
        for thread in 0..threads as u64 {
            scope.spawn(move || {
                let mut x = black_box(thread | 1);
                for _ in 0..STEPS {
                    x ^= x << 13;
                    x ^= x >> 7;
                    x ^= x << 17;
                }
                black_box(x)
            });
        }
    });
    start.elapsed().as_secs_f64()
}

fn crossing_of_two() -> f64 {
    let barrier = Barrier::new(2);
    of_two(2000, |_| {
        let _ = barrier.cross(|_| ());
    })
}

fn handover_of_two() -> f64 {
    let counter = CachePadded::new(AtomicUsize::new(0));
    // In turns, so that the line really passes: each thread waits until the other has added.
    of_two(1000, |me| {
        let mut looks = 0_u32;
        while counter.load(Ordering::Relaxed) % 2 != me {
            looks += 1;
            if looks.is_multiple_of(1 << 14) {
                std::thread::yield_now();
            } else {
                std::hint::spin_loop();
            }
        }
        counter.fetch_add(1, Ordering::Relaxed);
    }) / 2.0
}

/// Seconds of one of many rounds that two threads go through together.
fn of_two(rounds: u32, work: impl Fn(usize) + Sync) -> f64 {
    let begin = Barrier::new(2);
    let run = |me: usize| {
        let _ = begin.cross(|_| ());
        let start = Instant::now();
        (0..rounds).for_each(|_| work(me));
        start.elapsed().as_secs_f64() / f64::from(rounds)
    };
    std::thread::scope(|scope| {
        let other = scope.spawn(|| run(1));
        let mine = run(0);
        mine.max(other.join().unwrap_or(0.0))
    })
}

/// What tiles cost, frame after frame.
#[derive(Debug, Default)]
struct Samples(Mutex<Vec<Vec<f64>>>);

impl Samples {
    fn add(&self, times: &[(usize, f64)]) {
        let mut tiles = self.lock();
        for &(tile, seconds) in times {
            if tiles.len() <= tile {
                tiles.resize(tile + 1, Vec::new());
            }
            tiles[tile].push(seconds);
        }
    }

    fn medians(&self) -> Vec<f64> {
        self.lock().iter_mut().map(|times| median(times)).collect()
    }

    fn lock(&self) -> MutexGuard<'_, Vec<Vec<f64>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A traverser that notes what each tile of the first channel costs.
struct Timed {
    inner: Box<dyn ImageTraverser>,
    tile: TileSize,
    size: Size,
    samples: Arc<Samples>,
}

impl ImageTraverser for Timed {
    fn name(&self) -> &'static str {
        self.inner.name()
    }

    fn begin(&mut self, sizes: &[Size], threads: usize, changed: bool) {
        self.inner.begin(sizes, threads, changed);
    }

    fn traverse(&self, thread: usize, renderer: &dyn FragmentRenderer) -> bool {
        let clock = Clock { renderer, times: RefCell::default() };
        let more = self.inner.traverse(thread, &clock);
        let (tile, across) = (self.tile, self.size.width().div_ceil(self.tile.width));
        let number = |fragment: Fragment| fragment.y0 / tile.height * across + fragment.x0 / tile.width;
        let times: Vec<_> = clock.times.into_inner().into_iter().map(|(f, seconds)| (number(f), seconds)).collect();
        self.samples.add(&times);
        more
    }
}

struct Clock<'a> {
    renderer: &'a dyn FragmentRenderer,
    times: RefCell<Vec<(Fragment, f64)>>,
}

impl FragmentRenderer for Clock<'_> {
    fn render(&self, fragment: &Fragment) {
        let start = Instant::now();
        self.renderer.render(fragment);
        self.times.borrow_mut().push((*fragment, start.elapsed().as_secs_f64()));
    }

    fn keep(&self, fragment: &Fragment) -> bool {
        self.renderer.keep(fragment)
    }

    fn halted(&self) -> bool {
        self.renderer.halted()
    }
}
