//! Frames pass through all stages, each once, in order, whatever changes between them.

use std::error::Error;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use mobula::balance::{LoadBalancer, WorkQueue};
use mobula::image::Size;
use mobula::pipeline::{
    Balance, Config, Display, DisplayStage, Frame, NullDisplay, Picture, Pipeline, Plan, Shown, Stage, stage,
};
use proptest::prelude::*;

/// What a display was shown: frame, size, and the pixel (0, 0).
type Log = Arc<Mutex<Vec<(u64, Size, u32)>>>;

struct Recorder(Log);

impl Display for Recorder {
    fn name(&self) -> &str {
        "recorder"
    }

    fn show(&mut self, picture: &Picture<'_>) -> Result<Shown, Box<dyn Error + Send + Sync>> {
        assert_eq!(picture.size, picture.buffer.size());
        let corner = picture.buffer.get(0, 0);
        assert!(picture.buffer.pixels().all(|pixel| pixel == corner), "a torn picture");
        self.0.lock().unwrap().push((picture.frame, picture.size, corner));
        Ok(Shown::Continue)
    }
}

/// Fills each picture with the number of its frame; rows are shared evenly.
fn paint(frame: &Frame<'_, ()>) {
    for view in frame.channels() {
        let row = vec![frame.number as u32; view.buffer.width()];
        for y in (frame.thread..view.buffer.height()).step_by(frame.threads) {
            view.buffer.set_row(0, y, &row);
        }
    }
}

fn size(width: usize, height: usize) -> Size {
    Size::new(width, height).unwrap()
}

fn frames(log: &Log) -> Vec<u64> {
    log.lock().unwrap().iter().map(|shown| shown.0).collect()
}

fn painter(threads: usize, log: &Log) -> Pipeline<()> {
    let mut pipeline = Pipeline::new((), Config::with_threads(threads)).unwrap();
    pipeline.add_channel("main", size(16, 9));
    pipeline.add_stage(stage("paint", Balance::Balanced, paint));
    pipeline.add_stage(DisplayStage::new().with(0, Recorder(log.clone())));
    pipeline
}

#[test]
fn every_frame_is_shown_once_in_order() {
    for threads in [1, 2, 3, 7, 20] {
        let log = Log::default();
        let report = painter(threads, &log).run(50).unwrap();
        assert_eq!(report.frames, 50);
        assert_eq!(report.threads.len(), threads);
        assert_eq!(frames(&log), (0..50).collect::<Vec<_>>());
        assert!(log.lock().unwrap().iter().all(|&(frame, _, corner)| corner as u64 == frame));
    }
}

#[test]
fn a_pipeline_runs_again_and_counts_on() {
    let log = Log::default();
    let mut pipeline = painter(2, &log);
    assert_eq!(pipeline.picture(0).map(|newest| newest.0), None);
    for run in 1..=3 {
        assert_eq!(pipeline.run(4).unwrap().frames, 4);
        let (frame, buffer) = pipeline.picture(0).unwrap();
        assert_eq!((frame, buffer.get(3, 3) as u64), (run * 4 - 1, run * 4 - 1));
    }
    assert_eq!(pipeline.run(0).unwrap().frames, 0);
    assert_eq!(frames(&log), (0..12).collect::<Vec<_>>());
}

#[test]
fn a_pipeline_without_stages_or_channels_ends_too() {
    let mut pipeline = Pipeline::new(7, Config::with_threads(2)).unwrap();
    assert_eq!(pipeline.run(3).unwrap().frames, 3);
    assert_eq!(pipeline.into_state(), 7);
    let mut pipeline = Pipeline::new(7, Config::with_threads(2)).unwrap();
    let times = Arc::new(AtomicUsize::new(0));
    let counted = times.clone();
    pipeline.add_stage(stage("no pictures", Balance::Dynamic, move |frame: &Frame<'_, u8>| {
        assert!(frame.channels().is_empty());
        counted.fetch_add(1, Ordering::Relaxed);
    }));
    assert_eq!(pipeline.run(3).unwrap().frames, 3);
    assert_eq!(times.load(Ordering::Relaxed), 6);
}

#[test]
fn bad_thread_counts_are_refused() {
    assert!(Pipeline::<()>::new((), Config::with_threads(0)).is_err());
    assert!(Pipeline::<()>::new((), Config::with_threads(1025)).is_err());
    let pipeline = Pipeline::<()>::new((), Config::with_threads(1)).unwrap();
    let error = pipeline.handle().set_threads(0).unwrap_err();
    assert_eq!(error.to_string(), "a pipeline has 1 to 1024 threads, not 0");
}

/// Checks that each frame is run by each of its threads once.
#[derive(Clone, Default)]
struct RollCall(Arc<Mutex<Vec<Vec<usize>>>>);

impl RollCall {
    fn answer(&self, frame: u64, thread: usize, threads: usize) {
        let mut called = self.0.lock().unwrap();
        if called.len() <= frame as usize {
            called.resize(frame as usize + 1, Vec::new());
        }
        let called = &mut called[frame as usize];
        called.resize(threads, 0);
        called[thread] += 1;
    }

    /// The thread count of each frame, if all answered.
    fn counts(&self) -> Vec<usize> {
        let called = self.0.lock().unwrap();
        assert!(called.iter().flatten().all(|&times| times == 1), "{called:?}");
        called.iter().map(Vec::len).collect()
    }
}

#[test]
fn threads_change_from_1_to_64_to_3_and_no_frame_is_lost() {
    for pin in [true, false] {
        let (log, roll) = (Log::default(), RollCall::default());
        let mut pipeline = Pipeline::new((), Config { threads: 1, pin, ..Config::default() }).unwrap();
        pipeline.add_channel("main", size(16, 70));
        let called = roll.clone();
        pipeline.add_stage(stage("paint", Balance::Balanced, move |frame: &Frame<'_, ()>| {
            called.answer(frame.number, frame.thread, frame.threads);
            paint(frame);
        }));
        pipeline.add_stage(DisplayStage::new().with(0, Recorder(log.clone())));
        for (frame, threads) in [(5, 64), (10, 3), (15, 2), (20, 1)] {
            pipeline.callbacks().at_frame("threads", frame, move |point| point.set_threads(threads).unwrap());
        }
        assert_eq!(pipeline.run(25).unwrap().frames, 25);
        let expected = [[1; 5], [64; 5], [3; 5], [2; 5], [1; 5]].concat();
        assert_eq!(roll.counts(), expected);
        assert_eq!(frames(&log), (0..25).collect::<Vec<_>>());
        // The next run has as many threads as the last one ended with.
        assert_eq!(pipeline.run(2).unwrap().threads.len(), 1);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn storms_of_sizes_and_threads_lose_no_frame(
        storm in prop::collection::vec((0..40_u64, 1..24_usize, 1..30_usize, 1..30_usize), 0..20),
        threads in 1..9_usize,
    ) {
        let (log, roll) = (Log::default(), RollCall::default());
        let mut pipeline = Pipeline::new((), Config::with_threads(threads)).unwrap();
        pipeline.add_channel("main", size(3, 3));
        let called = roll.clone();
        pipeline.add_stage(stage("paint", Balance::Balanced, move |frame: &Frame<'_, ()>| {
            called.answer(frame.number, frame.thread, frame.threads);
            paint(frame);
        }));
        pipeline.add_stage(DisplayStage::new().with(0, Recorder(log.clone())));
        let mut expected = (vec![threads; 40], vec![size(3, 3); 40]);
        let mut storm = storm;
        storm.sort_by_key(|change| change.0);
        for (frame, threads, width, height) in storm {
            pipeline.callbacks().at_frame("change", frame, move |point| {
                point.set_threads(threads).unwrap();
                point.resize(0, size(width, height));
                point.resize(99, size(1, 1)); // no such channel
            });
            expected.0[frame as usize..].fill(threads);
            expected.1[frame as usize..].fill(size(width, height));
        }
        pipeline.run(40).unwrap();
        prop_assert_eq!(roll.counts(), expected.0);
        let log = log.lock().unwrap();
        prop_assert_eq!(log.iter().map(|shown| shown.1).collect::<Vec<_>>(), expected.1);
        prop_assert!(log.iter().enumerate().all(|(at, shown)| shown.0 == at as u64 && shown.2 as usize == at));
    }
}

/// Two channels with their displays, and a log for a third.
fn two_channels() -> (Pipeline<()>, DisplayStage, [Log; 3]) {
    let logs = [Log::default(), Log::default(), Log::default()];
    let mut pipeline = Pipeline::new((), Config::with_threads(3)).unwrap();
    pipeline.add_channel("left", size(16, 9));
    pipeline.add_channel("right", size(5, 40));
    pipeline.add_stage(stage("paint", Balance::Balanced, paint));
    let displays = DisplayStage::new().with(0, Recorder(logs[0].clone())).with(1, Recorder(logs[1].clone()));
    pipeline.add_stage(displays.clone());
    (pipeline, displays, logs)
}

#[test]
fn channels_have_sizes_and_displays_of_their_own() {
    let (mut pipeline, displays, logs) = two_channels();
    displays.attach(2, Recorder(logs[2].clone()));
    pipeline.callbacks().at_frame("third", 6, |point| {
        assert_eq!(point.channels().len(), 2);
        assert_eq!(point.add_channel("third", Size::new(2, 2).unwrap()), 2);
    });
    let sizes = Arc::new(Mutex::new(Vec::new()));
    let resized = sizes.clone();
    pipeline.callbacks().resize("sizes", move |point, channel, size| {
        resized.lock().unwrap().push((point.frame, channel, size));
    });
    pipeline.run(10).unwrap();
    assert_eq!(frames(&logs[0]), (0..10).collect::<Vec<_>>());
    assert_eq!(frames(&logs[1]), (0..10).collect::<Vec<_>>());
    assert_eq!(frames(&logs[2]), (6..10).collect::<Vec<_>>());
    assert!(logs[1].lock().unwrap().iter().all(|shown| shown.1 == size(5, 40)));
    assert_eq!(*sizes.lock().unwrap(), [(0, 0, size(16, 9)), (0, 1, size(5, 40)), (6, 2, size(2, 2))]);
}

#[test]
fn channels_come_and_go_with_their_displays_and_keep_their_indices() {
    let (mut pipeline, displays, logs) = two_channels();
    let third = logs[2].clone();
    pipeline.callbacks().at_frame("come and go", 4, move |point| {
        point.remove_channel(0);
        point.remove_channel(77); // no such channel
        let index = point.add_channel("third", Size::new(2, 2).unwrap());
        displays.attach(index, Recorder(third.clone()));
    });
    pipeline.callbacks().at_frame("go", 7, |point| {
        assert_eq!(point.channels().iter().map(|channel| channel.open).collect::<Vec<_>>(), [false, true, true]);
        point.remove_channel(1);
        point.resize(0, Size::new(100, 100).unwrap()); // it is gone
    });
    pipeline.callbacks().at_frame("the last one goes", 9, |point| point.remove_channel(2));
    assert_eq!(pipeline.run(12).unwrap().frames, 12);
    assert_eq!(logs.each_ref().map(frames), [(0..4).collect::<Vec<_>>(), (0..7).collect(), (4..9).collect()]);
    for log in &logs {
        assert!(log.lock().unwrap().iter().all(|&(frame, _, corner)| corner as u64 == frame));
    }
    assert!(logs[1].lock().unwrap().iter().all(|shown| shown.1 == size(5, 40)));
}

#[test]
fn a_display_may_detach_or_end_the_run() {
    struct Until(u64, Shown);
    impl Display for Until {
        fn name(&self) -> &str {
            "until"
        }
        fn show(&mut self, picture: &Picture<'_>) -> Result<Shown, Box<dyn Error + Send + Sync>> {
            assert!(picture.frame <= self.0 + 2, "a closed display is shown no more");
            Ok(if picture.frame == self.0 { self.1 } else { Shown::Continue })
        }
    }
    for threads in [1, 3] {
        for (what, expected) in [(Shown::Detach, 40..=40), (Shown::Stop, 7..=8)] {
            let mut pipeline = Pipeline::new((), Config::with_threads(threads)).unwrap();
            pipeline.add_channel("main", size(4, 4));
            pipeline.add_stage(stage("paint", Balance::Balanced, paint));
            pipeline.add_stage(DisplayStage::new().with(0, Until(5, what)));
            let frames = pipeline.run(40).unwrap().frames;
            assert!(expected.contains(&frames), "{what:?}: {frames}");
        }
    }
}

#[test]
fn a_third_stage_in_between_adds_one_frame_of_latency() {
    let log = Log::default();
    let mut pipeline = Pipeline::new((), Config::with_threads(2)).unwrap();
    pipeline.add_channel("main", size(8, 8));
    let newest = Arc::new(AtomicU64::new(0));
    let rendering = newest.clone();
    pipeline.add_stage(stage("paint", Balance::Balanced, move |frame: &Frame<'_, ()>| {
        rendering.store(frame.number, Ordering::Relaxed);
        paint(frame);
    }));
    pipeline.add_stage(stage("tone", Balance::Balanced, |frame: &Frame<'_, ()>| {
        let picture = frame.channels()[0].buffer;
        for y in (frame.thread..picture.height()).step_by(frame.threads) {
            (0..picture.width()).for_each(|x| picture.set(x, y, picture.get(x, y) + 1000));
        }
    }));
    struct Late(Recorder, Arc<AtomicU64>);
    impl Display for Late {
        fn name(&self) -> &str {
            "late"
        }
        fn show(&mut self, picture: &Picture<'_>) -> Result<Shown, Box<dyn Error + Send + Sync>> {
            assert!(self.1.load(Ordering::Relaxed) <= picture.frame + 2);
            self.0.show(picture)
        }
    }
    pipeline.add_stage(DisplayStage::new().with(0, Late(Recorder(log.clone()), newest)));
    pipeline.run(30).unwrap();
    let log = log.lock().unwrap();
    assert!(log.iter().enumerate().all(|(at, shown)| shown.0 == at as u64 && shown.2 as usize == 1000 + at));
    assert_eq!(log.len(), 30);
}

/// Dynamically balanced work that sleeps, so that it takes its time even on a busy machine.
struct Naps {
    queue: WorkQueue,
    naps: usize,
    frame: Arc<AtomicU64>,
}

impl Stage<()> for Naps {
    fn name(&self) -> &str {
        "naps"
    }

    fn balance(&self) -> Balance {
        Balance::Dynamic
    }

    fn begin(&mut self, _: &mut (), plan: &Plan<'_>) {
        self.frame.store(plan.number, Ordering::Relaxed);
        self.queue.reset(self.naps, plan.threads);
    }

    fn run(&self, frame: &Frame<'_, ()>) {
        while let Some(naps) = self.queue.next(frame.thread) {
            std::thread::sleep(Duration::from_millis(2) * naps.len() as u32);
        }
    }
}

/// Shows that the frame it is given is the one before the frame that is being rendered.
struct Slow {
    rendering: Arc<AtomicU64>,
    shown: Arc<AtomicUsize>,
}

impl Display for Slow {
    fn name(&self) -> &str {
        "slow"
    }

    fn show(&mut self, picture: &Picture<'_>) -> Result<Shown, Box<dyn Error + Send + Sync>> {
        let rendering = self.rendering.load(Ordering::Relaxed);
        assert!(rendering == picture.frame + 1 || (rendering == 19 && picture.frame == 19), "more than one frame late");
        std::thread::sleep(Duration::from_millis(10));
        self.shown.fetch_add(1, Ordering::Relaxed);
        Ok(Shown::Continue)
    }
}

#[test]
fn a_slow_display_hides_behind_rendering() {
    let time = |slow: bool| {
        let mut pipeline = Pipeline::new((), Config::with_threads(16)).unwrap();
        pipeline.add_channel("main", size(2, 2));
        let (frame, shown) = (Arc::new(AtomicU64::new(0)), Arc::new(AtomicUsize::new(0)));
        pipeline.add_stage(Naps { queue: WorkQueue::default(), naps: 160, frame: frame.clone() });
        let stage = DisplayStage::new();
        pipeline.add_stage(match slow {
            true => stage.with(0, Slow { rendering: frame, shown: shown.clone() }),
            false => stage.with(0, NullDisplay),
        });
        let report = pipeline.run(20).unwrap();
        assert_eq!(shown.load(Ordering::Relaxed), if slow { 20 } else { 0 });
        report.frame_times.median
    };
    // 160 naps of 2 ms on 16 threads: 20 ms. Ten more from the display: 20.6 ms if hidden, 30 ms if not. Naps are long on a
    // busy machine: one good pair of runs in five is enough.
    let ratios: Vec<f64> = (0..5).map(|_| time(true) / time(false)).collect();
    assert!(ratios.iter().any(|&ratio| ratio < 1.25), "with a slow display, of the time without: {ratios:?}");
}

/// No stack is that large, so no thread can be started: the thread that runs the pipeline renders.
#[test]
fn where_there_are_no_threads_the_caller_renders() {
    let config = Config { stack_size: Some(1 << 60), ..Config::with_threads(4) };
    let mut pipeline = Pipeline::new((), config).unwrap();
    pipeline.add_channel("main", Size::new(8, 8).unwrap());
    let caller = std::thread::current().id();
    pipeline.add_stage(stage("render", Balance::Dynamic, move |frame: &Frame<'_, ()>| {
        assert_eq!((std::thread::current().id(), frame.threads), (caller, 1));
    }));
    for _ in 0..2 {
        let report = pipeline.run(3).unwrap();
        assert_eq!((report.frames, report.threads.len()), (3, 1));
        assert!(report.notes.iter().any(|note| note.starts_with("no render thread could be started")));
    }
}
