//! The balancer that is used when none is asked for: by the number of threads.
//!
//! Few threads gain nothing from knowing costs: see `benches/record/2026-11-30-scaling.md`.

use std::ops::Range;

use super::balancer::LoadBalancer;
use super::{ByCost, WorkQueue};

/// [`WorkQueue`] for few threads, [`ByCost`] for [many](Self::MANY).
#[derive(Debug, Default)]
pub struct ByThreads {
    few: WorkQueue,
    many: ByCost,
    is_many: bool,
}

impl ByThreads {
    /// So many threads are many.
    pub const MANY: usize = 4;

    fn current(&self) -> &dyn LoadBalancer {
        if self.is_many { &self.many } else { &self.few }
    }

    fn choose(&mut self, threads: usize) -> &mut dyn LoadBalancer {
        self.is_many = threads >= Self::MANY;
        if self.is_many { &mut self.many } else { &mut self.few }
    }
}

impl LoadBalancer for ByThreads {
    fn reset(&mut self, items: usize, threads: usize) {
        self.choose(threads).reset(items, threads);
    }

    fn reset_with_costs(&mut self, costs: &[f32], threads: usize) {
        self.choose(threads).reset_with_costs(costs, threads);
    }

    fn wants_costs(&self, threads: usize) -> bool {
        threads >= Self::MANY
    }

    fn another(&self) -> Box<dyn LoadBalancer> {
        Box::new(Self::default())
    }

    fn next_touching(&self, thread: usize, touched: &mut dyn FnMut(usize)) -> Option<Range<usize>> {
        self.current().next_touching(thread, touched)
    }
}
