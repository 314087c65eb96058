//! A fault in any component, on any thread, in any frame: a clean error that names it, within a second, and nobody
//! else is harmed.

use std::error::Error;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, mpsc};
use std::time::{Duration, Instant};

use mobula::image::Size;
use mobula::pipeline::fault::{fail, scope};
use mobula::pipeline::{
    Balance, Config, Display, DisplayStage, Fault, Frame, Picture, Pipeline, Plan, Shown, Stage, StageBuffer,
    TransactionError, stage,
};
use proptest::prelude::*;

/// Runs `body` and fails if it hangs, leaving it behind, or takes longer than a second. A machine that is busy with
/// something else may take its time once or twice: the best of three runs counts.
fn within_a_second(body: impl Fn() + Clone + Send + 'static) {
    let run = || {
        let (done, result) = mpsc::channel();
        let body = body.clone();
        let thread = std::thread::spawn(move || {
            let start = Instant::now();
            body();
            done.send(start.elapsed()).unwrap();
        });
        match result.recv_timeout(Duration::from_secs(120)) {
            Ok(time) => time,
            Err(mpsc::RecvTimeoutError::Timeout) => panic!("it hangs"),
            Err(mpsc::RecvTimeoutError::Disconnected) => std::panic::resume_unwind(thread.join().unwrap_err()),
        }
    };
    let mut times = Vec::new();
    while times.len() < 3 {
        times.push(run());
        if times[times.len() - 1] < Duration::from_secs(1) {
            return;
        }
    }
    panic!("it took {times:?}");
}

/// Where the fault is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Place {
    Balanced,
    Dynamic,
    Begin,
    Material,
    Display,
    DisplayError,
    Setup,
    SerialAnimation,
    ParallelAnimation,
    SerialPreRender,
    ParallelPreRender,
    AtFrame,
    Changed,
    Resize,
    Termination,
    Transaction,
    Batch,
    Buffer,
}

const PLACES: [Place; 18] = [
    Place::Balanced,
    Place::Dynamic,
    Place::Begin,
    Place::Material,
    Place::Display,
    Place::DisplayError,
    Place::Setup,
    Place::SerialAnimation,
    Place::ParallelAnimation,
    Place::SerialPreRender,
    Place::ParallelPreRender,
    Place::AtFrame,
    Place::Changed,
    Place::Resize,
    Place::Termination,
    Place::Transaction,
    Place::Batch,
    Place::Buffer,
];

impl Place {
    fn component(self) -> &'static str {
        match self {
            Self::Balanced => "tone map",
            Self::Dynamic | Self::Begin => "render",
            Self::Material => "material lambertian",
            Self::Display | Self::DisplayError => "frail display",
            Self::Setup | Self::SerialAnimation | Self::ParallelAnimation | Self::SerialPreRender => "callback frail",
            Self::ParallelPreRender | Self::AtFrame | Self::Changed | Self::Resize => "callback frail",
            Self::Termination => "callback frail",
            Self::Transaction | Self::Batch => "transaction frail",
            Self::Buffer => "frame buffer",
        }
    }

    /// Whether the fault happens on the thread and in the frame that were chosen.
    fn is_in_a_stage(self) -> bool {
        matches!(self, Self::Balanced | Self::Dynamic | Self::Material)
    }
}

/// The state: which fault to make, and when.
#[derive(Clone, Debug)]
struct Frail {
    place: Place,
    frame: u64,
    thread: usize,
}

impl Frail {
    fn strike(&self, place: Place, frame: u64, thread: Option<usize>) {
        let here = self.place == place && frame == self.frame;
        if here && thread.is_none_or(|thread| thread == self.thread) {
            panic!("struck in {place:?}");
        }
    }
}

/// A buffer that cannot be had in one size.
struct Fragile(Size);

impl StageBuffer for Fragile {
    fn for_size(size: Size) -> Self {
        assert!(size.width() != 13, "struck in Buffer");
        Self(size)
    }
}

struct Render;

impl Stage<Frail, Fragile> for Render {
    fn name(&self) -> &str {
        "render"
    }

    fn balance(&self) -> Balance {
        Balance::Dynamic
    }

    fn begin(&mut self, frail: &mut Frail, plan: &Plan<'_>) {
        frail.strike(Place::Begin, plan.number, None);
    }

    fn run(&self, frame: &Frame<'_, Frail, Fragile>) {
        assert_eq!(frame.channels()[0].buffer.0, frame.channels()[0].size);
        scope("sampler", || ());
        frame.state.strike(Place::Dynamic, frame.number, Some(frame.thread));
        scope("renderer", || {
            scope("material lambertian", || {
                frame.state.strike(Place::Material, frame.number, Some(frame.thread));
            });
        });
        // The others are in the middle of something long, and look up from time to time.
        let strikes = match frame.state.place {
            Place::Dynamic | Place::Material => frame.state.frame,
            Place::Balanced => frame.state.frame + 1, // a stage further on
            _ => u64::MAX,
        };
        while frame.number == strikes && !frame.halted() {
            std::thread::yield_now();
        }
    }
}

struct FrailDisplay(Frail);

impl Display<Fragile> for FrailDisplay {
    fn name(&self) -> &str {
        "frail display"
    }

    fn show(&mut self, picture: &Picture<'_, Fragile>) -> Result<Shown, Box<dyn Error + Send + Sync>> {
        self.0.strike(Place::Display, picture.frame, None);
        if self.0.place == Place::DisplayError && picture.frame == self.0.frame {
            return Err("struck in DisplayError".into());
        }
        Ok(Shown::Continue)
    }
}

fn frail_pipeline(frail: &Frail, threads: usize) -> Pipeline<Frail, Fragile> {
    let mut pipeline = Pipeline::with_buffers(frail.clone(), Config::with_threads(threads)).unwrap();
    pipeline.add_channel("main", Size::new(8, 8).unwrap());
    pipeline.add_stage(Render);
    pipeline.add_stage(stage("tone map", Balance::Balanced, |frame: &Frame<'_, Frail, Fragile>| {
        frame.state.strike(Place::Balanced, frame.number, Some(frame.thread));
    }));
    pipeline.add_stage(DisplayStage::new().with(0, FrailDisplay(frail.clone())));
    let callbacks = pipeline.callbacks();
    let place = frail.place;
    callbacks.setup("frail", |point| {
        if point.state.place == Place::Setup {
            fail("struck in Setup");
        }
    });
    callbacks.changed("frail", |point| point.state.strike(Place::Changed, point.frame, None));
    callbacks.serial_pre_render("frail", |point| point.state.strike(Place::SerialPreRender, point.frame, None));
    callbacks.resize("frail", |point, _, _| point.state.strike(Place::Resize, point.frame, None));
    callbacks.termination("frail", |point| {
        if point.state.place == Place::Termination {
            fail("struck in Termination");
        }
    });
    // Animation and parallel callbacks change how a frame goes: only where they are what is tested.
    match place {
        Place::SerialAnimation => {
            callbacks.serial_animation("frail", move |point| point.state.strike(place, point.frame, None));
        }
        Place::ParallelAnimation => {
            callbacks.parallel_animation("frail", move |worker| {
                worker.state.strike(place, worker.frame, Some(worker.thread));
            });
        }
        Place::ParallelPreRender => {
            callbacks.parallel_pre_render("frail", move |worker| {
                worker.state.strike(place, worker.frame, Some(worker.thread));
            });
        }
        _ => {}
    }
    callbacks.at_frame("frail", frail.frame, move |point| {
        point.state.strike(Place::AtFrame, point.frame, None);
        point.mark_changed();
        match place {
            Place::Buffer => point.resize(0, Size::new(13, 1).unwrap()),
            Place::Resize => point.resize(0, Size::new(14, 1).unwrap()),
            _ => {}
        }
    });
    pipeline
}

/// Makes one fault and checks everything about it.
fn strike(frail: Frail, threads: usize) {
    let mut pipeline = frail_pipeline(&frail, threads);
    let handle = pipeline.handle();
    let place = frail.place;
    let tickets = match place {
        Place::Transaction => vec![
            handle.send("sound", |_| ()),
            handle.send("frail", |_| panic!("struck in Transaction")),
            handle.send("behind it", |_| ()),
        ],
        Place::Batch => {
            let batch = handle.batch().add("sound", |_| ()).add("frail", |_| panic!("struck in Batch"));
            vec![batch.add("never", |_| unreachable!()).send()]
        }
        _ => Vec::new(),
    };
    let fault = pipeline.run(frail.frame + 20).unwrap_err();
    assert_eq!(fault.component, place.component(), "{fault}");
    assert_eq!(fault.message, format!("struck in {place:?}"), "{fault}");
    if place.is_in_a_stage() {
        assert_eq!((fault.thread, fault.frame), (frail.thread, frail.frame), "{fault}");
    }
    if !matches!(place, Place::DisplayError | Place::Setup | Place::Termination) {
        assert!(fault.location.as_ref().unwrap().contains("pipeline_faults.rs"), "{fault}");
    }
    // Senders are told.
    let panicked = TransactionError::Panicked { name: "frail".into(), message: fault.message.clone() };
    let answers: Vec<_> = tickets.iter().map(|ticket| ticket.wait()).collect();
    match place {
        Place::Transaction => {
            assert_eq!(answers, [Ok(0), Err(panicked), Err(TransactionError::Stopped)]);
        }
        Place::Batch => assert_eq!(answers, [Err(panicked)]),
        _ => {}
    }
    // The pipeline is finished, clearly.
    assert_eq!(handle.send("late", |_| ()).wait(), Err(TransactionError::Stopped));
    assert_eq!(pipeline.run(1).unwrap_err(), fault);
    assert_eq!(pipeline.into_state().place, place);
}

#[test]
fn every_place_at_1_2_and_8_threads() {
    for place in PLACES {
        for threads in [1, 2, 8] {
            within_a_second(move || strike(Frail { place, frame: 3, thread: threads - 1 }, threads));
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn random_places_frames_and_threads(
        place in prop::sample::select(&PLACES[..]),
        frame in 0..30_u64,
        threads in 1..9_usize,
        thread: prop::sample::Index,
    ) {
        // Resize callbacks are called for the first frame in any case.
        let frame = if place == Place::Resize { frame.max(1) } else { frame };
        let thread = thread.index(threads);
        within_a_second(move || strike(Frail { place, frame, thread }, threads));
    }
}

#[test]
fn another_pipeline_of_the_process_goes_on() {
    let (frames, unharmed) = (Arc::new(AtomicUsize::new(0)), Frail { place: Place::Setup, frame: 0, thread: 0 });
    let counted = frames.clone();
    let mut other = Pipeline::new(unharmed, Config::with_threads(2)).unwrap();
    other.add_stage(stage("count", Balance::Imbalanced, |_: &Frame<'_, Frail>| ()));
    other.callbacks().serial_pre_render("count", move |_| {
        counted.fetch_add(1, Ordering::Relaxed);
    });
    let handle = other.handle();
    std::thread::scope(|scope| {
        let run = scope.spawn(|| other.run_until_stopped());
        for place in PLACES {
            within_a_second(move || strike(Frail { place, frame: 2, thread: 1 }, 2));
        }
        let before = frames.load(Ordering::Relaxed);
        while frames.load(Ordering::Relaxed) < before + 10 {
            std::thread::yield_now();
        }
        handle.stop().wait().unwrap();
        run.join().unwrap().unwrap();
    });
}

#[test]
fn termination_callbacks_hear_of_the_fault() {
    let mut pipeline = Pipeline::new(None::<Fault>, Config::with_threads(2)).unwrap();
    pipeline.callbacks().at_frame("frail", 2, |_| panic!("struck"));
    pipeline.callbacks().termination("listen", |point| *point.state = point.fault().cloned());
    let fault = pipeline.run(5).unwrap_err();
    assert_eq!(pipeline.into_state(), Some(fault));
}

#[test]
fn a_fault_while_idle_ends_the_run() {
    within_a_second(|| {
        for threads in [1, 4] {
            let config = Config { on_demand: true, ..Config::with_threads(threads) };
            let mut pipeline = Pipeline::<()>::new((), config).unwrap();
            let handle = pipeline.handle();
            pipeline.callbacks().idle("tired", |_| panic!("struck"));
            let fault = pipeline.run_until_stopped().unwrap_err();
            assert_eq!(fault.component, "callback tired");
            drop(handle);
        }
    });
}

#[test]
fn all_threads_may_fail_at_once() {
    within_a_second(|| {
        for threads in [1, 2, 8, 64] {
            let mut pipeline = Pipeline::<()>::new((), Config::with_threads(threads)).unwrap();
            pipeline.add_stage(stage("all", Balance::Balanced, |frame: &Frame<'_, ()>| assert!(frame.number < 3)));
            assert_eq!(pipeline.run(9).unwrap_err().component, "all");
        }
    });
}
