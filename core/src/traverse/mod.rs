//! How rays find what they hit in a tree: packets in groups of 16 that have something in common, what is left as streams or
//! ray by ray. The hits are the same bits on all paths. Nothing is lost to rounding: see
//! [`kernel::margin`](crate::kernel::margin).

#![doc = include_str!("TRAVERSAL.md")]

mod local;
mod packet;
mod paths;
mod roots;
mod single;
mod stack;
mod stream;
mod trace;

pub use local::Local;
pub use paths::Paths;
#[cfg(all(feature = "lab", not(test)))]
pub(crate) use trace::run;
pub use trace::{intersect, intersect_all, occlude, occlude_all};
