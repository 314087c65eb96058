//! What the application takes part in the loop with: names of callbacks, moments, and those that all threads call at once.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use super::fault::{Caught, catch};

/// Names a callback so that it can be removed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct CallbackId(u64);

/// What a parallel callback gets: the state, shared, and which share of the work is its own.
#[derive(Debug)]
pub struct Worker<'a, S> {
    /// The application's state. To change it in place it needs interior mutability (locks or atomics per part).
    pub state: &'a S,
    /// This thread's index, below `threads`.
    pub thread: usize,
    /// How many threads run this callback at once.
    pub threads: usize,
    /// Number of the frame that is about to be rendered.
    pub frame: u64,
    /// Time of that frame.
    pub time: Duration,
}

impl<S> Worker<'_, S> {
    /// This thread's even share of `0..items`. The shares of all threads together are `0..items`, each item once.
    pub fn share(&self, items: usize) -> std::ops::Range<usize> {
        crate::balance::even_share(items, self.thread, self.threads)
    }
}

/// When a serial callback is called.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Moment {
    Setup,
    Animation,
    Changed,
    PreRender,
    Idle,
    Termination,
}

/// When a parallel callback is called.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ParallelMoment {
    Animation,
    PreRender,
}

type ParallelCall<S> = Box<dyn Fn(&Worker<'_, S>) + Send + Sync>;

/// A parallel callback, shared with the render threads during its phase.
pub(super) struct Parallel<S> {
    pub(super) id: CallbackId,
    pub(super) name: String,
    pub(super) moment: ParallelMoment,
    pub(super) call: ParallelCall<S>,
}

/// When a one-shot is called.
#[derive(Clone, Copy, Debug)]
pub(super) enum Due {
    Frame(u64),
    Time(Duration),
}

impl<S> Parallel<S> {
    pub(super) fn call(&self, worker: &Worker<'_, S>) -> Result<(), Caught> {
        catch(format_args!("callback {}", self.name), || (self.call)(worker))
    }
}

impl Due {
    pub(super) fn is_due(self, frame: u64, time: Duration) -> bool {
        match self {
            Self::Frame(due) => frame >= due,
            Self::Time(due) => time >= due,
        }
    }
}

/// A new name.
pub(super) fn next_id() -> CallbackId {
    static NEXT: AtomicU64 = AtomicU64::new(0);
    // Relaxed: only uniqueness matters.
    CallbackId(NEXT.fetch_add(1, Ordering::Relaxed))
}
