//! The projection: a discrete-event simulation of frames on more processors than there are.
//!
//! The load balancer is the real one: each simulated processor asks it for assignments in the order of simulated time.
//! The costs are measured ones ([`Costs`]). What is assumed, and printed with the results:
//!
//! - Processors are equal and have caches and memory bandwidth of their own: a tile costs what it costs alone.
//! - Taking an assignment costs the balancer's own arithmetic, at any time, and in addition the counter's cache line,
//!   which only one processor has at a time: askers queue for it. One hand-over costs what it costs between two threads.
//! - A crossing of the barrier costs what it costs with two threads, times a [`Growth`]. Whoever arrives early waits.
//! - The serial part at the barrier costs what it costs here. One processor shows the previous picture before it renders.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use crate::balance::LoadBalancer;

/// What the parts of a frame cost, in seconds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Costs {
    /// Each tile, by number.
    pub tiles: Vec<f64>,
    /// Crossing the barrier with two threads.
    pub crossing: f64,
    /// The serial part at the barrier.
    pub serial: f64,
    /// The display of one picture.
    pub display: f64,
    /// Passing a cache line from one thread to another that writes it too.
    pub handover: f64,
}

/// How the cost of a crossing grows with the number of processors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Growth {
    /// With their number: one after the other reads the line of the gate. The worst case of one central barrier.
    Linear,
    /// With the logarithm of their number: lines are passed on as in a tree.
    Logarithmic,
}

impl Growth {
    /// The cost of a crossing of so many, in crossings of two.
    pub fn factor(self, processors: usize) -> f64 {
        match (self, processors) {
            (_, 0 | 1) => 0.0,
            (Self::Linear, _) => processors as f64 / 2.0,
            (Self::Logarithmic, _) => (processors as f64).log2(),
        }
    }
}

/// A simulated frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projection {
    /// How many processors.
    pub processors: usize,
    /// From barrier to barrier.
    pub seconds: f64,
    /// Times faster than one processor.
    pub speedup: f64,
    /// Speed-up per processor.
    pub efficiency: f64,
    /// Where the rest went.
    pub lost: Lost,
}

/// Shares of all processors' time in which nothing was rendered; with the useful share they add up to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lost {
    /// Waiting for the last to finish.
    pub imbalance: f64,
    /// Crossing the barrier.
    pub barrier: f64,
    /// Waiting while one works at the barrier.
    pub serial: f64,
    /// Asking the load balancer, and waiting for it.
    pub balancer: f64,
    /// Displaying.
    pub display: f64,
}

/// Plays one frame. `take` is the balancer's own arithmetic for one assignment, in seconds.
pub fn project(costs: &Costs, balancer: &dyn LoadBalancer, take: f64, growth: Growth, processors: usize) -> Projection {
    let alone = frame(costs, balancer, take, growth, 1).seconds;
    let mut projection = frame(costs, balancer, take, growth, processors);
    projection.speedup = alone / projection.seconds;
    projection.efficiency = projection.speedup / processors as f64;
    projection
}

fn frame(costs: &Costs, balancer: &dyn LoadBalancer, take: f64, growth: Growth, processors: usize) -> Projection {
    balancer.reset(costs.tiles.len(), processors);
    let handover = if processors > 1 { costs.handover } else { 0.0 };
    // By the time in nanoseconds * 2^10, so that times order and compare; ties by processor.
    let ticks = |seconds: f64| (seconds * 1e9 * 1024.0) as u64;
    let mut events: BinaryHeap<_> = (0..processors)
        .map(|processor| {
            let start = if processor == 0 { costs.display } else { 0.0 };
            Reverse((ticks(start), processor))
        })
        .collect();
    let mut now: Vec<f64> = vec![0.0; processors];
    now[0] = costs.display;
    let (mut counter, mut asking, mut working, mut last, mut ended) = (0.0_f64, 0.0, 0.0, 0.0_f64, 0.0);
    while let Some(Reverse((_, processor))) = events.pop() {
        let asked = now[processor];
        counter = counter.max(asked) + handover;
        let got = counter + take;
        asking += got - asked;
        match balancer.next(processor) {
            Some(tiles) => {
                let work: f64 = costs.tiles[tiles].iter().sum();
                working += work;
                now[processor] = got + work;
                events.push(Reverse((ticks(now[processor]), processor)));
            }
            None => {
                last = last.max(got);
                ended += got;
            }
        }
    }
    let count = processors as f64;
    let crossing = costs.crossing * growth.factor(processors);
    let seconds = last + crossing + costs.serial;
    debug_assert!((costs.display + asking + working - ended).abs() <= 1e-9 * ended.max(1e-3), "all time is accounted");
    let share = |time: f64| time / (seconds * count).max(f64::MIN_POSITIVE);
    Projection {
        processors,
        seconds,
        speedup: 1.0,
        efficiency: 1.0,
        lost: Lost {
            imbalance: share(count * last - ended),
            barrier: share(count * crossing),
            serial: share(count * costs.serial),
            balancer: share(asking),
            display: share(costs.display),
        },
    }
}

#[cfg(test)]
mod tests {
    use std::time::{Duration, Instant};

    use super::*;
    use crate::balance::BalancerKind;

    fn play(costs: &Costs, name: &str, processors: usize) -> Projection {
        let balancer = name.parse::<BalancerKind>().unwrap().build();
        project(costs, &*balancer, 0.0, Growth::Linear, processors)
    }

    fn even(tiles: usize) -> Costs {
        Costs { tiles: vec![1e-4; tiles], ..Costs::default() }
    }

    #[test]
    fn ideal_costs_scale_ideally() {
        for balancer in ["work-queue", "work-queue:3", "cyclic", "static"] {
            for processors in [1, 2, 64, 512] {
                let projection = play(&even(512 * 12), balancer, processors);
                assert!((projection.efficiency - 1.0).abs() < 1e-9, "{balancer}: {projection:?}");
            }
        }
    }

    #[test]
    fn one_huge_tile_bounds_the_speedup() {
        let mut costs = even(1000);
        costs.tiles[999] = 0.1;
        let projection = play(&costs, "work-queue", 512);
        assert!(projection.speedup <= 2.0 && projection.speedup > 1.9, "{projection:?}");
        assert!(projection.lost.imbalance > 0.99, "{projection:?}");
    }

    #[test]
    fn fewer_tiles_than_processors() {
        let projection = play(&even(3), "work-queue", 126);
        assert!((projection.speedup - 3.0).abs() < 1e-9, "{projection:?}");
        assert_eq!(play(&even(0), "cyclic", 4).seconds, 0.0);
    }

    #[test]
    fn every_cost_slows_down_and_is_named() {
        let costs = Costs { crossing: 1e-6, serial: 2e-6, display: 1e-4, handover: 1e-8, ..even(5000) };
        let lost = |projection: Projection| {
            let Lost { imbalance, barrier, serial, balancer, display } = projection.lost;
            [imbalance, barrier, serial, balancer, display]
        };
        let worst = play(&costs, "work-queue", 64);
        assert!(lost(worst).iter().all(|&share| share > 0.0), "{worst:?}");
        let useful = 5000.0 * 1e-4 / (64.0 * worst.seconds);
        assert!((lost(worst).iter().sum::<f64>() + useful - 1.0).abs() < 1e-9, "the shares add up: {worst:?}");
        for better in [
            Costs { crossing: 0.0, ..costs.clone() },
            Costs { serial: 0.0, ..costs.clone() },
            Costs { handover: 0.0, ..costs.clone() },
        ] {
            assert!(play(&better, "work-queue", 64).seconds < worst.seconds);
        }
        let balancer = BalancerKind::default().build();
        let tree = project(&costs, &*balancer, 0.0, Growth::Logarithmic, 64);
        assert!(tree.efficiency > worst.efficiency);
    }

    #[test]
    fn a_counter_that_all_want_is_a_bottleneck() {
        // 1000 single tiles of 1 us, and a counter that takes 1 us: no more than one processor's worth of work.
        let costs = Costs { tiles: vec![1e-6; 1000], handover: 1e-6, ..Costs::default() };
        assert!(play(&costs, "work-queue:1000", 16).speedup < 1.1);
    }

    /// Two real threads with tiles that sleep take as long as the simulation says.
    #[test]
    fn two_real_threads_take_as_long_as_two_simulated_ones() {
        for name in ["work-queue", "static"] {
            // The last quarter is four times as dear: static shares are 1 to 2.5.
            let naps: Vec<u64> = (0..40).map(|tile| if tile < 30 { 1 } else { 4 }).collect();
            let balancer = name.parse::<BalancerKind>().unwrap().build();
            let nap = |tile: usize| std::thread::sleep(Duration::from_millis(naps[tile]));
            let cost = |tile: usize| {
                let start = Instant::now();
                nap(tile);
                start.elapsed().as_secs_f64()
            };
            let run = || {
                let tiles = (0..40).map(cost).collect();
                let costs = Costs { tiles, ..Costs::default() };
                let expected = project(&costs, &*balancer, 0.0, Growth::Linear, 2).seconds;
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
