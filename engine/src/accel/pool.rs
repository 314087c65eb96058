//! Threads to build with.

use mobula_core::bvh::Join;

/// Does two things at once on the threads of the process's pool, which sleep while nothing is built. The first build starts
/// them; before any thread is bound to a core, or they would be too.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pool;

impl Pool {
    /// Does on one of its threads what joins often: to join from outside wakes one each time.
    pub(crate) fn enter<R: Send>(work: impl FnOnce() -> R + Send) -> R {
        rayon_core::scope(|_| work())
    }
}

impl Join for Pool {
    fn join<A: Send, B: Send>(&self, a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
        rayon_core::join(a, b)
    }
}
