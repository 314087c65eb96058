//! The queues that know what items cost: one for each few threads, each with an equal part of the cost, the dearest items first.
//!
//! Who gives the costs should give the dearest items first: what is dear begins early, and what is left at the end is small (Graham 1969,
//! longest processing time first). Items are handed out one at a time, since costs are guesses: what a thread has taken, no other can
//! take from it.
//!
//! The items are dealt to the queues beforehand. The threads of a group share a queue and its counter, and go to those of two other
//! groups when their own has nothing left: not to all, or in the end all threads would queue at all counters. The first item of each
//! thread needs no counter, but for the last thread's: it may come late, since it is the one that plans the next frame.
//!
//! The numbers were tuned in the simulation of 126 to 512 processors (`benches/record/2026-11-30-scaling.md`).

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

use crossbeam_utils::CachePadded;

use super::balancer::{LoadBalancer, check};
use super::places::Places;

/// Threads that share a queue.
const GROUP: usize = 16;

/// Queues that a thread goes to: its own and these.
const OTHERS: usize = 2;

/// Hands out one item at a time, the dearest first.
#[derive(Debug, Default)]
pub struct ByCost {
    queues: Vec<CachePadded<Queue>>,
    first: Places,
    // Kept so that dealing allocates nothing: what each queue costs a thread, in bits, which order as the numbers do.
    dealt: BinaryHeap<Reverse<(u64, usize)>>,
}

#[derive(Debug, Default)]
struct Queue {
    /// How many items are taken.
    taken: AtomicUsize,
    items: Vec<usize>,
}

impl ByCost {
    fn deal(&mut self, items: usize, threads: usize, cost: impl Fn(usize) -> f64) {
        check(threads);
        self.first.reset(threads);
        self.queues.resize_with(threads.div_ceil(GROUP), Default::default);
        self.dealt.clear();
        for (group, queue) in self.queues.iter_mut().enumerate() {
            let members = members(group, threads);
            queue.items.clear();
            // The first of each is dealt already, but for the last thread's.
            *queue.taken.get_mut() = members.len() - usize::from(members.end == threads);
            self.dealt.push(Reverse((0, group)));
        }
        // To hand out what costs nothing costs something.
        let total: f64 = (0..items).map(&cost).sum();
        let least = if total > 0.0 { total / items as f64 / 1024.0 } else { 1.0 };
        for item in 0..items {
            let Some(mut cheapest) = self.dealt.peek_mut() else { return };
            let Reverse((dealt, group)) = &mut *cheapest;
            self.queues[*group].items.push(item);
            let more = (cost(item) + least) / members(*group, threads).len() as f64;
            *dealt = (f64::from_bits(*dealt) + more).to_bits();
        }
    }

    /// The next item of a queue.
    fn take(&self, group: usize, touched: &mut dyn FnMut(usize)) -> Option<Range<usize>> {
        let queue = &self.queues[group];
        touched(group);
        // Relaxed, both: that no two threads get one item is all that is needed. The look beforehand spares the line of a
        // queue that has nothing left from being written by all who come by.
        if queue.taken.load(Ordering::Relaxed) >= queue.items.len() {
            return None;
        }
        queue.item(queue.taken.fetch_add(1, Ordering::Relaxed))
    }
}

impl Queue {
    fn item(&self, number: usize) -> Option<Range<usize>> {
        self.items.get(number).map(|&item| item..item + 1)
    }
}

/// The threads of a group.
fn members(group: usize, threads: usize) -> Range<usize> {
    group * GROUP..((group + 1) * GROUP).min(threads)
}

impl LoadBalancer for ByCost {
    fn reset(&mut self, items: usize, threads: usize) {
        self.deal(items, threads, |_| 1.0);
    }

    fn reset_with_costs(&mut self, costs: &[f32], threads: usize) {
        // A cost that is none counts as nothing.
        self.deal(costs.len(), threads, |item| {
            Some(f64::from(costs[item])).filter(|cost| cost.is_finite() && *cost > 0.0).unwrap_or(0.0)
        });
    }

    fn another(&self) -> Box<dyn LoadBalancer> {
        Box::new(Self::default())
    }

    fn wants_costs(&self, _: usize) -> bool {
        true
    }

    fn next_touching(&self, thread: usize, touched: &mut dyn FnMut(usize)) -> Option<Range<usize>> {
        let (own, groups) = (thread / GROUP, self.queues.len());
        if self.first.advance(thread)? == 0
            && thread + 1 < self.first.threads()
            && let Some(first) = self.queues[own].item(thread % GROUP)
        {
            return Some(first);
        }
        (own..own + groups.min(1 + OTHERS)).find_map(|group| self.take(group % groups, touched))
    }
}
