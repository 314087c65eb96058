//! The measurement: frames on 1, 2, ... threads in turns, and what the parts of a frame cost.
//!
//! Rounds are interleaved, so that what else the machine does strikes all thread counts alike, and medians are taken.
//! The machine's own limits are measured in the same rounds: by arithmetic that shares nothing, and by threads each of
//! which renders whole frames for itself. Where two "processors" are threads of one core the second is what counts: they
//! share what rendering needs.

use std::cell::RefCell;
use std::collections::HashMap;
use std::hint::black_box;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use crossbeam_utils::CachePadded;

use super::median;
use super::simulate::{Costs, FrameCosts};
use crate::app::{Chosen, Components, State};
use crate::balance::BalancerKind;
use crate::image::{FrameBuffer, Size};
use crate::pipeline::barrier::Barrier;
use crate::pipeline::threads::{may_pin, pin_current};
use crate::pipeline::{Fault, Pipeline, Report};
use crate::stack::Statistics;
use crate::traverse::{Deal, Fragment, FragmentRenderer, ImageTraverser, TileSize, TraverserKind};

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
    /// How far the eye turns around what it looks at from one frame of the projection to the next, in radians.
    pub turn: f32,
}

/// Frames of the projection: half of them to learn from.
const PROJECTED: usize = 6;

/// How often a round measures what passing a cache line costs.
const HANDOVERS: usize = 4;

/// Frames without rendering.
const EMPTY: u64 = 2000;

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
    pub arithmetic: f64,
    /// How many frames such threads render, each one for itself, in the time in which one thread renders one: the median
    /// over the rounds. No pipeline can be better than that.
    pub limit: f64,
}

/// What was measured.
#[derive(Clone, Debug)]
pub struct Measurement {
    /// By thread count.
    pub runs: Vec<ThreadRun>,
    /// What the parts of frames cost; passing a cache line the least that was seen.
    pub costs: Costs,
    /// What passing a cache line costs: one number, or two where it is now one and now the other, by where the system puts
    /// threads and memory. The least first.
    pub handovers: Vec<f64>,
    /// The part of the processors that arithmetic was given, 1 on a machine that does nothing else.
    pub given: f64,
}

impl Measurement {
    /// With less of the processors what was measured tells of what else the machine does. Two threads of one core, or a machine
    /// whose clock is slower when both are busy, give 0.9 and more.
    pub const ENOUGH: f64 = 0.8;

    /// Was the machine busy with something else?
    pub fn is_disturbed(&self) -> bool {
        self.given < Self::ENOUGH
    }
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
    let counts: Vec<usize> = (1..=plan.threads.max(1)).collect();
    let series = || vec![Vec::new(); counts.len()];
    let (mut frames, mut loops, mut waits, mut alone) = (series(), series(), series(), series());
    let (mut serial, mut display) = (Vec::new(), Vec::new());
    let (mut crossing, mut handovers) = (f64::INFINITY, Vec::new());
    pipeline.state().traverser = traverser();
    turn(pipeline, 1, 1)?; // warm caches
    for round in 0..plan.rounds.max(1) {
        progress(round);
        for (place, &threads) in counts.iter().enumerate() {
            let at_once = arithmetic(threads)?;
            loops[place].push(at_once.seconds);
            waits[place].push(at_once.waited);
            alone[place].push(each_for_itself(&pipeline.state().stack, plan, threads)?.seconds);
            pipeline.state().traverser = traverser();
            turn(pipeline, threads, 2)?; // what a balancer wants to know
            let report = turn(pipeline, threads, plan.frames)?;
            frames[place].push(report.frame_times.median);
        }
        // Frames in which nothing is rendered: what is left is the pipeline's own.
        pipeline.state().traverser = TraverserKind::Null.build(plan.tile, plan.balancer);
        let report = turn(pipeline, 1, EMPTY)?;
        let shown = report.stages.iter().filter(|stage| stage.name == "display");
        serial.push(report.serial_seconds / EMPTY as f64);
        display.push(shown.map(|stage| stage.seconds).sum::<f64>() / EMPTY as f64);
        // The least of the rounds: whatever disturbs these only adds to them.
        crossing = crossing.min(crossing_of_two()?);
        for _ in 0..HANDOVERS {
            handovers.push(handover_of_two()?);
        }
    }
    let projected = frame_costs(pipeline, plan, || progress(plan.rounds))?;
    pipeline.state().traverser = traverser();
    let quotients = |times: &[Vec<f64>], place: usize, threads: usize| {
        let mut quotients: Vec<f64> = times[0].iter().zip(&times[place]).map(|(one, many)| one / many).collect();
        median(&mut quotients) * threads as f64
    };
    let runs = counts.iter().enumerate().map(|(place, &threads)| ThreadRun {
        threads,
        seconds: median(&mut frames[place].clone()),
        speedup: quotients(&frames, place, 1),
        arithmetic: quotients(&loops, place, threads),
        limit: quotients(&alone, place, threads),
    });
    let runs: Vec<ThreadRun> = runs.collect();
    let (serial, display) = (median(&mut serial), median(&mut display));
    let handovers = one_or_two(handovers);
    let costs = Costs { frames: projected, crossing, serial, display, handover: handovers[0] };
    let processors = std::thread::available_parallelism().map_or(1, usize::from);
    let fitting = runs.iter().zip(&mut waits).filter(|(run, _)| run.threads <= processors);
    let shares = fitting.map(|(run, waits)| (run.arithmetic / run.threads as f64).min(1.0 - median(waits)));
    let given = shares.fold(steadiness(&loops[0]), f64::min);
    Ok(Measurement { runs, costs, handovers, given })
}

/// The least of some times of the same work as a part of the usual one.
fn steadiness(times: &[f64]) -> f64 {
    let least = times.iter().copied().fold(f64::INFINITY, f64::min);
    least / median(&mut times.to_vec())
}

/// What some times of the same work say: the least, since whatever disturbs them only adds; or, where they come in two heaps
/// that are apart by a factor of two, the middle of each.
fn one_or_two(mut times: Vec<f64>) -> Vec<f64> {
    times.sort_by(f64::total_cmp);
    let gap = |at: &usize| times[*at] / times[at - 1];
    // A few stragglers are no heap.
    let least = times.len() / 8 + 2;
    let cut = (least..(times.len() + 1).saturating_sub(least)).max_by(|a, b| gap(a).total_cmp(&gap(b)));
    match cut.filter(|cut| gap(cut) >= 2.0) {
        Some(cut) => {
            let (low, high) = times.split_at_mut(cut);
            vec![median(low), median(high)]
        }
        None => vec![times.first().copied().unwrap_or(0.0)],
    }
}

/// What tiles, quarters and sixteenths of them cost on one thread, in frames between which the eye turns.
fn frame_costs(
    pipeline: &mut Pipeline<State>,
    plan: &Plan,
    mut progress: impl FnMut(),
) -> Result<Vec<FrameCosts>, Fault> {
    let chosen = *pipeline.state().chosen();
    let mut all = Vec::new();
    for frame in 0..PROJECTED {
        let view = chosen.view.orbit(plan.turn * frame as f32, 0.0);
        pipeline.state().choose(Chosen { view, ..chosen });
        let mut costs = FrameCosts::default();
        for cut in [1, 2, 4] {
            progress();
            let tile = TileSize { width: (plan.tile.width / cut).max(1), height: (plan.tile.height / cut).max(1) };
            let samples = Arc::<Samples>::default();
            let inner = TraverserKind::Tiled.build(tile, BalancerKind::default());
            pipeline.state().traverser = Box::new(Timed { inner, samples: Arc::clone(&samples) });
            turn(pipeline, 1, plan.frames)?;
            samples.medians(&mut costs);
        }
        all.push(costs);
    }
    pipeline.state().choose(chosen);
    Ok(all)
}

/// Seconds in which each of so many threads renders a frame for itself, all at once. Each begins with another tile, so that
/// no two render the same at the same time.
fn each_for_itself(stack: &Components, plan: &Plan, threads: usize) -> Result<AtOnce, Fault> {
    let mut deal = Deal::new(plan.tile, BalancerKind::default().build());
    deal.begin(&[plan.size], 1);
    let tiles: Vec<Fragment> = deal.whole_tiles().collect();
    at_once(threads, |thread| {
        let (picture, statistics) = (FrameBuffer::with_size(plan.size), Statistics::default());
        let (before, first) = tiles.split_at(tiles.len() * thread / threads);
        first.iter().chain(before).for_each(|tile| stack.render(*tile, &picture, &statistics));
    })
}

fn turn(pipeline: &mut Pipeline<State>, threads: usize, frames: u64) -> Result<Report, Fault> {
    let set = pipeline.set_threads(threads);
    debug_assert!(set.is_ok(), "the caller gives counts that there can be");
    pipeline.run(frames.max(1))
}

/// Seconds that each of so many threads takes for the same arithmetic, all at once.
fn arithmetic(threads: usize) -> Result<AtOnce, Fault> {
    const STEPS: u64 = 20_000_000;
    at_once(threads, |thread| {
        let mut x = black_box(thread as u64 | 1);
        for _ in 0..STEPS {
            x ^= x << 13;
            x ^= x >> 7;
            x ^= x << 17;
        }
        black_box(x);
    })
}

/// What threads took that worked at once.
#[derive(Clone, Copy, Debug)]
struct AtOnce {
    /// Mean of the seconds: who is done first leaves the machine to the others, for a little.
    seconds: f64,
    /// The part of them in which threads waited for a processor that did something else; 0 where the system does not tell.
    waited: f64,
}

/// Seconds that this thread has waited for a processor.
fn waited() -> Option<f64> {
    let counts = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    counts.split(' ').nth(1)?.parse::<u64>().ok().map(|nanoseconds| nanoseconds as f64 * 1e-9)
}

/// Runs `work` on so many threads, pinned as those of a pipeline are, which begin together. None works where not all can be
/// started.
fn at_once(threads: usize, work: impl Fn(usize) + Sync) -> Result<AtOnce, Fault> {
    let begin = Barrier::new(threads);
    let run = |thread: usize| {
        let _pinned = may_pin(threads).then(pin_current);
        begin.cross(thread, |_| ()).ok()?;
        let (start, before) = (Instant::now(), waited());
        work(thread);
        let seconds = start.elapsed().as_secs_f64();
        let waited = before.zip(waited()).map_or(0.0, |(before, after)| after - before);
        Some([seconds, waited])
    };
    let (started, times) = std::thread::scope(|scope| {
        let run = &run;
        let start = |thread: usize| std::thread::Builder::new().spawn_scoped(scope, move || run(thread));
        let started: Vec<_> = (0..threads).map_while(|thread| start(thread).ok()).collect();
        if started.len() < threads {
            begin.abort();
        }
        let count = started.len();
        let times: Vec<[f64; 2]> = started.into_iter().filter_map(|thread| thread.join().ok().flatten()).collect();
        (count, times)
    });
    if started < threads {
        let message = format!("only {started} of {threads} threads could be started; measure fewer");
        return Err(Fault { component: "threads".into(), thread: 0, frame: 0, message, location: None });
    }
    let sum = |of: usize| times.iter().map(|time| time[of]).sum::<f64>();
    Ok(AtOnce { seconds: sum(0) / times.len().max(1) as f64, waited: sum(1) / sum(0).max(1e-9) })
}

fn crossing_of_two() -> Result<f64, Fault> {
    const ROUNDS: u32 = 4000;
    let barrier = Barrier::new(2);
    let cross = |me: usize| {
        let _ = barrier.cross(me, |_| ());
    };
    Ok(at_once(2, |me| (0..ROUNDS).for_each(|_| cross(me)))?.seconds / f64::from(ROUNDS))
}

/// In turns, so that the line really passes: each thread waits until the other has added.
fn handover_of_two() -> Result<f64, Fault> {
    const ROUNDS: u32 = 4000;
    let counter = CachePadded::new(AtomicUsize::new(0));
    let add_in_turn = |me: usize| {
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
    };
    Ok(at_once(2, |me| (0..ROUNDS).for_each(|_| add_in_turn(me)))?.seconds / f64::from(2 * ROUNDS))
}

/// What fragments cost, frame after frame.
#[derive(Debug, Default)]
struct Samples(Mutex<HashMap<Fragment, Vec<f64>>>);

impl Samples {
    fn add(&self, times: &[(Fragment, f64)]) {
        let mut samples = self.lock();
        for &(fragment, seconds) in times {
            samples.entry(fragment).or_default().push(seconds);
        }
    }

    fn medians(&self, costs: &mut FrameCosts) {
        self.lock().iter_mut().for_each(|(fragment, times)| costs.set(fragment, median(times)));
    }

    fn lock(&self) -> MutexGuard<'_, HashMap<Fragment, Vec<f64>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A traverser that notes what each fragment costs.
struct Timed {
    inner: Box<dyn ImageTraverser>,
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
        self.samples.add(&clock.times.into_inner());
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_heaps_are_told_from_one() {
        let one = [2.5e-8, 2.6e-8, 2.4e-8, 3.0e-8, 9e-8];
        assert_eq!(one_or_two(one.to_vec()), [2.4e-8], "one straggler is no heap");
        let two = [2.4e-8, 21e-8, 2.5e-8, 20e-8, 2.6e-8, 22e-8];
        assert_eq!(one_or_two(two.to_vec()), [2.5e-8, 21e-8]);
        assert_eq!((one_or_two(vec![7.0]), one_or_two(Vec::new())), (vec![7.0], vec![0.0]));
    }

    #[test]
    fn a_disturbed_machine_is_told() {
        let measured = |given: f64| Measurement { runs: vec![], costs: Costs::default(), handovers: vec![0.0], given };
        assert!(measured(0.66).is_disturbed() && !measured(0.92).is_disturbed());
        assert!((steadiness(&[1.0, 2.0, 4.0]) - 0.5).abs() < 1e-9);
    }
}
