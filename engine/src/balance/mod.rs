//! Load balancers: who gets which part of a frame's work, and when.
//!
//! Source: Bigler, Stephens and Parker 2006, section 5.4. A balancer knows nothing of pictures: it hands out the numbers
//! `0..items`, each exactly once, as ranges. [`WorkQueue`] is for few threads; [`ByCost`] wants to know what items cost, and is
//! for many; [`ByThreads`], the default, is the one or the other; [`Cyclic`] and [`Static`] are what to measure them against.
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

mod balancer;
mod by_cost;
mod by_threads;
mod cyclic;
mod kind;
mod places;
mod static_shares;
#[cfg(test)]
mod tests;
mod work_queue;

pub use balancer::{LoadBalancer, MAX_THREADS, even_share};
pub use by_cost::ByCost;
pub use by_threads::ByThreads;
pub use cyclic::Cyclic;
pub use kind::{BalancerKind, UnknownBalancer};
pub use static_shares::Static;
pub use work_queue::WorkQueue;
