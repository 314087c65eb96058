//! Load balancers: who gets which part of a frame's work, and when.
//!
//! Source: Bigler, Stephens and Parker 2006, section 5.4. A balancer knows nothing of pictures: it hands out the numbers
//! `0..items`, each exactly once, as ranges. [`WorkQueue`] is the default; [`ByCost`] wants to know what items cost, and is
//! for many processors; [`Cyclic`] and [`Static`] are what to measure them against.
//!
//! ```
//! use mobula::balance::{BalancerKind, LoadBalancer};
//!
//! let mut balancer = "work-queue".parse::<BalancerKind>()?.build();
//! balancer.reset(1000, 4);
//! let mut items = 0;
//! while let Some(assignment) = balancer.next(0) {
//!     items += assignment.len();
//! }
//! assert_eq!(items, 1000);
//! # Ok::<(), mobula::balance::UnknownBalancer>(())
//! ```

mod by_cost;
mod cyclic;
mod places;
mod static_shares;
#[cfg(test)]
mod tests;
mod work_queue;

use std::fmt::Debug;
use std::ops::Range;
use std::str::FromStr;

pub use by_cost::ByCost;
pub use cyclic::Cyclic;
pub use static_shares::Static;
pub use work_queue::WorkQueue;

/// The most threads that a balancer serves, and so the most that a pipeline may have.
pub const MAX_THREADS: usize = 1024;

/// Hands out `0..items` to threads: every item exactly once, whichever threads ask, in whichever order, how often.
///
/// A balancer that gives threads shares of their own ([`Static`], [`Cyclic`], the first ones of [`ByCost`]) hands out
/// everything only if each thread asks until it gets nothing.
pub trait LoadBalancer: Debug + Send + Sync {
    /// Begins anew.
    ///
    /// # Panics
    /// When `threads` is not in `1..=`[`MAX_THREADS`].
    fn reset(&mut self, items: usize, threads: usize);

    /// Begins anew, and tells what each item is expected to cost, in any unit. Most balancers only count the items.
    ///
    /// # Panics
    /// As [`reset`](Self::reset) does.
    fn reset_with_costs(&mut self, costs: &[f32], threads: usize) {
        self.reset(costs.len(), threads);
    }

    /// Whether knowing costs makes it better.
    fn wants_costs(&self) -> bool {
        false
    }

    /// Another one of the same kind.
    fn another(&self) -> Box<dyn LoadBalancer>;

    /// The next assignment of a thread, never empty. None: there is nothing left for this thread.
    fn next(&self, thread: usize) -> Option<Range<usize>> {
        self.next_touching(thread, &mut |_| ())
    }

    /// As [`next`](Self::next); calls `touched` with the number of each cache line that it shares with other threads and
    /// goes to, for simulations.
    fn next_touching(&self, thread: usize, touched: &mut dyn FnMut(usize)) -> Option<Range<usize>>;
}

/// The balancers that can be chosen at run time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BalancerKind {
    /// `work-queue`, or `work-queue:G` with the granularity G: [`WorkQueue`].
    WorkQueue {
        /// See [`WorkQueue::new`].
        granularity: usize,
    },
    /// `by-cost`: [`ByCost`].
    ByCost,
    /// `cyclic`: [`Cyclic`].
    Cyclic,
    /// `static`: [`Static`].
    Static,
}

/// A name that is no balancer's.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown load balancer '{0}': use work-queue, work-queue:GRANULARITY (1 or more), by-cost, cyclic or static")]
pub struct UnknownBalancer(pub String);

impl BalancerKind {
    /// Makes the balancer.
    pub fn build(self) -> Box<dyn LoadBalancer> {
        match self {
            Self::WorkQueue { granularity } => Box::new(WorkQueue::new(granularity)),
            Self::ByCost => Box::new(ByCost::default()),
            Self::Cyclic => Box::new(Cyclic::default()),
            Self::Static => Box::new(Static::default()),
        }
    }
}

impl Default for BalancerKind {
    fn default() -> Self {
        Self::WorkQueue { granularity: WorkQueue::GRANULARITY }
    }
}

impl FromStr for BalancerKind {
    type Err = UnknownBalancer;

    fn from_str(name: &str) -> Result<Self, UnknownBalancer> {
        match name {
            "work-queue" => Ok(Self::default()),
            "by-cost" => Ok(Self::ByCost),
            "cyclic" => Ok(Self::Cyclic),
            "static" => Ok(Self::Static),
            _ => {
                let granularity = name.strip_prefix("work-queue:").and_then(|text| text.parse().ok());
                let granularity = granularity.filter(|&granularity| granularity > 0);
                granularity
                    .map(|granularity| Self::WorkQueue { granularity })
                    .ok_or_else(|| UnknownBalancer(name.to_owned()))
            }
        }
    }
}

impl std::fmt::Display for BalancerKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::WorkQueue { granularity: WorkQueue::GRANULARITY } => f.write_str("work-queue"),
            Self::WorkQueue { granularity } => write!(f, "work-queue:{granularity}"),
            Self::ByCost => f.write_str("by-cost"),
            Self::Cyclic => f.write_str("cyclic"),
            Self::Static => f.write_str("static"),
        }
    }
}

/// Share `index` of `count` even shares of `0..items`; they differ by one item at most.
pub fn even_share(items: usize, index: usize, count: usize) -> Range<usize> {
    let (each, extra) = (items / count, items % count);
    let start = index * each + index.min(extra);
    start..start + each + usize::from(index < extra)
}

fn check(threads: usize) {
    assert!((1..=MAX_THREADS).contains(&threads), "a load balancer serves 1 to {MAX_THREADS} threads, not {threads}");
}
