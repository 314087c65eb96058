//! Tickets: how the sender of a transaction learns what became of it.

use std::cell::Cell;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard};
use std::time::{Duration, Instant};

/// Why a transaction was not carried out.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TransactionError {
    /// It panicked. The run has ended with a [`Fault`](super::Fault) of the same name.
    #[error("transaction {name} panicked: {message}")]
    Panicked {
        /// The transaction's name.
        name: String,
        /// What the panic said.
        message: String,
    },
    /// The pipeline stopped before it was its turn.
    #[error("the pipeline stopped before the transaction was carried out")]
    Stopped,
    /// It has not been carried out yet, and is not as long as this thread waits: the thread renders for the pipeline, or is the
    /// one that has to run it.
    #[error("the thread that waits for the transaction is the one that has to carry it out")]
    InVain,
}

/// How long the thread that has a pipeline waits for another one to run it.
const UNTIL_RUN: Duration = Duration::from_secs(2);

/// What the tickets of a pipeline know of it.
#[derive(Debug)]
pub(super) struct Home {
    number: u64,
    /// Somebody runs it, or has run it.
    begun: AtomicBool,
    /// The number of the thread that had the pipeline in its hands last.
    owner: AtomicU64,
}

thread_local! {
    static THREAD: u64 = next_number();
    /// The pipeline that this thread renders for.
    static RENDERS_FOR: Cell<u64> = const { Cell::new(0) };
}

/// From 1 on, each once.
fn next_number() -> u64 {
    static NEXT: AtomicU64 = AtomicU64::new(1);
    // Relaxed: only the numbers must differ.
    NEXT.fetch_add(1, Ordering::Relaxed)
}

impl Home {
    pub(super) fn new() -> Self {
        Self { number: next_number(), begun: AtomicBool::new(false), owner: AtomicU64::new(this_thread()) }
    }

    /// This thread has the pipeline in its hands.
    pub(super) fn owned_here(&self) {
        self.owner.store(this_thread(), Ordering::Relaxed);
    }

    /// Somebody runs it.
    pub(super) fn begin(&self) {
        self.begun.store(true, Ordering::Relaxed);
    }

    /// Renders for this pipeline: what this thread waits for in `work` cannot come.
    pub(super) fn render<R>(&self, work: impl FnOnce() -> R) -> R {
        let before = RENDERS_FOR.replace(self.number);
        let result = work();
        RENDERS_FOR.set(before);
        result
    }

    fn renders_here(&self) -> bool {
        RENDERS_FOR.get() == self.number
    }

    /// Whether nobody runs the pipeline yet and only this thread is known to have it. Relaxed, all: who is told too late looks
    /// again.
    fn waits_for_this_thread(&self) -> bool {
        !self.begun.load(Ordering::Relaxed) && self.owner.load(Ordering::Relaxed) == this_thread()
    }
}

fn this_thread() -> u64 {
    THREAD.with(|number| *number)
}

/// The sender's half: tells when the transaction has been carried out. May be dropped.
#[derive(Clone, Debug)]
pub struct Ticket {
    outcome: Arc<Outcome>,
}

/// The barrier's half: dropped without an answer, it answers [`TransactionError::Stopped`].
pub(super) struct Completer {
    outcome: Option<Arc<Outcome>>,
}

#[derive(Debug)]
struct Outcome {
    state: Mutex<State>,
    bell: Condvar,
    home: Arc<Home>,
}

#[derive(Debug, Default)]
struct State {
    result: Option<Result<u64, TransactionError>>,
    // Ringing a bell is a system call: only when somebody listens.
    waiting: bool,
}

/// A ticket and its other half.
pub(super) fn ticket(home: &Arc<Home>) -> (Ticket, Completer) {
    let outcome = Outcome { state: Mutex::default(), bell: Condvar::new(), home: Arc::clone(home) };
    let outcome = Arc::new(outcome);
    (Ticket { outcome: Arc::clone(&outcome) }, Completer { outcome: Some(outcome) })
}

impl Ticket {
    /// Waits until the transaction has been carried out, and returns the number of the first frame that shows it.
    ///
    /// To wait where the barrier would never be reached is an error, [`TransactionError::InVain`]: at once on a render thread of
    /// the pipeline (in a stage, a transaction, a callback, a display); and on the thread that has the pipeline, if nobody has
    /// begun to run it after two seconds. The transaction stays queued.
    pub fn wait(&self) -> Result<u64, TransactionError> {
        self.wait_until(None).unwrap_or(Err(TransactionError::InVain))
    }

    /// Waits for a limited time; None when it is over.
    pub fn wait_for(&self, limit: Duration) -> Option<Result<u64, TransactionError>> {
        // What lies beyond all times is no limit.
        self.wait_until(Instant::now().checked_add(limit))
    }

    fn wait_until(&self, deadline: Option<Instant>) -> Option<Result<u64, TransactionError>> {
        let Outcome { home, bell, .. } = &*self.outcome;
        let in_vain = Some(Err(TransactionError::InVain));
        let begin = Instant::now() + UNTIL_RUN;
        let mut state = self.outcome.lock();
        loop {
            let now = Instant::now();
            let unbegun = home.waits_for_this_thread();
            if state.result.is_some() {
                return state.result.clone();
            } else if home.renders_here() || unbegun && now >= begin {
                return in_vain;
            } else if deadline.is_some_and(|deadline| now >= deadline) {
                return None;
            }
            state.waiting = true;
            let until = if unbegun { Some(deadline.map_or(begin, |deadline| deadline.min(begin))) } else { deadline };
            state = match until {
                Some(until) => {
                    let waited = bell.wait_timeout(state, until.saturating_duration_since(now));
                    waited.unwrap_or_else(|poisoned| poisoned.into_inner()).0
                }
                None => bell.wait(state).unwrap_or_else(|poisoned| poisoned.into_inner()),
            };
        }
    }

    /// What became of it, if anything has yet.
    pub fn poll(&self) -> Option<Result<u64, TransactionError>> {
        self.outcome.lock().result.clone()
    }
}

impl Completer {
    pub(super) fn complete(mut self, result: Result<u64, TransactionError>) {
        self.answer(result);
    }

    fn answer(&mut self, result: Result<u64, TransactionError>) {
        let Some(outcome) = self.outcome.take() else { return };
        // No ticket is left, and none can be made but from another: nobody will ask.
        if Arc::strong_count(&outcome) == 1 {
            return;
        }
        let mut state = outcome.lock();
        state.result = Some(result);
        let waiting = state.waiting;
        drop(state);
        if waiting {
            outcome.bell.notify_all();
        }
    }
}

impl Drop for Completer {
    fn drop(&mut self) {
        self.answer(Err(TransactionError::Stopped));
    }
}

impl Outcome {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn begun() -> Arc<Home> {
        let home = Home::new();
        home.begin();
        Arc::new(home)
    }

    #[test]
    fn a_dropped_completer_reports_stopped() {
        let (ticket, done) = ticket(&begun());
        assert_eq!(ticket.poll(), None);
        assert_eq!(ticket.wait_for(Duration::from_millis(1)), None);
        drop(done);
        assert_eq!(ticket.wait(), Err(TransactionError::Stopped));
    }

    #[test]
    fn a_waiter_is_woken() {
        let (ticket, done) = ticket(&begun());
        std::thread::scope(|scope| {
            let waiter = scope.spawn(|| ticket.wait());
            std::thread::sleep(Duration::from_millis(5));
            done.complete(Ok(3));
            assert_eq!(waiter.join().unwrap(), Ok(3));
        });
    }
}
