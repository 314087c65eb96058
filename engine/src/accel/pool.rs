//! Threads to build with, and to read text with.

use std::sync::OnceLock;

use mobula_core::bvh::Join;
use rayon_core::{Scope, ThreadPool, ThreadPoolBuilder};

use crate::progress::Progress;

/// Does two things at once on the threads of the process's pool, which sleep while nothing is built. The first build starts
/// them; before any thread is bound to a core, or they would be too. Where there are none, builds do without: if the system has
/// no threads to give, and in a process that was forked from the one that started them, since threads are not copied.
///
/// What builds are done with counts as progress.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pool<'a>(pub(crate) &'a Progress);

/// The threads and the process that they are in.
struct Threads {
    process: u32,
    pool: Option<ThreadPool>,
}

static THREADS: OnceLock<Threads> = OnceLock::new();

impl Pool<'_> {
    /// Does on one of its threads what joins often: to join from outside wakes one each time. What is on a thread of such a pool already,
    /// be it the program's own, stays there.
    pub(crate) fn enter<R: Send>(work: impl FnOnce() -> R + Send) -> R {
        if rayon_core::current_thread_index().is_some() {
            work()
        } else {
            Threads::get().enter(std::process::id(), work)
        }
    }

    /// Does on this thread what has tasks for the pool's, and waits for them.
    pub(crate) fn with_tasks<'scope, R>(work: impl FnOnce(Tasks<'_, 'scope>) -> R) -> R {
        Threads::get().with_tasks(std::process::id(), work)
    }
}

/// What tasks are given to; without threads they are done at once.
#[derive(Clone, Copy)]
pub(crate) struct Tasks<'a, 'scope>(Option<&'a Scope<'scope>>);

impl<'scope> Tasks<'_, 'scope> {
    pub(crate) fn add(self, task: impl FnOnce() + Send + 'scope) {
        match self.0 {
            Some(scope) => scope.spawn(|_| task()),
            None => task(),
        }
    }
}

impl Join for Pool<'_> {
    fn join<A: Send, B: Send>(&self, a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
        // Outside of a pool there would be another one of rayon's own.
        if rayon_core::current_thread_index().is_some() { rayon_core::join(a, b) } else { (a(), b()) }
    }

    fn done_with(&self, primitives: usize) {
        self.0.advance(primitives as u64);
    }
}

impl Threads {
    /// Those of the process.
    fn get() -> &'static Self {
        THREADS.get_or_init(|| Self::start(ThreadPoolBuilder::new))
    }

    /// One thread for each processor, or as many as there can be.
    fn start(builder: impl Fn() -> ThreadPoolBuilder) -> Self {
        let mut pool = builder().build();
        let mut count = std::thread::available_parallelism().map_or(1, usize::from);
        // One thread more is no help to the one that builds.
        while pool.is_err() && count > 2 {
            count /= 2;
            pool = builder().num_threads(count).build();
        }
        if let Err(error) = &pool {
            log::warn!("acceleration structures are built without threads: {error}");
        }
        Self { process: std::process::id(), pool: pool.ok() }
    }

    fn enter<R: Send>(&self, process: u32, work: impl FnOnce() -> R + Send) -> R {
        match &self.pool {
            Some(pool) if self.process == process => pool.install(work),
            _ => work(),
        }
    }

    fn with_tasks<'scope, R>(&self, process: u32, work: impl FnOnce(Tasks<'_, 'scope>) -> R) -> R {
        match &self.pool {
            Some(pool) if self.process == process => pool.in_place_scope(|scope| work(Tasks(Some(scope)))),
            _ => work(Tasks(None)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The thread of each half.
    fn halves() -> [Option<usize>; 2] {
        let thread = rayon_core::current_thread_index;
        Pool(&Progress::default()).join(thread, thread).into()
    }

    #[test]
    fn where_there_are_threads_they_build() {
        assert!(Pool::enter(halves).iter().all(Option::is_some));
    }

    #[test]
    fn where_no_thread_can_be_started_the_caller_builds() {
        // No system has so much memory for a stack.
        let threads = Threads::start(|| ThreadPoolBuilder::new().stack_size(1 << 60));
        assert!(threads.pool.is_none());
        assert_eq!(threads.enter(std::process::id(), halves), [None, None]);
    }

    #[test]
    fn in_a_forked_process_the_caller_builds() {
        let threads = Threads::start(ThreadPoolBuilder::new);
        assert!(threads.pool.is_some());
        assert_eq!(threads.enter(std::process::id() + 1, halves), [None, None]);
    }

    #[test]
    fn tasks_are_done_by_the_threads_or_at_once() {
        let threads = Threads::start(ThreadPoolBuilder::new);
        for (process, elsewhere) in [(std::process::id(), true), (std::process::id() + 1, false)] {
            let mut done = [None; 20];
            threads.with_tasks(process, |tasks| {
                done.iter_mut().for_each(|done| tasks.add(|| *done = Some(rayon_core::current_thread_index())));
            });
            assert!(done.iter().all(|done| done.is_some_and(|thread| thread.is_some() == elsewhere)));
        }
    }
}
