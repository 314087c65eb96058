//! Every item is handed out exactly once, whoever asks.

use std::sync::atomic::{AtomicUsize, Ordering};

use proptest::prelude::*;

use super::*;

const NAMES: [&str; 7] = ["auto", "work-queue", "work-queue:1", "work-queue:7", "by-cost", "cyclic", "static"];

fn kind() -> impl Strategy<Value = BalancerKind> {
    prop::sample::select(&NAMES[..]).prop_map(|name| name.parse().unwrap())
}

/// Lets the threads ask in a pseudo-random order until none gets anything; returns how often each item was given out.
fn deal(balancer: &dyn LoadBalancer, items: usize, threads: usize, seed: u64) -> Vec<usize> {
    let mut given = vec![0; items];
    let mut asking: Vec<usize> = (0..threads).collect();
    let mut random = seed | 1;
    while !asking.is_empty() {
        random ^= random << 13;
        random ^= random >> 7;
        random ^= random << 17;
        let place = random as usize % asking.len();
        match balancer.next(asking[place]) {
            Some(range) => {
                assert!(!range.is_empty(), "an assignment is never empty");
                range.for_each(|item| given[item] += 1);
            }
            None => {
                asking.swap_remove(place);
            }
        }
    }
    given
}

proptest! {
    #[test]
    fn every_item_exactly_once(kind in kind(), items in 0..3000_usize, threads in 1..70_usize, seed: u64) {
        let mut balancer = kind.build();
        for items in [items, 0, items / 2] {
            balancer.reset(items, threads);
            prop_assert!(deal(&*balancer, items, threads, seed).iter().all(|&times| times == 1));
            for thread in 0..threads {
                prop_assert_eq!(balancer.next(thread), None, "what is dealt stays dealt");
            }
        }
    }

    #[test]
    fn every_item_exactly_once_under_contention(kind in kind(), items in 0..2000_usize, threads in 1..6_usize) {
        let mut balancer = kind.build();
        balancer.reset(items, threads);
        let given: Vec<AtomicUsize> = (0..items).map(|_| AtomicUsize::new(0)).collect();
        std::thread::scope(|scope| {
            for thread in 0..threads {
                let (balancer, given) = (&*balancer, &given);
                scope.spawn(move || {
                    while let Some(range) = balancer.next(thread) {
                        for item in range {
                            given[item].fetch_add(1, Ordering::Relaxed);
                        }
                    }
                });
            }
        });
        prop_assert!(given.iter().all(|times| times.load(Ordering::Relaxed) == 1));
    }

    #[test]
    fn the_work_queue_hands_out_decreasing_sizes(items in 0..100_000_usize, threads in 1..600_usize, granularity in 1..9_usize) {
        let mut queue = WorkQueue::new(granularity);
        queue.reset(items, threads);
        let (mut last, mut start) = (usize::MAX, 0);
        while let Some(range) = queue.next(0) {
            prop_assert!(range.start == start && range.len() <= last);
            prop_assert!(range.len() <= 1 + items / (threads * granularity), "the first round leaves enough for the rest");
            (last, start) = (range.len(), range.end);
        }
        prop_assert_eq!(start, items);
    }

    /// Whatever costs are given, none and infinite ones too.
    #[test]
    fn costs_are_advice_only(
        costs in prop::collection::vec(prop_oneof![8 => 0.0..10.0_f32, 1 => prop::num::f32::ANY], 0..900),
        threads in 1..70_usize,
        seed: u64,
    ) {
        for name in NAMES {
            let mut balancer = name.parse::<BalancerKind>().unwrap().build();
            balancer.reset_with_costs(&costs, threads);
            prop_assert!(deal(&*balancer, costs.len(), threads, seed).iter().all(|&times| times == 1), "{}", name);
        }
    }

    /// Where threads ask when they are done with what they have, by-cost ends no later than the greatest cost or a part of
    /// a share after the ideal.
    #[test]
    fn dearest_first_ends_together(costs in prop::collection::vec(1.0..100.0_f32, 1..2000), threads in 1..100_usize) {
        let mut costs = costs;
        costs.sort_by(|a, b| b.total_cmp(a));
        let mut balancer = ByCost::default();
        balancer.reset_with_costs(&costs, threads);
        let mut free: Vec<(f32, usize)> = (0..threads).map(|thread| (0.0, thread)).collect();
        let mut end = 0.0_f32;
        while let Some(first) = (0..free.len()).min_by(|&a, &b| free[a].partial_cmp(&free[b]).unwrap()) {
            match balancer.next(free[first].1) {
                Some(items) => free[first].0 += costs[items].iter().sum::<f32>(),
                None => end = end.max(free.swap_remove(first).0),
            }
        }
        let share = costs.iter().sum::<f32>() / threads as f32;
        let least = costs[costs.len() - 1];
        let slack = if costs.len() > 8 * threads { share * 0.05 + least * 2.0 } else { share * 0.5 };
        prop_assert!(end <= (share + slack).max(costs[0]) * 1.001, "{} of {}", end, share);
    }

    #[test]
    fn even_shares_are_even(items in 0..5000_usize, count in 1..99_usize) {
        let mut start = 0;
        for index in 0..count {
            let share = even_share(items, index, count);
            prop_assert!(share.start == start && share.len().abs_diff(items / count) <= 1);
            start = share.end;
        }
        prop_assert_eq!(start, items);
    }
}

#[test]
fn huge_counts_do_not_overflow() {
    for name in NAMES {
        if ["auto", "by-cost"].contains(&name) {
            continue; // they list their assignments
        }
        let mut balancer = name.parse::<BalancerKind>().unwrap().build();
        balancer.reset(usize::MAX, MAX_THREADS);
        assert!(balancer.next(MAX_THREADS - 1).is_some(), "{name}");
    }
}

#[test]
fn unknown_names_list_the_known_ones() {
    for name in NAMES {
        assert_eq!(name.parse::<BalancerKind>().unwrap().to_string(), name.replace(":2", ""));
    }
    for name in ["", "work-queue:0", "work-queue:x", "guided"] {
        let error = name.parse::<BalancerKind>().unwrap_err().to_string();
        assert!(error.contains("work-queue") && error.contains("cyclic") && error.contains("static"), "{error}");
    }
}

#[test]
#[should_panic(expected = "1 to 1024 threads, not 0")]
fn no_threads_are_refused() {
    Cyclic::default().reset(1, 0);
}
