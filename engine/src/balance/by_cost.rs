//! The queue that knows what items cost: assignments of decreasing cost, the first of each thread without a counter.
//!
//! Source: factoring (Hummel, Schonberg and Flynn 1992) over costs instead of counts. Who gives the costs should give the
//! dearest items first: what is dear begins early, and what is left at the end is small (Graham 1969, longest processing
//! time first).
//!
//! The items are cut into assignments beforehand. In each round, which has one assignment for each thread, a third of the
//! cost that is left is dealt out. The first round needs no counter, but for the last thread: it may come late, since it
//! is the one that plans the next frame. In the later rounds the threads of a group share a counter, and go to two other
//! groups when their own has nothing left: not to all, or in the end all threads would queue at all counters.
//!
//! The numbers were tuned in the simulation of 126 to 512 processors (`benches/record/2026-11-24-scaling.md`).

use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

use crossbeam_utils::CachePadded;

use super::balancer::{LoadBalancer, check};
use super::places::Places;

/// Threads that share a counter.
const GROUP: usize = 16;

/// Groups that a thread goes to: its own and these.
const OTHERS: usize = 2;

/// A round hands out this part of the cost that is left.
const PART: f64 = 1.0 / 3.0;

/// An assignment costs no less than this part of a thread's share, unless it is a single item.
const LEAST: f64 = 1.0 / 128.0;

/// Hands out assignments of decreasing cost.
#[derive(Debug, Default)]
pub struct ByCost {
    /// Where each assignment ends, and the next begins.
    ends: Vec<usize>,
    first: Places,
    groups: Vec<CachePadded<AtomicUsize>>,
}

impl ByCost {
    fn cut(&mut self, items: usize, threads: usize, cost: impl Fn(usize) -> f64) {
        check(threads);
        self.ends.clear();
        let share = (0..items).map(&cost).sum::<f64>() / threads as f64;
        let (mut left, mut item) = (share, 0);
        while item < items {
            // `left` is per thread.
            let quota = (left * PART).max(share * LEAST);
            for _ in 0..threads {
                let mut sum = 0.0;
                while item < items && (sum == 0.0 || sum + cost(item) / 2.0 <= quota) {
                    sum += cost(item).max(f64::MIN_POSITIVE);
                    item += 1;
                }
                left -= sum / threads as f64;
                if item < items || sum > 0.0 {
                    self.ends.push(item);
                }
            }
        }
        self.first.reset(threads);
        self.groups.resize_with(threads.div_ceil(GROUP), Default::default);
        for (group, counter) in self.groups.iter_mut().enumerate() {
            // Its first round is dealt already, but for the last thread's.
            let members = members(group, threads);
            *counter.get_mut() = members.len() - usize::from(members.end == threads);
        }
    }

    fn assignment(&self, number: usize) -> Option<Range<usize>> {
        let end = *self.ends.get(number)?;
        let start = if number == 0 { 0 } else { self.ends[number - 1] };
        Some(start..end)
    }

    /// The next assignment of a group.
    fn take(&self, group: usize, touched: &mut dyn FnMut(usize)) -> Option<Range<usize>> {
        let (counter, members) = (&self.groups[group], members(group, self.first.threads()));
        let number =
            |taken: usize| taken / members.len() * self.first.threads() + members.start + taken % members.len();
        touched(group);
        // Relaxed, both: that no two threads get one number is all that is needed. The look beforehand spares the line of a
        // group that has nothing left from being written by all who come by.
        if number(counter.load(Ordering::Relaxed)) >= self.ends.len() {
            return None;
        }
        self.assignment(number(counter.fetch_add(1, Ordering::Relaxed)))
    }
}

/// The threads of a group.
fn members(group: usize, threads: usize) -> Range<usize> {
    group * GROUP..((group + 1) * GROUP).min(threads)
}

impl LoadBalancer for ByCost {
    fn reset(&mut self, items: usize, threads: usize) {
        self.cut(items, threads, |_| 1.0);
    }

    fn reset_with_costs(&mut self, costs: &[f32], threads: usize) {
        // A cost that is none counts as nothing.
        self.cut(costs.len(), threads, |item| {
            Some(f64::from(costs[item])).filter(|cost| cost.is_finite() && *cost > 0.0).unwrap_or(0.0)
        });
    }

    fn another(&self) -> Box<dyn LoadBalancer> {
        Box::new(Self::default())
    }

    fn wants_costs(&self) -> bool {
        true
    }

    fn next_touching(&self, thread: usize, touched: &mut dyn FnMut(usize)) -> Option<Range<usize>> {
        if self.first.advance(thread)? == 0
            && thread + 1 < self.first.threads()
            && let Some(first) = self.assignment(thread)
        {
            return Some(first);
        }
        let (own, groups) = (thread / GROUP, self.groups.len());
        (own..own + groups.min(1 + OTHERS)).find_map(|group| self.take(group % groups, touched))
    }
}
