//! What serial work at the barrier may do: change the state, and ask things of the pipeline.
//!
//! Source: Bigler, Stephens and Parker 2006, section 5.3 ("code that modifies state at a *safe* time").

use std::time::Duration;

use super::callback::Callbacks;
use super::fault::Fault;
use super::threads::{ThreadCountError, check_thread_count};
use crate::image::Size;

/// A viewpoint: what is rendered into one picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Channel {
    /// Its name, for messages.
    pub name: String,
    /// The size of its picture.
    pub size: Size,
    /// Whether frames are still rendered for it. A channel that was removed keeps its index.
    pub open: bool,
}

/// The state and the pipeline, while all render threads stand at the barrier.
///
/// Transactions and serial callbacks get this. Requests to the pipeline take effect before the next frame.
pub struct SafePoint<'a, S> {
    /// The application's state.
    pub state: &'a mut S,
    /// Number of the next frame, from 0.
    pub frame: u64,
    /// Time of the next frame since the pipeline first ran (see [`Config::frame_time`](super::Config::frame_time)).
    pub time: Duration,
    /// Render threads at present.
    pub threads: usize,
    pub(super) channels: &'a [Channel],
    pub(super) requests: &'a mut Requests<S>,
    pub(super) fault: Option<&'a Fault>,
}

impl<S> SafePoint<'_, S> {
    /// The picture is out of date: render another frame even if the pipeline only renders on demand, and tell the
    /// stages that this frame is not a refinement of the last one.
    pub fn mark_changed(&mut self) {
        self.requests.changed = true;
    }

    /// Ends the run before the next frame; frames that were rendered are still displayed.
    pub fn stop(&mut self) {
        self.requests.stop = true;
    }

    /// From the next frame on, renders with `threads` threads.
    pub fn set_threads(&mut self, threads: usize) -> Result<(), ThreadCountError> {
        check_thread_count(threads)?;
        self.requests.threads = Some(threads);
        Ok(())
    }

    /// From the next frame on, renders a channel at another size. Unknown channels are ignored.
    pub fn resize(&mut self, channel: usize, size: Size) {
        self.requests.resize.push((channel, size));
    }

    /// From the next frame on, renders one more channel; returns its index.
    pub fn add_channel(&mut self, name: impl Into<String>, size: Size) -> usize {
        self.requests.channels.push(Channel { name: name.into(), size, open: true });
        self.channels.len() + self.requests.channels.len() - 1
    }

    /// From the next frame on, renders no frames for a channel; those on their way are still shown. No other channel changes
    /// its index. Unknown channels are ignored.
    pub fn remove_channel(&mut self, channel: usize) {
        self.requests.removed.push(channel);
    }

    /// The channels at present, those that were removed too.
    pub fn channels(&self) -> &[Channel] {
        self.channels
    }

    /// Adds and removes callbacks, from the next frame on.
    pub fn callbacks(&mut self) -> &mut Callbacks<S> {
        &mut self.requests.callbacks
    }

    /// In a termination callback: why the run ended, if something failed. The state may be half changed then.
    pub fn fault(&self) -> Option<&Fault> {
        self.fault
    }
}

impl<S: std::fmt::Debug> std::fmt::Debug for SafePoint<'_, S> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("SafePoint").field("state", &self.state).field("frame", &self.frame).finish_non_exhaustive()
    }
}

/// What was asked of the pipeline at a safe point.
pub(super) struct Requests<S> {
    pub(super) changed: bool,
    pub(super) stop: bool,
    pub(super) threads: Option<usize>,
    pub(super) resize: Vec<(usize, Size)>,
    pub(super) channels: Vec<Channel>,
    pub(super) removed: Vec<usize>,
    pub(super) callbacks: Callbacks<S>,
}

impl<S> Default for Requests<S> {
    fn default() -> Self {
        Self {
            changed: false,
            stop: false,
            threads: None,
            resize: Vec::new(),
            channels: Vec::new(),
            removed: Vec::new(),
            callbacks: Callbacks::default(),
        }
    }
}
