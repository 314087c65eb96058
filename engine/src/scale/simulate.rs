//! The projection: a discrete-event simulation of frames on more processors than there are.
//!
//! What deals out the tiles is the real thing: each simulated processor asks the load balancer for assignments in the
//! order of simulated time, what it renders is noted as the tiled traverser notes it, and the next frame is planned from
//! that. The costs are measured ones ([`Costs`]). What is assumed, and printed with the results:
//!
//! - Processors are equal and have caches and memory bandwidth of their own: a fragment costs what it costs alone.
//! - Taking an assignment costs the balancer's own arithmetic, at any time, and in addition the cache lines that it goes
//!   to, each of which only one processor has at a time: askers queue for it. One hand-over costs what it costs between
//!   two threads.
//! - At the barrier processors queue for the counter of their group, and the last of each group for that of all. Then it
//!   costs what a crossing of two costs and the serial part; the gates of the groups are opened one after the other, and
//!   the processors of a group see theirs one after the other.
//! - One processor shows the previous picture before it renders; another one plans the next frame, where that is done.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap, HashMap};
use std::time::Instant;

use super::median;
use crate::balance::LoadBalancer;
use crate::image::Size;
use crate::pipeline::barrier::GROUP;
use crate::traverse::{Deal, Fragment, TileSize};

/// What rendering each rectangle of a frame costs, in seconds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrameCosts(HashMap<[usize; 4], f64>);

/// What the parts of a frame cost, in seconds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Costs {
    /// Frames that follow each other, at least one.
    pub frames: Vec<FrameCosts>,
    /// Crossing the barrier with two threads.
    pub crossing: f64,
    /// The serial part at the barrier.
    pub serial: f64,
    /// The display of one picture.
    pub display: f64,
    /// Passing a cache line from one thread to another that writes it too.
    pub handover: f64,
}

/// How the frames are cut and dealt out.
#[derive(Clone, Copy, Debug)]
pub struct Dealt<'a> {
    /// Size of the picture.
    pub size: Size,
    /// Size of a tile.
    pub tile: TileSize,
    /// The load balancer; another one of its kind is used.
    pub balancer: &'a dyn LoadBalancer,
}

/// Simulated frames.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Projection {
    /// How many processors.
    pub processors: usize,
    /// From barrier to barrier, on average.
    pub seconds: f64,
    /// Times faster than one processor.
    pub speedup: f64,
    /// Speed-up per processor.
    pub efficiency: f64,
    /// Where the rest went.
    pub lost: Lost,
}

/// Shares of all processors' time in which nothing was rendered that one processor would not render too; with the useful
/// share they add up to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lost {
    /// Waiting for the last to finish.
    pub imbalance: f64,
    /// Rendering in smaller pieces what is cheaper in one.
    pub cutting: f64,
    /// Crossing the barrier.
    pub barrier: f64,
    /// Waiting while one works at the barrier.
    pub serial: f64,
    /// Asking the load balancer, and waiting for it.
    pub balancer: f64,
    /// Displaying, and planning the next frame.
    pub single: f64,
}

impl FrameCosts {
    /// Sets what a rectangle costs.
    pub fn set(&mut self, fragment: &Fragment, seconds: f64) {
        self.0.insert(key(fragment), seconds);
    }

    /// What each rectangle of this width costs, in no order.
    pub fn of_width(&self, width: usize) -> impl Iterator<Item = f64> {
        self.0.iter().filter(move |(place, _)| place[2] - place[0] == width).map(|(_, &seconds)| seconds)
    }

    fn get(&self, fragment: &Fragment) -> f64 {
        *self.0.get(&key(fragment)).expect("all parts of tiles have been measured")
    }
}

fn key(&Fragment { x0, y0, x1, y1, .. }: &Fragment) -> [usize; 4] {
    [x0, y0, x1, y1]
}

impl Costs {
    /// As it would be with another cost of passing a cache line; a crossing of two passes three.
    #[must_use]
    pub fn with_handover(&self, handover: f64) -> Self {
        let crossing = self.crossing + 3.0 * (handover - self.handover);
        Self { handover, crossing, ..self.clone() }
    }
}

/// Plays the frames on one processor and on so many. A balancer that wants costs has the first half of the frames to learn
/// them; the rest counts.
pub fn project(costs: &Costs, dealt: &Dealt<'_>, processors: usize) -> Projection {
    let alone = play(costs, dealt, 1);
    let mut projection = play(costs, dealt, processors);
    projection.speedup = alone.seconds / projection.seconds;
    projection.efficiency = projection.speedup / processors as f64;
    projection
}

fn play(costs: &Costs, dealt: &Dealt<'_>, processors: usize) -> Projection {
    let mut deal = Deal::new(dealt.tile, dealt.balancer.another());
    let take = take_cost(&mut deal, dealt, processors);
    let mut counted: Vec<Projection> = Vec::new();
    for (number, frame) in costs.frames.iter().enumerate() {
        deal.begin(&[dealt.size], processors);
        let played = Frame { costs, frame, deal: &deal, processors }.play(take);
        if number >= costs.frames.len() / 2 {
            counted.push(played);
        }
    }
    let mean = |part: &dyn Fn(&Projection) -> f64| counted.iter().map(part).sum::<f64>() / counted.len() as f64;
    Projection {
        processors,
        seconds: mean(&|at| at.seconds),
        lost: Lost {
            imbalance: mean(&|at| at.lost.imbalance),
            cutting: mean(&|at| at.lost.cutting),
            barrier: mean(&|at| at.lost.barrier),
            serial: mean(&|at| at.lost.serial),
            balancer: mean(&|at| at.lost.balancer),
            single: mean(&|at| at.lost.single),
        },
        ..Projection::default()
    }
}

/// Seconds that the balancer's own arithmetic takes for one assignment.
fn take_cost(deal: &mut Deal, dealt: &Dealt<'_>, processors: usize) -> f64 {
    let mut costs: Vec<f64> = (0..9)
        .map(|_| {
            deal.begin(&[dealt.size], processors);
            let (mut asked, start) = (0_u32, Instant::now());
            for thread in 0..processors {
                while std::hint::black_box(deal.next(thread, &mut |_| ())).is_some() {
                    asked += 1;
                }
                asked += 1;
            }
            start.elapsed().as_secs_f64() / f64::from(asked)
        })
        .collect();
    median(&mut costs)
}

struct Frame<'a> {
    costs: &'a Costs,
    frame: &'a FrameCosts,
    deal: &'a Deal,
    processors: usize,
}

/// A cache line that one processor has at a time: when it is free again.
#[derive(Clone, Copy, Default)]
struct Line(f64);

impl Line {
    /// When a processor that asks at `time` has it.
    fn pass(&mut self, time: f64, handover: f64) -> f64 {
        self.0 = self.0.max(time) + handover;
        self.0
    }
}

impl Frame<'_> {
    fn play(&self, take: f64) -> Projection {
        let &Self { costs, frame, deal, processors } = self;
        let handover = if processors > 1 { costs.handover } else { 0.0 };
        let mut now = vec![0.0; processors];
        now[0] = costs.display;
        for (processor, now) in now.iter_mut().enumerate() {
            // Planning is really done, more than once: the median is not disturbed by what else the machine does.
            let plan = || {
                let start = Instant::now();
                deal.plan(processor).then(|| start.elapsed().as_secs_f64())
            };
            let mut times: Vec<f64> = (0..5).map_while(|_| plan()).collect();
            *now += median(&mut times);
        }
        let single: f64 = now.iter().sum();
        // By the time in nanoseconds * 2^10, so that times order and compare; ties by processor.
        let ticks = |seconds: f64| (seconds * 1e9 * 1024.0) as u64;
        let mut events: BinaryHeap<_> =
            now.iter().enumerate().map(|(processor, &now)| Reverse((ticks(now), processor))).collect();
        let mut lines = BTreeMap::<usize, Line>::new();
        let (mut asking, mut working) = (0.0, 0.0);
        while let Some(Reverse((_, processor))) = events.pop() {
            let asked = now[processor];
            let mut got = asked;
            let items = deal.next(processor, &mut |line| got = lines.entry(line).or_default().pass(got, handover));
            got += take;
            asking += got - asked;
            now[processor] = got;
            for item in items.clone().into_iter().flatten() {
                let cost = deal.fragment(item).map_or(0.0, |fragment| frame.get(&fragment));
                deal.note(item, cost as f32);
                working += cost;
                now[processor] += cost;
            }
            if items.is_some() {
                events.push(Reverse((ticks(now[processor]), processor)));
            }
        }
        let last = now.iter().copied().fold(0.0, f64::max);
        let ended: f64 = now.iter().sum();
        debug_assert!((single + asking + working - ended).abs() <= 1e-9 * ended.max(1e-3), "all time is accounted");
        let barrier = if processors > 1 { self.barrier(&now) - last } else { 0.0 };
        let (count, seconds) = (processors as f64, last + barrier + costs.serial);
        let whole: f64 = deal.whole_tiles().map(|tile| frame.get(&tile)).sum();
        let share = |time: f64| time / (seconds * count).max(f64::MIN_POSITIVE);
        Projection {
            processors,
            seconds,
            lost: Lost {
                imbalance: share(count * last - ended),
                cutting: share(working - whole),
                barrier: share(count * barrier),
                serial: share(count * costs.serial),
                balancer: share(asking),
                single: share(single),
            },
            ..Projection::default()
        }
    }

    /// When the last processor has left the barrier, serial part left out, if they arrive at these times.
    fn barrier(&self, arrivals: &[f64]) -> f64 {
        let &Costs { handover, crossing, .. } = self.costs;
        let mut all = Line::default();
        for group in arrivals.chunks(GROUP) {
            let mut times = group.to_vec();
            times.sort_by(f64::total_cmp);
            let mut counter = Line::default();
            let last = times.into_iter().fold(0.0, |_, time| counter.pass(time, handover));
            all.0 = all.0.max(last);
        }
        let groups = arrivals.len().div_ceil(GROUP);
        // The groups come one after the other at the worst.
        let arrived = all.0 + if groups > 1 { groups as f64 * handover } else { 0.0 };
        let waiters = arrivals.len().min(GROUP) - 1;
        arrived + crossing + (groups - 1 + waiters - 1) as f64 * handover
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;
    use crate::balance::BalancerKind;

    const TILE: TileSize = TileSize { width: 16, height: 16 };

    /// Frames of a picture of so many tiles in a row, each of which costs what `tile` says, a part of it its part.
    fn frames(tiles: usize, count: usize, tile: impl Fn(usize) -> f64) -> Costs {
        let mut frame = FrameCosts::default();
        for side in [16, 8, 4] {
            for y0 in (0..16).step_by(side) {
                for x0 in (0..16 * tiles).step_by(side) {
                    let fragment = Fragment { channel: 0, x0, y0, x1: x0 + side, y1: y0 + side, step: 1 };
                    frame.set(&fragment, tile(x0 / 16) * (side * side) as f64 / 256.0);
                }
            }
        }
        Costs { frames: vec![frame; count], ..Costs::default() }
    }

    fn even(tiles: usize) -> Costs {
        frames(tiles, 1, |_| 1e-4)
    }

    fn play(costs: &Costs, tiles: usize, name: &str, processors: usize) -> Projection {
        let balancer = name.parse::<BalancerKind>().unwrap().build();
        let dealt = Dealt { size: Size::new(16 * tiles, 16).unwrap(), tile: TILE, balancer: &*balancer };
        project(costs, &dealt, processors)
    }

    #[test]
    fn ideal_costs_scale_ideally() {
        // Long beside the planning of the balancer, whose time is real: on a busy machine it is several times as long.
        let costs = frames(512 * 12, 1, |_| 1e-2);
        for balancer in ["work-queue", "work-queue:3", "by-cost", "cyclic", "static"] {
            for processors in [1, 2, 64, 512] {
                let projection = play(&costs, 512 * 12, balancer, processors);
                assert!((projection.efficiency - 1.0).abs() < 0.03, "{balancer}: {projection:?}");
            }
        }
    }

    #[test]
    fn one_huge_tile_bounds_the_speedup_unless_it_is_cut() {
        let costs = frames(1000, 6, |tile| if tile == 999 { 0.1 } else { 1e-4 });
        let projection = play(&costs, 1000, "work-queue", 512);
        assert!(projection.speedup <= 2.0 && projection.speedup > 1.9, "{projection:?}");
        assert!(projection.lost.imbalance > 0.99, "{projection:?}");
        // By-cost begins with it, in sixteenths.
        let projection = play(&costs, 1000, "by-cost", 512);
        // What handing out a tile costs is measured here, and costs one processor more.
        assert!(projection.speedup > 30.0 && projection.speedup <= 32.1, "{projection:?}");
    }

    #[test]
    fn fewer_tiles_than_processors() {
        let projection = play(&even(3), 3, "work-queue", 126);
        assert!((projection.speedup - 3.0).abs() < 0.01, "{projection:?}");
    }

    #[test]
    fn costs_are_learnt_while_frames_are_played() {
        // A tenth of the tiles takes nine tenths of the time.
        let cost = |tile: usize| if tile % 50 < 5 { 9e-4 } else { 1e-5 };
        let [learnt, dealt] =
            ["by-cost", "work-queue"].map(|name| play(&frames(2000, 6, cost), 2000, name, 126).efficiency);
        assert!(learnt > 0.9 && learnt > dealt + 0.05, "{learnt} by cost, {dealt} by number");
    }

    #[test]
    fn every_cost_slows_down_and_is_named() {
        let costs = Costs { crossing: 1e-6, serial: 2e-6, display: 1e-4, handover: 1e-8, ..even(5000) };
        let lost = |projection: Projection| {
            let Lost { imbalance, cutting, barrier, serial, balancer, single } = projection.lost;
            [imbalance, cutting, barrier, serial, balancer, single]
        };
        let worst = play(&costs, 5000, "work-queue", 64);
        let [imbalance, cutting, others @ ..] = lost(worst);
        assert!(imbalance > 0.0 && cutting.abs() < 1e-9 && others.iter().all(|&share| share > 0.0), "{worst:?}");
        let useful = 5000.0 * 1e-4 / (64.0 * worst.seconds);
        assert!((lost(worst).iter().sum::<f64>() + useful - 1.0).abs() < 1e-9, "the shares add up: {worst:?}");
        let without = |costs: Costs| play(&costs, 5000, "work-queue", 64).lost;
        assert!(without(Costs { crossing: 0.0, ..costs.clone() }).barrier < worst.lost.barrier);
        assert_eq!(without(Costs { serial: 0.0, ..costs.clone() }).serial, 0.0);
        assert_eq!(without(Costs { display: 0.0, ..costs.clone() }).single, 0.0);
        assert!(without(costs.with_handover(0.0)).barrier < worst.lost.barrier);
    }

    #[test]
    fn a_counter_that_all_want_is_a_bottleneck() {
        // 1000 single tiles of 1 us, and a counter that takes 1 us: no more than one processor's worth of work.
        let costs = Costs { handover: 1e-6, ..frames(1000, 1, |_| 1e-6) };
        assert!(play(&costs, 1000, "work-queue:1000", 16).speedup < 1.1);
    }

    #[test]
    fn a_barrier_of_groups_grows_with_their_size_and_number() {
        let costs = Costs { handover: 1e-8, crossing: 1e-7, ..even(1) };
        let mut deal = Deal::new(TILE, BalancerKind::default().build());
        deal.begin(&[Size::new(16, 16).unwrap()], 1);
        let leaves = |processors: usize| {
            Frame { costs: &costs, frame: &costs.frames[0], deal: &deal, processors }.barrier(&vec![0.0; processors])
        };
        // All arrive at once: each waits for the line of its group, then the groups for theirs, and both on the way out.
        let expected = |groups: usize| 1e-7 + 1e-8 * (32 + groups + groups - 1 + 30) as f64;
        for groups in [2, 16] {
            assert!((leaves(32 * groups) - expected(groups)).abs() < 1e-12);
        }
        assert!(leaves(512) < 1.5 * leaves(64));
    }

    /// Two real threads with tiles that sleep take as long as the simulation says.
    #[test]
    fn two_real_threads_take_as_long_as_two_simulated_ones() {
        for name in ["work-queue", "static"] {
            // The last quarter is four times as dear: static shares are 1 to 2.5.
            let naps: Vec<u64> = (0..40).map(|tile| if tile < 30 { 1 } else { 4 }).collect();
            let nap = |tile: usize| std::thread::sleep(Duration::from_millis(naps[tile]));
            let cost = |tile: usize| {
                let start = Instant::now();
                nap(tile);
                start.elapsed().as_secs_f64()
            };
            let run = || {
                let times: Vec<f64> = (0..40).map(cost).collect();
                let expected = play(&frames(40, 1, |tile| times[tile]), 40, name, 2).seconds;
                let mut balancer = name.parse::<BalancerKind>().unwrap().build();
                balancer.reset(40, 2);
                let start = Instant::now();
                std::thread::scope(|scope| {
                    for thread in 0..2 {
                        let balancer = &balancer;
                        scope.spawn(move || {
                            while let Some(tiles) = balancer.next(thread) {
                                tiles.for_each(nap);
                            }
                        });
                    }
                });
                start.elapsed().as_secs_f64() / expected
            };
            // Sleeps are late on a busy machine: one good run of five is enough.
            let ratios: Vec<_> = (0..5).map(|_| run()).collect();
            assert!(ratios.iter().any(|ratio| (0.85..1.15).contains(ratio)), "{name}: {ratios:?}");
        }
    }
}
