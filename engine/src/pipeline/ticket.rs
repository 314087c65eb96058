//! Tickets: how the sender of a transaction learns what became of it.

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

#[derive(Debug, Default)]
struct Outcome {
    state: Mutex<State>,
    bell: Condvar,
}

#[derive(Debug, Default)]
struct State {
    result: Option<Result<u64, TransactionError>>,
    // Ringing a bell is a system call: only when somebody listens.
    waiting: bool,
}

/// A ticket and its other half.
pub(super) fn ticket() -> (Ticket, Completer) {
    let outcome = Arc::<Outcome>::default();
    (Ticket { outcome: Arc::clone(&outcome) }, Completer { outcome: Some(outcome) })
}

impl Ticket {
    /// Waits until the transaction has been carried out, and returns the number of the first frame that shows it.
    ///
    /// Do not call this on a render thread, nor on the thread that is to call `run`: the barrier would never be reached.
    pub fn wait(&self) -> Result<u64, TransactionError> {
        let mut state = self.outcome.lock();
        loop {
            if let Some(result) = &state.result {
                return result.clone();
            }
            state.waiting = true;
            state = self.outcome.bell.wait(state).unwrap_or_else(|poisoned| poisoned.into_inner());
        }
    }

    /// Waits for a limited time; None when it is over.
    pub fn wait_for(&self, limit: Duration) -> Option<Result<u64, TransactionError>> {
        let deadline = Instant::now() + limit;
        let mut state = self.outcome.lock();
        loop {
            let left = deadline.saturating_duration_since(Instant::now());
            if state.result.is_some() || left.is_zero() {
                return state.result.clone();
            }
            state.waiting = true;
            state = self.outcome.bell.wait_timeout(state, left).unwrap_or_else(|poisoned| poisoned.into_inner()).0;
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

    #[test]
    fn a_dropped_completer_reports_stopped() {
        let (ticket, done) = ticket();
        assert_eq!(ticket.poll(), None);
        assert_eq!(ticket.wait_for(Duration::from_millis(1)), None);
        drop(done);
        assert_eq!(ticket.wait(), Err(TransactionError::Stopped));
    }

    #[test]
    fn a_waiter_is_woken() {
        let (ticket, done) = ticket();
        std::thread::scope(|scope| {
            let waiter = scope.spawn(|| ticket.wait());
            std::thread::sleep(Duration::from_millis(5));
            done.complete(Ok(3));
            assert_eq!(waiter.join().unwrap(), Ok(3));
        });
    }
}
