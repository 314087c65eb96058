//! Stages: what a pipeline does with a frame, one after the other, each with a frame buffer of its own.
//!
//! Source: Bigler, Stephens and Parker 2006, section 5.2. A pipeline is a list of stages in the order in which a frame
//! passes through them. In one turn of the loop stage 0 works on frame k, stage 1 on frame k-1, and so on; the turn runs
//! the balanced stages first, then the imbalanced, then the dynamic ones (Figure 3), so that a thread that was busy with
//! an imbalanced stage joins the dynamic one late and simply gets less of it.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use super::channel::Channel;
use super::fault;
use crate::image::{FrameBuffer, Size};

/// How the work of a stage is shared among the render threads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Balance {
    /// Every thread runs the stage and does an equal share.
    Balanced,
    /// One thread per channel runs the stage (channel by channel on different threads), then joins the dynamic stages.
    Imbalanced,
    /// Every thread runs the stage and takes work from it until there is none left.
    Dynamic,
}

/// One stage of a pipeline over the state `S` with buffers `B`.
pub trait Stage<S, B = FrameBuffer>: Send + Sync {
    /// What the stage is called in reports and errors.
    fn name(&self) -> &str;

    /// How its work is shared.
    fn balance(&self) -> Balance;

    /// Called at the barrier before each frame that this stage works on: reset load balancers here.
    fn begin(&mut self, state: &mut S, plan: &Plan<'_>) {
        let _ = (state, plan);
    }

    /// Called during the frame, by the threads that [`balance`](Self::balance) says. Panics and
    /// [`fault::fail`] end the run with a fault.
    fn run(&self, frame: &Frame<'_, S, B>);
}

/// What a stage needs to know before its frame.
#[derive(Clone, Copy, Debug)]
pub struct Plan<'a> {
    /// Number of the frame that the stage will work on.
    pub number: u64,
    /// Time of that frame.
    pub time: Duration,
    /// Whether anything changed since the frame before it: false means that it may be refined.
    pub changed: bool,
    /// Threads that will run.
    pub threads: usize,
    /// Sizes of the channels that take part in a new frame, in the order of [`Frame::channels`] in the first stage.
    pub sizes: &'a [Size],
}

/// A buffer that each stage has one of, for each channel.
pub trait StageBuffer: Send + Sync + 'static {
    /// A buffer for pictures of a size. Called at the barrier when a channel is new or has been resized. Ends the run with
    /// [`fault::fail`] where there is no memory for it.
    fn for_size(size: Size) -> Self;
}

impl StageBuffer for FrameBuffer {
    fn for_size(size: Size) -> Self {
        Self::try_with_size(size).unwrap_or_else(|error| fault::fail(error))
    }
}

/// A stage's view of the frame it works on, in one thread.
pub struct Frame<'a, S, B = FrameBuffer> {
    /// The application's state. All stages of a turn see the same: that of the frame in stage 0.
    pub state: &'a S,
    /// Number of the frame that this stage works on, from 0.
    pub number: u64,
    /// Time of that frame.
    pub time: Duration,
    /// Whether anything changed since the frame before it.
    pub changed: bool,
    /// This thread's index, below `threads`.
    pub thread: usize,
    /// Render threads.
    pub threads: usize,
    pub(super) views: &'a [View<'a, B>],
    pub(super) signals: &'a Signals,
}

/// One channel of a frame.
#[derive(Debug)]
pub struct View<'a, B = FrameBuffer> {
    /// Index of the channel.
    pub index: usize,
    /// The channel as it is now. A frame that is displayed may have been rendered at an older size: see `size`.
    pub channel: &'a Channel,
    /// The size of the picture in `buffer`.
    pub size: Size,
    /// This stage's buffer.
    pub buffer: &'a B,
    /// In stage 0: the buffer with the newest picture of this size before this frame, which may be `buffer` itself. Where
    /// the later stages only read, it is as stage 0 left it. None in later stages.
    pub previous: Option<&'a B>,
}

impl<'a, S, B> Frame<'a, S, B> {
    /// The channels that this call is to work on: all of them, or one in an imbalanced stage.
    pub fn channels(&self) -> &'a [View<'a, B>] {
        self.views
    }

    /// This thread's even share of `0..items`, for balanced stages: the shares of all threads are `0..items`, each once.
    pub fn share(&self, items: usize) -> std::ops::Range<usize> {
        crate::balance::even_share(items, self.thread, self.threads)
    }

    /// Asks for one more frame although nothing changed: for pictures that are refined step by step.
    pub fn request_frame(&self) {
        self.signals.more.store(true, Ordering::Relaxed);
    }

    /// Asks for the end of the run at the next barrier.
    pub fn request_stop(&self) {
        self.signals.stop.store(true, Ordering::Relaxed);
    }

    /// Whether another thread failed or the frame was [given up](super::Handle::halt), so that going on is in vain. Long stages ask between pieces of work.
    pub fn halted(&self) -> bool {
        self.signals.halted.load(Ordering::Relaxed)
    }
}

impl<S, B> std::fmt::Debug for Frame<'_, S, B> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Frame").field("number", &self.number).field("thread", &self.thread).finish_non_exhaustive()
    }
}

/// What running threads tell the next barrier. Relaxed throughout: the barrier orders them, and `halted` is a hint.
#[derive(Debug, Default)]
pub(super) struct Signals {
    pub(super) more: AtomicBool,
    pub(super) stop: AtomicBool,
    /// The same as the senders' of transactions.
    pub(super) halted: Arc<AtomicBool>,
}

/// A stage made of a closure.
struct Closure<F> {
    name: String,
    balance: Balance,
    run: F,
}

impl<S, B, F: Fn(&Frame<'_, S, B>) + Send + Sync> Stage<S, B> for Closure<F> {
    fn name(&self) -> &str {
        &self.name
    }

    fn balance(&self) -> Balance {
        self.balance
    }

    fn run(&self, frame: &Frame<'_, S, B>) {
        (self.run)(frame);
    }
}

/// A stage from a closure.
pub fn stage<S, B>(
    name: impl Into<String>,
    balance: Balance,
    run: impl Fn(&Frame<'_, S, B>) + Send + Sync + 'static,
) -> impl Stage<S, B> + 'static {
    Closure { name: name.into(), balance, run }
}
