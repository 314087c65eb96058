//! Acceleration structures: which one is built, chosen by name, and by which threads.

mod kind;
mod pool;

pub use kind::{AccelerationKind, Build};
pub(crate) use pool::Pool;
