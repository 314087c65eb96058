//! Transactions: never torn, in order, never lost silently.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Barrier, Mutex};
use std::time::Duration;

use mobula::image::Size;
use mobula::pipeline::{Balance, Config, Frame, Pipeline, Ticket, TransactionError, stage};
use proptest::prelude::*;

/// A state that is consistent only if all parts have one version.
#[derive(Debug, Default)]
struct World {
    parts: [u64; 32],
    log: Vec<(usize, usize)>,
}

impl World {
    /// Changes the parts one after the other, slowly enough to be caught at it.
    fn change(&mut self, sender: usize, number: usize) {
        let version = self.parts[0] + 1;
        for (index, part) in self.parts.iter_mut().enumerate() {
            *part = version;
            if index == 16 {
                std::thread::yield_now();
            }
        }
        self.log.push((sender, number));
    }

    fn version(&self) -> u64 {
        assert!(self.parts.iter().all(|&part| part == self.parts[0]), "a torn state: {:?}", self.parts);
        self.parts[0]
    }
}

/// The version that each frame was rendered with: all threads of a frame must see one and the same.
#[derive(Clone, Default)]
struct Versions(Arc<Mutex<Vec<u64>>>);

impl Versions {
    fn check(&self, frame: &Frame<'_, World>) {
        let version = frame.state.version();
        std::thread::yield_now();
        assert_eq!(frame.state.version(), version);
        let mut versions = self.0.lock().unwrap();
        let place = frame.number as usize;
        match versions.get(place) {
            Some(&other) => assert_eq!(other, version, "two threads of frame {place} see different states"),
            None => {
                assert_eq!(versions.len(), place);
                versions.push(version);
            }
        }
    }
}

fn watched(threads: usize) -> (Pipeline<World>, Versions) {
    let mut pipeline = Pipeline::new(World::default(), Config::with_threads(threads)).unwrap();
    pipeline.add_channel("main", Size::new(8, 8).unwrap());
    let versions = Versions::default();
    let watch = versions.clone();
    pipeline.add_stage(stage("watch", Balance::Balanced, move |frame: &Frame<'_, World>| watch.check(frame)));
    (pipeline, versions)
}

#[derive(Clone, Debug)]
enum Act {
    Send,
    Batch(usize),
    Threads(usize),
    Resize(usize, usize),
    Wait,
    Pause,
}

fn act() -> impl Strategy<Value = Act> {
    prop_oneof![
        6 => Just(Act::Send),
        2 => (1..5_usize).prop_map(Act::Batch),
        1 => (1..9_usize).prop_map(Act::Threads),
        1 => (1..20_usize, 1..20_usize).prop_map(|(width, height)| Act::Resize(width, height)),
        1 => Just(Act::Wait),
        1 => Just(Act::Pause),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn a_storm_never_tears_a_frame(
        scripts in prop::collection::vec(prop::collection::vec(act(), 0..40), 1..5),
        threads in 1..5_usize,
    ) {
        let (mut pipeline, versions) = watched(threads);
        let handles: Vec<_> = scripts.iter().map(|_| pipeline.handle()).collect();
        let stopper = pipeline.handle();
        let counts = std::thread::scope(|scope| {
            let senders: Vec<_> = scripts.iter().zip(handles).enumerate().map(|(sender, (script, handle))| {
                scope.spawn(move || {
                    let (mut sent, mut last) = (0, None::<Ticket>);
                    for act in script {
                        match *act {
                            Act::Send => {
                                let number = sent;
                                sent += 1;
                                last = Some(handle.send("change", move |world| world.change(sender, number)));
                            }
                            Act::Batch(count) => {
                                let mut batch = handle.batch();
                                for _ in 0..count {
                                    let number = sent;
                                    sent += 1;
                                    batch = batch.add("change", move |world: &mut World| world.change(sender, number));
                                }
                                last = Some(batch.send());
                            }
                            Act::Threads(threads) => last = Some(handle.set_threads(threads).unwrap()),
                            Act::Resize(width, height) => last = Some(handle.resize(0, Size::new(width, height).unwrap())),
                            Act::Wait => {
                                if let Some(ticket) = last.take() {
                                    ticket.wait().unwrap();
                                }
                            }
                            Act::Pause => std::thread::sleep(Duration::from_micros(200)),
                        }
                    }
                    sent
                })
            }).collect();
            let run = scope.spawn(|| pipeline.run_until_stopped().unwrap());
            let counts: Vec<usize> = senders.into_iter().map(|sender| sender.join().unwrap()).collect();
            stopper.stop();
            run.join().unwrap();
            counts
        });
        let versions = versions.0.lock().unwrap();
        prop_assert!(versions.is_sorted());
        let world = pipeline.into_state();
        prop_assert_eq!(world.version(), counts.iter().sum::<usize>() as u64);
        for (sender, &count) in counts.iter().enumerate() {
            let order: Vec<_> = world.log.iter().filter(|entry| entry.0 == sender).map(|entry| entry.1).collect();
            prop_assert_eq!(order, (0..count).collect::<Vec<_>>(), "in the order in which they were sent");
        }
    }
}

#[test]
fn a_ticket_names_the_first_frame_that_shows_the_change() {
    let (mut pipeline, versions) = watched(2);
    let handle = pipeline.handle();
    std::thread::scope(|scope| {
        let run = scope.spawn(|| pipeline.run_until_stopped().unwrap());
        for number in 0..20 {
            let frame = handle.send("change", move |world| world.change(0, number)).wait().unwrap();
            let later = handle.send("nothing", |_| ()).wait().unwrap();
            assert!(later >= frame);
            let versions = versions.0.lock().unwrap();
            assert!(
                versions.iter().enumerate().all(|(at, &version)| (version > number as u64) == (at as u64 >= frame))
            );
        }
        handle.stop().wait().unwrap();
        run.join().unwrap();
    });
}

#[test]
fn a_batch_is_one_step() {
    let (mut pipeline, versions) = watched(3);
    let handle = pipeline.handle();
    std::thread::scope(|scope| {
        let run = scope.spawn(|| pipeline.run_until_stopped().unwrap());
        for _ in 0..30 {
            let mut batch = handle.batch();
            for number in 0..7 {
                batch = batch.add("change", move |world: &mut World| world.change(0, number));
            }
            drop(batch.send());
        }
        handle.stop().wait().unwrap();
        run.join().unwrap();
    });
    assert!(versions.0.lock().unwrap().iter().all(|version| version % 7 == 0));
    assert_eq!(pipeline.into_state().version(), 210);
}

#[test]
fn what_is_sent_before_the_run_shows_in_its_first_frame() {
    let (mut pipeline, versions) = watched(2);
    let handle = pipeline.handle();
    let ticket = handle.send("early", |world| world.change(0, 0));
    assert_eq!(ticket.poll(), None);
    pipeline.run(3).unwrap();
    assert_eq!(ticket.wait(), Ok(0));
    assert_eq!(*versions.0.lock().unwrap(), [1, 1, 1]);
}

#[test]
fn what_comes_too_late_is_told_so() {
    let (mut pipeline, _) = watched(2);
    let handle = pipeline.handle();
    assert!(!handle.is_stopped());
    pipeline.run(3).unwrap();
    assert!(handle.is_stopped());
    assert_eq!(handle.send("late", |_| ()).wait(), Err(TransactionError::Stopped));
    let kept = handle.clone();
    drop(pipeline);
    assert_eq!(kept.batch().add("later", |_| ()).send().wait(), Err(TransactionError::Stopped));

    let (pipeline, _) = watched(1);
    let handle = pipeline.handle();
    let ticket = handle.send("queued", |_| ());
    let state = pipeline.into_state();
    assert_eq!((ticket.wait(), state.version()), (Err(TransactionError::Stopped), 0));
}

#[test]
fn no_transaction_is_lost_when_the_end_comes_in_between() {
    for round in 0..30 {
        let (mut pipeline, _) = watched(1 + round % 3);
        let start = Barrier::new(4);
        let stopper = pipeline.handle();
        let carried_out: usize = std::thread::scope(|scope| {
            let senders: Vec<_> = (0..3)
                .map(|sender| {
                    let (handle, start) = (pipeline.handle(), &start);
                    scope.spawn(move || {
                        start.wait();
                        let mut tickets = Vec::new();
                        while !handle.is_stopped() {
                            let number = tickets.len();
                            tickets.push(handle.send("change", move |world| world.change(sender, number)));
                            if number % 16 == 15 {
                                let _ = tickets[number].wait(); // or the queue would grow without bounds
                            }
                        }
                        // Every ticket has an answer, and the refused ones are the last.
                        let answers: Vec<_> = tickets.iter().map(Ticket::wait).collect();
                        assert!(answers.is_sorted_by_key(|answer| answer.is_err()));
                        answers.iter().filter(|answer| answer.is_ok()).count()
                    })
                })
                .collect();
            let run = scope.spawn(|| pipeline.run_until_stopped().unwrap());
            start.wait();
            std::thread::sleep(Duration::from_micros(300 * round as u64));
            stopper.stop();
            run.join().unwrap();
            senders.into_iter().map(|sender| sender.join().unwrap()).sum()
        });
        assert_eq!(pipeline.into_state().log.len(), carried_out);
    }
}

#[test]
fn rendering_never_holds_up_a_sender() {
    let mut pipeline = Pipeline::new((), Config::with_threads(1)).unwrap();
    let (rendering, sent) = (Arc::new(AtomicBool::new(false)), Arc::new(AtomicU64::new(0)));
    let (inside, done) = (rendering.clone(), sent.clone());
    pipeline.add_stage(stage("long", Balance::Balanced, move |_: &Frame<'_, ()>| {
        inside.store(true, Ordering::SeqCst);
        // The frame ends only when the sender is done: were it held up, neither would end.
        while done.load(Ordering::SeqCst) < 1000 {
            std::thread::yield_now();
        }
    }));
    let handle = pipeline.handle();
    std::thread::scope(|scope| {
        scope.spawn(move || {
            while !rendering.load(Ordering::SeqCst) {
                std::thread::yield_now();
            }
            for _ in 0..1000 {
                drop(handle.send("change", |_| ()));
                sent.fetch_add(1, Ordering::SeqCst);
            }
        });
        assert_eq!(pipeline.run(2).unwrap().transactions, 1000);
    });
}

#[test]
fn what_lies_beyond_all_times_is_waited_for() {
    let (mut pipeline, _) = watched(2);
    let handle = pipeline.handle();
    std::thread::scope(|scope| {
        let waiter = scope.spawn(move || handle.send("change", |world| world.change(0, 0)).wait_for(Duration::MAX));
        std::thread::sleep(Duration::from_millis(50));
        pipeline.run(2).unwrap();
        assert!(waiter.join().unwrap().is_some());
    });
}

#[test]
fn to_wait_on_a_render_thread_is_an_error() {
    let mut pipeline = Pipeline::new(Vec::new(), Config::with_threads(2)).unwrap();
    type Answer = Result<u64, TransactionError>;
    let inside = pipeline.handle();
    let waited = Arc::new(Mutex::new(Vec::new()));
    let note = Arc::clone(&waited);
    pipeline.add_channel("main", Size::new(8, 8).unwrap());
    pipeline.add_stage(stage("waits", Balance::Balanced, move |_: &Frame<'_, Vec<Answer>>| {
        let ticket = inside.send("from a stage", |_| ());
        note.lock().unwrap().extend([Some(ticket.wait()), ticket.wait_for(Duration::MAX)]);
    }));
    let handle = pipeline.handle();
    let sender = pipeline.handle();
    let late = handle.send("waits", move |answers: &mut Vec<Answer>| {
        answers.push(sender.send("from a transaction", |_| ()).wait());
    });
    let sender = pipeline.handle();
    pipeline.callbacks().parallel_pre_render("waits", move |_| {
        assert_eq!(sender.send("from a callback", |_| ()).wait(), Err(TransactionError::InVain));
    });
    // Another pipeline's thread may be waited for.
    let mut other = Pipeline::new(0, Config::with_threads(1)).unwrap();
    other.add_channel("main", Size::new(8, 8).unwrap());
    let handle = other.handle();
    pipeline.callbacks().at_frame("waits for the other", 1, move |_| {
        assert!(handle.send("from outside", |_| ()).wait().is_ok());
        handle.stop();
    });
    std::thread::scope(|scope| {
        scope.spawn(|| other.run_until_stopped().unwrap());
        pipeline.run(3).unwrap();
    });
    assert_eq!(late.wait(), Ok(0));
    assert!(waited.lock().unwrap().iter().all(|answer| *answer == Some(Err(TransactionError::InVain))));
    assert_eq!(pipeline.into_state(), [Err(TransactionError::InVain)]);
}

#[test]
fn to_wait_where_nobody_runs_the_pipeline_is_an_error() {
    let (mut pipeline, _) = watched(1);
    let handle = pipeline.handle();
    let ticket = handle.send("change", |world| world.change(0, 0));
    assert_eq!(ticket.wait_for(Duration::from_millis(1)), None);
    assert_eq!(ticket.wait(), Err(TransactionError::InVain));
    assert_eq!(ticket.wait_for(Duration::MAX), Some(Err(TransactionError::InVain)));
    // It is still queued.
    pipeline.run(1).unwrap();
    assert_eq!(ticket.wait(), Ok(0));
}

#[test]
fn what_panics_when_it_is_refused_is_a_fault_and_all_are_told() {
    struct Bomb(&'static str);
    impl Drop for Bomb {
        fn drop(&mut self) {
            std::panic::panic_any(self.0);
        }
    }
    let (mut pipeline, _) = watched(2);
    let (handle, sender) = (pipeline.handle(), pipeline.handle());
    let tickets = Arc::new(Mutex::new(Vec::new()));
    let keep = Arc::clone(&tickets);
    let stop = handle.at_barrier("stop", move |point| {
        point.stop();
        let bomb = Bomb("it was dropped");
        let mut kept = keep.lock().unwrap();
        kept.push(sender.send("before", |_| ()));
        kept.push(sender.send("bomb", move |_| drop(bomb)));
        kept.push(sender.send("behind", |_| ()));
    });
    let fault = pipeline.run(3).unwrap_err();
    assert_eq!((fault.component.as_str(), fault.message.as_str()), ("transaction bomb", "it was dropped"));
    assert_eq!(stop.wait(), Ok(0));
    for ticket in tickets.lock().unwrap().iter() {
        assert_eq!(ticket.wait(), Err(TransactionError::Stopped));
    }
    // And when nobody runs it any more.
    let bomb = Bomb("late");
    assert_eq!(handle.send("late bomb", move |_| drop(bomb)).wait(), Err(TransactionError::Stopped));
    let (pipeline, _) = watched(1);
    let (handle, bomb) = (pipeline.handle(), Bomb("never"));
    let ticket = handle.send("bomb", move |_| drop(bomb));
    let behind = handle.send("behind", |_| ());
    drop(pipeline);
    assert_eq!([ticket.wait(), behind.wait()], [Err(TransactionError::Stopped), Err(TransactionError::Stopped)]);
}
