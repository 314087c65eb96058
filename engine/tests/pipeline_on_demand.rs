//! Interactive use: a pipeline that renders only when something changed, and callbacks in their order.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use mobula::balance::BalancerKind;
use mobula::image::Size;
use mobula::pipeline::{Balance, Config, Frame, Handle, Pipeline, stage};
use mobula::traverse::{RenderStage, TileSize, TraverserKind};

fn on_demand(threads: usize) -> Pipeline<Vec<String>> {
    let mut pipeline = Pipeline::new(Vec::new(), Config { on_demand: true, ..Config::with_threads(threads) }).unwrap();
    pipeline.add_channel("main", Size::new(20, 20).unwrap());
    pipeline
}

fn wait_for_frames<S: 'static>(handle: &Handle<S>, frames: u64) {
    wait(|| handle.progress().frames >= frames);
}

/// Waits for something. The limit is for what never comes, not for a machine that is slow.
fn wait(mut done: impl FnMut() -> bool) {
    let start = Instant::now();
    while !done() {
        assert!(start.elapsed() < Duration::from_secs(60), "it never comes");
        std::thread::sleep(Duration::from_millis(1));
    }
}

#[test]
fn nothing_is_rendered_while_nothing_changes() {
    for threads in [1, 3] {
        let mut pipeline = on_demand(threads);
        let shown = Arc::new(AtomicUsize::new(0));
        let count = shown.clone();
        pipeline.add_stage(stage("render", Balance::Dynamic, |_: &Frame<'_, Vec<String>>| ()));
        pipeline.add_stage(stage("show", Balance::Imbalanced, move |_: &Frame<'_, Vec<String>>| {
            count.fetch_add(1, Ordering::Relaxed);
        }));
        let handle = pipeline.handle();
        std::thread::scope(|scope| {
            let run = scope.spawn(|| pipeline.run_until_stopped().unwrap());
            for round in 1..=4 {
                // The last frame is shown before the sleep.
                wait(|| shown.load(Ordering::Relaxed) as u64 == round);
                std::thread::sleep(Duration::from_millis(30));
                assert_eq!(handle.progress().frames, round, "one frame for each change");
                handle.at_barrier("look", |point| assert!(point.state.len() < 9)).wait().unwrap();
                handle.send("change", |state| state.push("x".into()));
            }
            wait_for_frames(&handle, 5);
            handle.set_threads(2).unwrap();
            wait_for_frames(&handle, 6);
            assert_eq!(handle.progress().threads, 2);
            handle.resize(0, Size::new(5, 5).unwrap());
            wait_for_frames(&handle, 7);
            handle.stop().wait().unwrap();
            assert_eq!(run.join().unwrap().frames, 7);
        });
    }
}

#[test]
fn it_ends_when_nobody_can_change_anything_any_more() {
    let mut pipeline = on_demand(2);
    let handle = pipeline.handle();
    std::thread::scope(|scope| {
        let run = scope.spawn(|| pipeline.run_until_stopped().unwrap());
        handle.send("last", |state| state.push("last".into())).wait().unwrap();
        std::thread::sleep(Duration::from_millis(10));
        let clone = handle.clone();
        drop(handle);
        std::thread::sleep(Duration::from_millis(10));
        drop(clone);
        run.join().unwrap();
    });
    assert_eq!(pipeline.into_state(), ["last"]);
}

#[test]
fn idle_callbacks_and_timers_run_while_asleep() {
    let mut pipeline = Pipeline::new(
        0_usize,
        Config { on_demand: true, idle_interval: Duration::from_millis(2), ..Config::with_threads(2) },
    )
    .unwrap();
    pipeline.callbacks().idle("idle", |point| {
        *point.state += 1;
        match *point.state {
            5 => point.mark_changed(),
            20 => point.stop(),
            _ => {}
        }
    });
    let report = pipeline.run_until_stopped().unwrap();
    assert_eq!(report.frames, 2, "one at the start, one for the change");
    assert_eq!(pipeline.into_state(), 20);

    let mut pipeline = on_demand(1);
    pipeline.callbacks().at_time("end", Duration::from_millis(30), |point| point.stop());
    assert!(pipeline.run_until_stopped().unwrap().seconds >= 0.03);
}

#[test]
fn animation_keeps_a_pipeline_awake_until_it_is_removed() {
    let mut pipeline = on_demand(2);
    let id = pipeline.callbacks().parallel_animation("move", |worker| assert!(worker.thread < worker.threads));
    let handle = pipeline.handle();
    std::thread::scope(|scope| {
        let run = scope.spawn(|| pipeline.run_until_stopped().unwrap());
        wait_for_frames(&handle, 20);
        handle.at_barrier("no more", move |point| point.callbacks().remove(id)).wait().unwrap();
        wait(|| {
            let frames = handle.progress().frames;
            std::thread::sleep(Duration::from_millis(30));
            handle.progress().frames == frames
        });
        handle.stop();
        run.join().unwrap();
    });
}

#[test]
fn callbacks_run_in_their_order() {
    let mut pipeline = on_demand(3);
    let parallel = Arc::new(Mutex::new(Vec::new()));
    let callbacks = pipeline.callbacks();
    let log = |what: &'static str| {
        move |point: &mut mobula::pipeline::SafePoint<'_, Vec<String>>| {
            point.state.push(format!("{what} {}", point.frame));
        }
    };
    callbacks.termination("log", log("termination"));
    callbacks.serial_pre_render("log", log("pre-render"));
    callbacks.changed("log", log("changed"));
    callbacks.resize("log", |point, channel, size| point.state.push(format!("resize {channel} {size}")));
    callbacks.serial_animation("log", log("animation"));
    callbacks.at_frame("log", 1, log("at frame"));
    callbacks.setup("log", log("setup"));
    let log = parallel.clone();
    callbacks.parallel_animation("log", move |worker| {
        // The serial animation of this frame is over, its pre-render callbacks have not begun.
        assert_eq!(worker.state.last().unwrap(), &format!("changed {}", worker.frame));
        log.lock().unwrap().push((worker.frame, "animation", worker.thread, worker.share(10)));
    });
    let log = parallel.clone();
    callbacks.parallel_pre_render("log", move |worker| {
        assert_eq!(worker.state.last().unwrap(), &format!("pre-render {}", worker.frame));
        log.lock().unwrap().push((worker.frame, "pre-render", worker.thread, worker.share(10)));
    });
    let handle = pipeline.handle();
    handle.send("log", |state| state.push("transaction".into()));
    pipeline.run(2).unwrap();
    let expected = [
        "setup 0",
        "transaction",
        "animation 0",
        "resize 0 20x20",
        "changed 0",
        "pre-render 0", //
        "at frame 1",
        "animation 1",
        "changed 1",
        "pre-render 1", //
        "termination 2",
    ];
    assert_eq!(pipeline.into_state(), expected);
    let mut parallel = parallel.lock().unwrap().clone();
    assert!(parallel.is_sorted_by_key(|entry| (entry.0, entry.1)), "{parallel:?}");
    parallel.sort_by_key(|entry| (entry.0, entry.1, entry.2));
    let shares = [(0, 0..4), (1, 4..7), (2, 7..10)];
    let expected: Vec<_> = [(0, "animation"), (0, "pre-render"), (1, "animation"), (1, "pre-render")]
        .into_iter()
        .flat_map(|(frame, what)| shares.clone().map(|(thread, share)| (frame, what, thread, share)))
        .collect();
    assert_eq!(parallel, expected);
}

#[test]
fn film_time_goes_from_frame_to_frame() {
    let config = Config { frame_time: Some(Duration::from_millis(40)), ..Config::with_threads(2) };
    let mut pipeline = Pipeline::new(Vec::<Duration>::new(), config).unwrap();
    pipeline.callbacks().serial_animation("time", |point| point.state.push(point.time));
    pipeline.run(3).unwrap();
    pipeline.run(2).unwrap();
    assert_eq!(pipeline.into_state(), [0, 40, 80, 120, 160].map(Duration::from_millis));
}

/// The steps of the frames that a progressive traverser renders, until nothing is left to be refined.
#[test]
fn a_progressive_picture_is_refined_while_nothing_changes() {
    for kind in ["progressive", "deadline:10000"] {
        let mut pipeline = on_demand(3);
        let traverser = kind.parse::<TraverserKind>().unwrap();
        let traverser = traverser.build(TileSize { width: 7, height: 6 }, BalancerKind::default());
        let steps = Arc::new(Mutex::new(Vec::new()));
        let log = steps.clone();
        pipeline.add_stage(RenderStage::new(traverser, move |frame: &Frame<'_, Vec<String>>, fragment, buffer| {
            log.lock().unwrap().push((frame.number, fragment.step));
            let colour = fragment.step as u32 + 100 * frame.state.len() as u32;
            buffer.fill(fragment.x0, fragment.y0, fragment.x1, fragment.y1, colour);
        }));
        let pictures = Arc::new(Mutex::new(Vec::new()));
        let log = pictures.clone();
        pipeline.add_stage(stage("show", Balance::Imbalanced, move |frame: &Frame<'_, Vec<String>>| {
            let colours: Vec<_> = frame.channels()[0].buffer.pixels().collect();
            assert!(colours.iter().all(|&colour| colour == colours[0]));
            log.lock().unwrap().push(colours[0]);
        }));
        let handle = pipeline.handle();
        std::thread::scope(|scope| {
            let run = scope.spawn(|| pipeline.run_until_stopped().unwrap());
            // Once it is refined to the end nothing more may come.
            let settle = |finest: u32| {
                wait(|| pictures.lock().unwrap().last() == Some(&finest));
                std::thread::sleep(Duration::from_millis(30));
            };
            settle(1);
            handle.send("change", |state| state.push("x".into()));
            settle(101);
            handle.stop();
            run.join().unwrap();
        });
        let pictures = pictures.lock().unwrap();
        let (first, second) = pictures.split_at(pictures.iter().position(|&colour| colour > 100).unwrap());
        assert_eq!(first.last(), Some(&1), "{kind}: refined to the end, {pictures:?}");
        assert_eq!(second.last(), Some(&101), "{kind}: refined to the end, {pictures:?}");
        assert!(second[1..].iter().zip(second).all(|(next, last)| next < last), "{kind}: {pictures:?}");
        if kind == "progressive" {
            assert_eq!(*pictures, [8, 4, 2, 1, 108, 104, 102, 101]);
        }
        assert!(steps.lock().unwrap().len() >= 12 * 5);
    }
}

#[test]
fn a_frame_that_is_given_up_is_no_picture() {
    for threads in [1, 3] {
        let mut pipeline = Pipeline::new((), Config::with_threads(threads)).unwrap();
        pipeline.add_channel("main", Size::new(20, 20).unwrap());
        // Frame 2 never ends by itself.
        pipeline.add_stage(stage("render", Balance::Dynamic, |frame: &Frame<'_, ()>| {
            while frame.number == 2 && !frame.halted() {
                std::thread::sleep(Duration::from_millis(1));
            }
        }));
        let shown = Arc::<Mutex<Vec<u64>>>::default();
        let log = Arc::clone(&shown);
        pipeline.add_stage(stage("show", Balance::Imbalanced, move |frame: &Frame<'_, ()>| {
            log.lock().unwrap().push(frame.number);
        }));
        let handle = pipeline.handle();
        std::thread::scope(|scope| {
            let run = scope.spawn(|| pipeline.run(10).unwrap());
            wait(|| shown.lock().unwrap().contains(&1));
            handle.halt();
            assert_eq!(run.join().unwrap().frames, 2);
        });
        assert_eq!(pipeline.picture(0).unwrap().0, 1, "the newest picture is of a frame that was finished");
        // After the end there is nothing to give up, and the next run begins with the frame that was not rendered.
        handle.halt();
        pipeline.callbacks().at_frame("end", 2, |point| point.stop());
        assert_eq!(pipeline.run(10).unwrap().frames, 0);
        assert_eq!(*shown.lock().unwrap(), [0, 1]);
    }
}

#[test]
fn an_idle_pipeline_that_is_given_up_ends() {
    let mut pipeline = on_demand(2);
    pipeline.add_stage(stage("render", Balance::Dynamic, |_: &Frame<'_, Vec<String>>| ()));
    let handle = pipeline.handle();
    std::thread::scope(|scope| {
        let run = scope.spawn(|| pipeline.run_until_stopped().unwrap());
        wait_for_frames(&handle, 1);
        std::thread::sleep(Duration::from_millis(20));
        handle.halt();
        assert_eq!(run.join().unwrap().frames, 1);
    });
}
