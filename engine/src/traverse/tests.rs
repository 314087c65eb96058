//! Every pixel is rendered, once, whatever the sizes; coarse pictures become fine; deadlines hold.

use std::sync::Mutex;
use std::time::{Duration, Instant};

use proptest::prelude::*;

use super::*;
use crate::balance::BalancerKind;

/// Counts how often each pixel of each channel was covered, and by what step; keeps pictures like a frame buffer.
struct Canvas {
    pictures: Vec<(Size, Mutex<Vec<usize>>)>,
    times: Mutex<Vec<Fragment>>,
    can_keep: bool,
    nap: Duration,
}

impl Canvas {
    fn new(sizes: &[Size]) -> Self {
        let picture = |&size: &Size| (size, Mutex::new(vec![0; size.pixels()]));
        Self {
            pictures: sizes.iter().map(picture).collect(),
            times: Mutex::default(),
            can_keep: false,
            nap: Duration::ZERO,
        }
    }

    /// The step that each pixel was last rendered with, if all are the same.
    fn step(&self) -> Option<usize> {
        let steps: Vec<_> = self.pictures.iter().flat_map(|picture| picture.1.lock().unwrap().clone()).collect();
        steps.iter().all(|&step| step == steps[0]).then(|| steps[0])
    }
}

impl FragmentRenderer for Canvas {
    fn render(&self, fragment: &Fragment) {
        let (size, steps) = &self.pictures[fragment.channel];
        assert!(fragment.x0 < fragment.x1 && fragment.x1 <= size.width(), "{fragment:?}");
        assert!(fragment.y0 < fragment.y1 && fragment.y1 <= size.height(), "{fragment:?}");
        std::thread::sleep(self.nap);
        self.times.lock().unwrap().push(*fragment);
        let mut steps = steps.lock().unwrap();
        for y in fragment.y0..fragment.y1 {
            steps[y * size.width()..][fragment.x0..fragment.x1].fill(fragment.step);
        }
    }

    fn keep(&self, _: &Fragment) -> bool {
        self.can_keep
    }
}

/// Runs one frame; returns whether another one would refine it, and how many pixels were rendered.
fn frame(traverser: &mut dyn ImageTraverser, canvas: &Canvas, threads: usize, changed: bool) -> (bool, usize) {
    let sizes: Vec<_> = canvas.pictures.iter().map(|picture| picture.0).collect();
    canvas.times.lock().unwrap().clear();
    traverser.begin(&sizes, threads, changed);
    let traverser = &*traverser;
    let more = std::thread::scope(|scope| {
        let threads: Vec<_> =
            (0..threads).map(|thread| scope.spawn(move || traverser.traverse(thread, canvas))).collect();
        threads.into_iter().fold(false, |more, thread| more | thread.join().unwrap())
    });
    (more, canvas.times.lock().unwrap().iter().map(Fragment::pixels).sum())
}

fn size() -> impl Strategy<Value = Size> {
    (1..80_usize, 1..80_usize).prop_map(|(width, height)| Size::new(width, height).unwrap())
}

fn balancer() -> impl Strategy<Value = BalancerKind> {
    prop::sample::select(vec!["auto", "work-queue", "work-queue:5", "by-cost", "cyclic", "static"])
        .prop_map(|name| name.parse().unwrap())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    #[test]
    fn every_pixel_of_every_channel_once(
        sizes in prop::collection::vec(size(), 0..4),
        (width, height) in (0..90_usize, 0..90_usize),
        balancer in balancer(),
        threads in 1..6_usize,
        kind in prop::sample::select(vec!["tiled", "progressive", "deadline:1e6"]),
    ) {
        let mut traverser = kind.parse::<TraverserKind>().unwrap().build(TileSize { width, height }, balancer);
        let mut canvas = Canvas::new(&sizes);
        let pixels: usize = sizes.iter().map(|size| size.pixels()).sum();
        let mut steps = Vec::new();
        for frames in 1.. {
            let (more, rendered) = frame(&mut *traverser, &canvas, threads, frames == 1);
            prop_assert_eq!(rendered, pixels, "each pixel is covered once in a frame");
            prop_assert!(canvas.times.lock().unwrap().iter().all(|fragment| fragment.samples() <= fragment.pixels()));
            prop_assert!(frames <= 5);
            if pixels > 0 {
                steps.push(canvas.step().unwrap());
            }
            if !more {
                break;
            }
        }
        prop_assert!(pixels == 0 || steps.last() == Some(&1), "{:?}", steps);
        prop_assert!(steps.windows(2).all(|pair| pair[1] < pair[0]), "{:?}", steps);
        // A finished picture is kept if it can be, and rendered again if not.
        let (more, rendered) = frame(&mut *traverser, &canvas, threads, false);
        prop_assert!(!more || kind.starts_with("deadline"));
        if kind != "deadline:1e6" {
            prop_assert_eq!(rendered, pixels);
        }
        while frame(&mut *traverser, &canvas, threads, false).0 && kind != "tiled" {}
        canvas.can_keep = true;
        let (more, rendered) = frame(&mut *traverser, &canvas, threads, false);
        prop_assert_eq!((more, rendered), (false, if kind == "tiled" { pixels } else { 0 }));
        // A change begins anew.
        let (_, rendered) = frame(&mut *traverser, &canvas, threads, true);
        prop_assert_eq!(rendered, pixels);
    }
}

#[test]
fn few_threads_become_many_and_few_again() {
    let mut tiled = Tiled::new(TileSize::default(), BalancerKind::default().build());
    for (threads, width) in [(1, 90), (40, 90), (40, 90), (2, 90), (40, 90), (2, 200), (40, 200), (40, 200), (1, 200)] {
        let picture = Size::new(width, 70).unwrap();
        let rendered = frame(&mut tiled, &Canvas::new(&[picture]), threads, false);
        assert_eq!(rendered, (false, picture.pixels()), "{threads} threads");
    }
}

#[test]
fn a_single_pixel_on_many_threads() {
    for kind in ["tiled", "progressive", "deadline:1e6"] {
        for balancer in [BalancerKind::default(), BalancerKind::ByCost, BalancerKind::Static] {
            let mut traverser = kind.parse::<TraverserKind>().unwrap().build(TileSize::default(), balancer);
            let canvas = Canvas::new(&[Size::new(1, 1).unwrap()]);
            assert_eq!(frame(&mut *traverser, &canvas, 32, true).1, 1);
        }
    }
}

/// A picture whose tile at the left in the middle is much dearer than all others.
#[derive(Default)]
struct Uneven(Mutex<Vec<Fragment>>);

impl FragmentRenderer for Uneven {
    fn render(&self, fragment: &Fragment) {
        if fragment.x0 < 16 && (32..48).contains(&fragment.y0) {
            std::thread::sleep(Duration::from_micros(30) * fragment.pixels() as u32);
        }
        self.0.lock().unwrap().push(*fragment);
    }
}

#[test]
fn what_is_dear_is_cut_and_begun_first() {
    let picture = Size::new(90, 70).unwrap();
    let mut tiled = Tiled::new(TileSize::default(), BalancerKind::ByCost.build());
    let uneven = Uneven::default();
    let mut frames = |threads: usize| {
        for _ in 0..6 {
            uneven.0.lock().unwrap().clear();
            tiled.begin(&[picture], threads, false);
            // One after the other: what is asked first is begun first.
            for thread in 0..threads {
                tiled.traverse(thread, &uneven);
            }
            let seen = uneven.0.lock().unwrap();
            assert_eq!(seen.iter().map(Fragment::pixels).sum::<usize>(), picture.pixels());
        }
        uneven.0.lock().unwrap().clone()
    };
    let dear = |fragment: &Fragment| fragment.x0 < 16 && (32..48).contains(&fragment.y0);
    let many = frames(8);
    assert_eq!(many.iter().filter(|fragment| dear(fragment)).count(), 16, "{many:?}");
    assert!(dear(&many[0]), "{many:?}");
    // For one thread it is in its place, and whole.
    let one = frames(1);
    assert_eq!(
        one.iter().position(dear).map(|place| one[place]),
        Some(Fragment { channel: 0, x0: 0, y0: 32, x1: 16, y1: 48, step: 1 })
    );
}

#[test]
fn the_null_traverser_renders_nothing() {
    let mut traverser = TraverserKind::Null.build(TileSize::default(), BalancerKind::default());
    assert_eq!(frame(&mut *traverser, &Canvas::new(&[Size::new(9, 9).unwrap()]), 3, true), (false, 0));
}

/// 100 tiles of 1 ms on two threads do not fit into 20 ms: the frame ends in time, and later frames do the rest.
#[test]
fn a_deadline_is_kept_and_the_rest_comes_later() {
    const LIMIT: Duration = Duration::from_millis(20);
    // Naps are long on a busy machine: one good picture of five is enough.
    let medians: Vec<Duration> = (0..5).map(|_| median_frame_of_a_deadline(LIMIT)).collect();
    assert!(medians.iter().any(|&median| median < LIMIT * 3 / 2), "median frames {medians:?}");
}

fn median_frame_of_a_deadline(limit: Duration) -> Duration {
    let tile = TileSize { width: 10, height: 10 };
    let mut traverser = TraverserKind::Deadline(limit).build(tile, BalancerKind::default());
    let mut canvas = Canvas::new(&[Size::new(100, 100).unwrap()]);
    (canvas.can_keep, canvas.nap) = (true, Duration::from_millis(1));
    let (mut times, mut frames) = (Vec::new(), 0);
    loop {
        let start = Instant::now();
        let (more, rendered) = frame(&mut *traverser, &canvas, 2, frames == 0);
        times.push(start.elapsed());
        frames += 1;
        assert!(rendered <= 40 * 100, "more tiles than fit into the time");
        assert!(frames < 5000, "it does not get any further");
        if !more {
            break;
        }
    }
    assert_eq!(canvas.step(), Some(1));
    assert!(frames >= 13, "500 ms of work in frames of 40 ms");
    times.sort();
    times[times.len() / 2]
}

/// When every frame brings a change and none has the time for a whole picture, all tiles still have their turn.
#[test]
fn a_deadline_starves_no_tile() {
    let mut traverser = TraverserKind::Deadline(Duration::from_millis(8))
        .build(TileSize { width: 10, height: 10 }, BalancerKind::default());
    let mut canvas = Canvas::new(&[Size::new(70, 70).unwrap()]);
    (canvas.can_keep, canvas.nap) = (true, Duration::from_millis(1));
    // Ten frames would do, if naps were never longer than they should be.
    let begun = |canvas: &Canvas| canvas.pictures[0].1.lock().unwrap().iter().all(|&step| step > 0);
    let frames = (0..500).take_while(|_| !begun(&canvas)).map(|_| frame(&mut *traverser, &canvas, 1, true)).count();
    assert!(begun(&canvas), "some tiles have not had their turn after {frames} frames");
}

#[test]
fn however_short_the_deadline_the_picture_gets_finished() {
    let mut traverser = TraverserKind::Deadline(Duration::from_nanos(1))
        .build(TileSize { width: 10, height: 10 }, BalancerKind::default());
    let mut canvas = Canvas::new(&[Size::new(50, 30).unwrap()]);
    canvas.can_keep = true;
    // 15 tiles in five steps, at least one in each frame.
    let frames = (0..75).take_while(|&number| frame(&mut *traverser, &canvas, 2, number == 0).0).count();
    assert_eq!(canvas.step(), Some(1), "after {frames} frames");
}

#[test]
fn unknown_traversers_list_the_known_ones() {
    assert_eq!("deadline:12.5".parse(), Ok(TraverserKind::Deadline(Duration::from_micros(12_500))));
    for name in ["", "deadline", "deadline:0", "deadline:-1", "deadline:NaN", "deadline:inf", "tile"] {
        let error = name.parse::<TraverserKind>().unwrap_err().to_string();
        assert!(error.contains("tiled, progressive, deadline:MILLISECONDS or null"), "{error}");
    }
}
