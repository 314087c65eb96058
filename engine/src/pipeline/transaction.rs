//! Transactions: changes of the state, queued by any thread and carried out at the barrier.
//!
//! Source: Bigler, Stephens and Parker 2006, section 5.3. Sending is a push onto a lock-free queue: it never waits for
//! rendering. The queue is flushed only at the barrier, by one thread, with exclusive access to the state. Transactions
//! of one sender are carried out in the order in which they were sent.

use std::borrow::Cow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering, fence};
use std::time::Duration;

use crossbeam_queue::SegQueue;
use crossbeam_utils::CachePadded;
use crossbeam_utils::sync::{Parker, Unparker};

use super::callback::SafePoint;
use super::fault::{Caught, catch};
use super::threads::{ThreadCountError, check_thread_count};
use super::ticket::{Completer, Home, Ticket, TransactionError, ticket};
use crate::image::Size;

type Work<S> = Box<dyn FnOnce(&mut SafePoint<'_, S>) + Send>;
type Name = Cow<'static, str>;

/// The sending end of a pipeline: clone it, send it to other threads, change the state with it.
pub struct Handle<S> {
    inbox: Arc<Inbox<S>>,
}

impl<S: 'static> Handle<S> {
    /// Queues a change of the state and marks the picture as changed. The name is for error messages.
    ///
    /// The ticket may be dropped; the transaction is carried out all the same.
    pub fn send(&self, name: impl Into<Name>, change: impl FnOnce(&mut S) + Send + 'static) -> Ticket {
        self.at_barrier(name, move |point| {
            point.mark_changed();
            change(point.state);
        })
    }

    /// Queues work for the barrier with all that can be done there. The picture counts as changed only if the work says
    /// so with [`SafePoint::mark_changed`].
    pub fn at_barrier(
        &self,
        name: impl Into<Name>,
        work: impl FnOnce(&mut SafePoint<'_, S>) + Send + 'static,
    ) -> Ticket {
        self.inbox.send(Body::One(name.into(), Box::new(work)))
    }

    /// Begins a batch: transactions that are carried out together, at one barrier, with nothing between them.
    pub fn batch(&self) -> Batch<'_, S> {
        Batch { inbox: &self.inbox, parts: Vec::new() }
    }

    /// From the next frame on, renders with `threads` threads.
    pub fn set_threads(&self, threads: usize) -> Result<Ticket, ThreadCountError> {
        check_thread_count(threads)?;
        Ok(self.at_barrier("set threads", move |point| point.set_threads(threads).expect("checked by the sender")))
    }

    /// From the next frame on, renders channel `channel` at another size. Unknown channels are ignored.
    pub fn resize(&self, channel: usize, size: Size) -> Ticket {
        self.at_barrier("resize", move |point| point.resize(channel, size))
    }

    /// Ends the run at the next barrier, after the frames that were rendered have been displayed.
    pub fn stop(&self) -> Ticket {
        self.at_barrier("stop", |point| point.stop())
    }

    /// Ends the run at once: the frame that is being rendered is given up between two pieces of work ([`Frame::halted`]) and
    /// is not displayed; nor is what later stages have not begun with. Before a run it ends that; after one it does nothing.
    ///
    /// [`Frame::halted`]: super::Frame::halted
    pub fn halt(&self) {
        // SeqCst: pairs with the stores in `close`. Whichever comes last, nothing is left for the next run.
        self.inbox.halted.store(true, Ordering::SeqCst);
        if self.inbox.closed.load(Ordering::SeqCst) {
            self.inbox.halted.store(false, Ordering::SeqCst);
        }
        self.inbox.wake();
    }

    /// Whether transactions are refused, because the pipeline has stopped.
    pub fn is_stopped(&self) -> bool {
        self.inbox.closed.load(Ordering::Relaxed)
    }

    /// How the run is getting on.
    pub fn progress(&self) -> Progress {
        let progress = &self.inbox.progress;
        Progress {
            frames: progress.frames.load(Ordering::Relaxed),
            frame_seconds: progress.frame_nanoseconds.load(Ordering::Relaxed) as f64 * 1e-9,
            threads: progress.threads.load(Ordering::Relaxed),
        }
    }
}

impl<S> Clone for Handle<S> {
    fn clone(&self) -> Self {
        self.inbox.handles.fetch_add(1, Ordering::Relaxed);
        Self { inbox: Arc::clone(&self.inbox) }
    }
}

impl<S> Drop for Handle<S> {
    fn drop(&mut self) {
        // Release: pairs with the acquire in `nobody_can_send`, so that what this handle sent is seen by whoever finds
        // that it is gone.
        if self.inbox.handles.fetch_sub(1, Ordering::Release) == 1 {
            self.inbox.wake();
        }
    }
}

impl<S> std::fmt::Debug for Handle<S> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Handle").field("queued", &self.inbox.queue.len()).finish_non_exhaustive()
    }
}

/// Transactions that are carried out together; see [`Handle::batch`].
#[must_use = "a batch does nothing until it is sent"]
pub struct Batch<'a, S> {
    inbox: &'a Inbox<S>,
    parts: Vec<(Name, Work<S>)>,
}

impl<S: 'static> Batch<'_, S> {
    /// Adds a change of the state.
    pub fn add(self, name: impl Into<Name>, change: impl FnOnce(&mut S) + Send + 'static) -> Self {
        self.add_at_barrier(name, move |point| {
            point.mark_changed();
            change(point.state);
        })
    }

    /// Adds work as [`Handle::at_barrier`] does.
    pub fn add_at_barrier(
        mut self,
        name: impl Into<Name>,
        work: impl FnOnce(&mut SafePoint<'_, S>) + Send + 'static,
    ) -> Self {
        self.parts.push((name.into(), Box::new(work)));
        self
    }

    /// Queues the batch. One ticket for all of it.
    pub fn send(self) -> Ticket {
        self.inbox.send(Body::Many(self.parts))
    }
}

impl<S> std::fmt::Debug for Batch<'_, S> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Batch").field("parts", &self.parts.len()).finish_non_exhaustive()
    }
}

/// How a run is getting on, as [`Handle::progress`] sees it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Progress {
    /// Frames rendered since the pipeline was made.
    pub frames: u64,
    /// Time from barrier to barrier of the last frame, in seconds.
    pub frame_seconds: f64,
    /// Render threads at present.
    pub threads: usize,
}

/// The queue between the senders and the barrier.
pub(super) struct Inbox<S> {
    queue: CachePadded<SegQueue<Transaction<S>>>,
    /// Set when the pipeline has stopped. Read after a push, so that no transaction is left behind unseen.
    closed: AtomicBool,
    /// The thread at the barrier is asleep, or about to be, since nothing changed.
    asleep: AtomicBool,
    unparker: Unparker,
    handles: AtomicUsize,
    /// What is being done is in vain: a thread failed, or somebody gave up. Relaxed: a hint that the barrier repeats.
    pub(super) halted: Arc<AtomicBool>,
    pub(super) home: Arc<Home>,
    pub(super) progress: CachePadded<Meter>,
}

#[derive(Default)]
pub(super) struct Meter {
    pub(super) frames: AtomicU64,
    pub(super) frame_nanoseconds: AtomicU64,
    pub(super) threads: AtomicUsize,
}

struct Transaction<S> {
    body: Body<S>,
    done: Completer,
}

enum Body<S> {
    One(Name, Work<S>),
    Many(Vec<(Name, Work<S>)>),
}

/// The pipeline's end of the queue. When it is dropped, what is queued is refused.
pub(super) struct Receiver<S>(Arc<Inbox<S>>);

impl<S> Receiver<S> {
    pub(super) fn new(parker: &Parker) -> Self {
        Self(Arc::new(Inbox::new(parker)))
    }

    pub(super) fn handle(&self) -> Handle<S> {
        self.home.owned_here();
        // Relaxed: a handle is counted before anybody can use it.
        self.handles.fetch_add(1, Ordering::Relaxed);
        Handle { inbox: Arc::clone(&self.0) }
    }
}

impl<S> std::ops::Deref for Receiver<S> {
    type Target = Inbox<S>;

    fn deref(&self) -> &Inbox<S> {
        &self.0
    }
}

impl<S> Drop for Receiver<S> {
    fn drop(&mut self) {
        log(self.close());
    }
}

impl<S> Inbox<S> {
    fn new(parker: &Parker) -> Self {
        Self {
            queue: CachePadded::new(SegQueue::new()),
            closed: AtomicBool::new(false),
            asleep: AtomicBool::new(false),
            unparker: parker.unparker().clone(),
            handles: AtomicUsize::new(0),
            halted: Arc::default(),
            home: Arc::new(Home::new()),
            progress: CachePadded::default(),
        }
    }

    fn send(&self, body: Body<S>) -> Ticket {
        let (ticket, done) = ticket(&self.home);
        let transaction = Transaction { body, done };
        if self.closed.load(Ordering::Relaxed) {
            log(transaction.refuse());
            return ticket;
        }
        self.queue.push(transaction);
        // SeqCst fence: pairs with the fences in `close` and `sleep`. Either this thread sees the flag, or the other
        // thread sees the transaction.
        fence(Ordering::SeqCst);
        if self.closed.load(Ordering::Relaxed) {
            log(self.refuse_all());
        } else if self.asleep.load(Ordering::Relaxed) {
            self.unparker.unpark();
        }
        ticket
    }

    /// Carries out what is queued now, in order; what arrives meanwhile waits for the next barrier, so that fast senders
    /// cannot hold up rendering. Returns how many were carried out.
    ///
    /// A panic ends it: the ticket is told, and the transactions behind it stay queued.
    pub(super) fn flush(&self, point: &mut SafePoint<'_, S>) -> Result<usize, Caught> {
        let queued = self.queue.len();
        for _ in 0..queued {
            let Some(Transaction { body, done }) = self.queue.pop() else { break };
            let result = match body {
                Body::One(name, work) => carry_out(name, work, point),
                Body::Many(parts) => {
                    let mut parts = parts.into_iter();
                    let result = parts.try_for_each(|(name, work)| carry_out(name, work, point));
                    // The rest is dropped, which may fail too.
                    if result.is_err() {
                        log(Body::Many(parts.collect()).drop_parts());
                    }
                    result
                }
            };
            if let Err((name, caught)) = result {
                done.complete(Err(TransactionError::Panicked { name: name.into(), message: caught.message.clone() }));
                return Err(caught);
            }
            done.complete(Ok(point.frame));
        }
        Ok(queued)
    }

    pub(super) fn is_empty(&self) -> bool {
        self.queue.is_empty()
    }

    /// Refuses transactions from now on, and those that are queued: the run is over, there is nothing to give up. Returns the
    /// first panic of what was dropped with them.
    pub(super) fn close(&self) -> Option<Caught> {
        self.closed.store(true, Ordering::SeqCst);
        self.halted.store(false, Ordering::SeqCst);
        fence(Ordering::SeqCst); // pairs with the fence in `send`
        self.refuse_all()
    }

    /// Accepts transactions again.
    pub(super) fn open(&self) {
        self.closed.store(false, Ordering::Relaxed);
    }

    fn refuse_all(&self) -> Option<Caught> {
        let mut first = None;
        while let Some(transaction) = self.queue.pop() {
            first = first.or(transaction.refuse());
        }
        first
    }

    /// Sleeps until a transaction arrives, somebody gives up, the last handle is dropped, or the time is over.
    pub(super) fn sleep(&self, parker: &Parker, limit: Option<Duration>) {
        self.asleep.store(true, Ordering::Relaxed);
        fence(Ordering::SeqCst); // pairs with the fences in `send` and `wake`
        if self.is_empty() && !self.halted.load(Ordering::Relaxed) && (limit.is_some() || !self.nobody_can_send()) {
            match limit {
                Some(limit) => parker.park_timeout(limit),
                None => parker.park(),
            }
        }
        self.asleep.store(false, Ordering::Relaxed);
    }

    fn wake(&self) {
        fence(Ordering::SeqCst); // pairs with the fence in `sleep`
        if self.asleep.load(Ordering::Relaxed) {
            self.unparker.unpark();
        }
    }

    /// Whether all handles are gone: then no transaction can come any more.
    pub(super) fn nobody_can_send(&self) -> bool {
        // Acquire: pairs with the release in Handle::drop.
        self.handles.load(Ordering::Acquire) == 0
    }
}

impl<S> Transaction<S> {
    /// Drops it; the ticket is told [`TransactionError::Stopped`]. Returns the first panic of what it held.
    fn refuse(self) -> Option<Caught> {
        let Self { body, done } = self;
        done.complete(Err(TransactionError::Stopped));
        body.drop_parts()
    }
}

impl<S> Body<S> {
    /// Drops each part for itself. Returns the first panic.
    fn drop_parts(self) -> Option<Caught> {
        let drop_one = |(name, work)| catch(format_args!("transaction {name}"), || drop(work)).err();
        match self {
            Self::One(name, work) => drop_one((name, work)),
            Self::Many(parts) => {
                parts.into_iter().filter_map(drop_one).fold(None, |first, caught| first.or(Some(caught)))
            }
        }
    }
}

/// For panics of what nobody waits for any more.
fn log(caught: Option<Caught>) {
    if let Some(Caught { component, message, .. }) = caught {
        log::error!("a refused {component} panicked when it was dropped: {message}");
    }
}

fn carry_out<S>(name: Name, work: Work<S>, point: &mut SafePoint<'_, S>) -> Result<(), (Name, Caught)> {
    catch(format_args!("transaction {name}"), || work(point)).map_err(|caught| (name, caught))
}
