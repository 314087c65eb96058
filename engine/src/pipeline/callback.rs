//! Callbacks, the application's functions that the pipeline calls at fixed places of its loop; and the safe point, which serial ones
//! and transactions get: they may change the state there, ask things of the pipeline, and add callbacks. Hence one file has both.
//!
//! Source: Bigler, Stephens and Parker 2006, section 5.3. The order within a frame: transactions, one-shots, serial
//! animation, resize, changed; parallel animation; serial pre-render; parallel pre-render; the stages. A serial callback
//! runs on one render thread (any of them) while the others stand at the barrier; a parallel one runs on all of them.
//!
//! Before a frame with an animation callback the picture counts as changed; the other callbacks say so themselves, with
//! [`SafePoint::mark_changed`].

use std::sync::Arc;
use std::time::Duration;

use super::channel::Channel;
use super::fault::{Caught, Fault, catch};
use super::moment::{CallbackId, Due, Moment, Parallel, ParallelMoment, Worker, next_id};
use super::threads::{ThreadCountError, check_thread_count};
use crate::image::Size;

type SerialCall<S> = Box<dyn FnMut(&mut SafePoint<'_, S>) + Send>;
type ResizeCall<S> = Box<dyn FnMut(&mut SafePoint<'_, S>, usize, Size) + Send>;
type OnceCall<S> = Box<dyn FnOnce(&mut SafePoint<'_, S>) + Send>;

/// A list of callbacks. Names are for error messages.
pub struct Callbacks<S> {
    serial: Vec<(CallbackId, String, Moment, SerialCall<S>)>,
    resize: Vec<(CallbackId, String, ResizeCall<S>)>,
    once: Vec<(CallbackId, String, Due, OnceCall<S>)>,
    parallel: Vec<Arc<Parallel<S>>>,
    removed: Vec<CallbackId>,
}

impl<S> Callbacks<S> {
    /// Called at the first barrier of each run, before its first frame.
    pub fn setup(
        &mut self,
        name: impl Into<String>,
        call: impl FnMut(&mut SafePoint<'_, S>) + Send + 'static,
    ) -> CallbackId {
        self.add(name, Moment::Setup, call)
    }

    /// Called before each frame, by one thread. While there is an animation callback the pipeline is never idle.
    pub fn serial_animation(
        &mut self,
        name: impl Into<String>,
        call: impl FnMut(&mut SafePoint<'_, S>) + Send + 'static,
    ) -> CallbackId {
        self.add(name, Moment::Animation, call)
    }

    /// Called before each frame, by all render threads at once, after the serial animation callbacks. The frame begins
    /// when all have returned. While there is an animation callback the pipeline is never idle.
    pub fn parallel_animation(
        &mut self,
        name: impl Into<String>,
        call: impl Fn(&Worker<'_, S>) + Send + Sync + 'static,
    ) -> CallbackId {
        self.add_parallel(name, ParallelMoment::Animation, call)
    }

    /// Called before each frame, by one thread, after all animation callbacks.
    pub fn serial_pre_render(
        &mut self,
        name: impl Into<String>,
        call: impl FnMut(&mut SafePoint<'_, S>) + Send + 'static,
    ) -> CallbackId {
        self.add(name, Moment::PreRender, call)
    }

    /// Called before each frame, by all render threads at once, after the serial pre-render callbacks. The stages begin
    /// when all have returned.
    pub fn parallel_pre_render(
        &mut self,
        name: impl Into<String>,
        call: impl Fn(&Worker<'_, S>) + Send + Sync + 'static,
    ) -> CallbackId {
        self.add_parallel(name, ParallelMoment::PreRender, call)
    }

    /// Called once, before frame `frame` (or the next one, if that is past).
    pub fn at_frame(
        &mut self,
        name: impl Into<String>,
        frame: u64,
        call: impl FnOnce(&mut SafePoint<'_, S>) + Send + 'static,
    ) -> CallbackId {
        self.add_once(name, Due::Frame(frame), call)
    }

    /// Called once, at the first barrier at which the pipeline's time has come to `time`.
    pub fn at_time(
        &mut self,
        name: impl Into<String>,
        time: Duration,
        call: impl FnOnce(&mut SafePoint<'_, S>) + Send + 'static,
    ) -> CallbackId {
        self.add_once(name, Due::Time(time), call)
    }

    /// Called with a channel's index and size before its first frame, and before the first frame of each new size.
    pub fn resize(
        &mut self,
        name: impl Into<String>,
        call: impl FnMut(&mut SafePoint<'_, S>, usize, Size) + Send + 'static,
    ) -> CallbackId {
        let id = next_id();
        self.resize.push((id, name.into(), Box::new(call)));
        id
    }

    /// Called before a frame if something changed since the last one.
    pub fn changed(
        &mut self,
        name: impl Into<String>,
        call: impl FnMut(&mut SafePoint<'_, S>) + Send + 'static,
    ) -> CallbackId {
        self.add(name, Moment::Changed, call)
    }

    /// Called when a pipeline that renders on demand has nothing to do, and again after each
    /// [`Config::idle_interval`](super::Config::idle_interval) of idleness.
    pub fn idle(
        &mut self,
        name: impl Into<String>,
        call: impl FnMut(&mut SafePoint<'_, S>) + Send + 'static,
    ) -> CallbackId {
        self.add(name, Moment::Idle, call)
    }

    /// Called once at the end of each run, also after a fault.
    pub fn termination(
        &mut self,
        name: impl Into<String>,
        call: impl FnMut(&mut SafePoint<'_, S>) + Send + 'static,
    ) -> CallbackId {
        self.add(name, Moment::Termination, call)
    }

    /// Removes a callback. One that is gone already is no error.
    pub fn remove(&mut self, id: CallbackId) {
        self.drop_one(id);
        // This list may be an addition to another one, which has the callback.
        self.removed.push(id);
    }

    fn add(
        &mut self,
        name: impl Into<String>,
        moment: Moment,
        call: impl FnMut(&mut SafePoint<'_, S>) + Send + 'static,
    ) -> CallbackId {
        let id = next_id();
        self.serial.push((id, name.into(), moment, Box::new(call)));
        id
    }

    fn add_parallel(
        &mut self,
        name: impl Into<String>,
        moment: ParallelMoment,
        call: impl Fn(&Worker<'_, S>) + Send + Sync + 'static,
    ) -> CallbackId {
        let id = next_id();
        self.parallel.push(Arc::new(Parallel { id, name: name.into(), moment, call: Box::new(call) }));
        id
    }

    fn add_once(
        &mut self,
        name: impl Into<String>,
        due: Due,
        call: impl FnOnce(&mut SafePoint<'_, S>) + Send + 'static,
    ) -> CallbackId {
        let id = next_id();
        self.once.push((id, name.into(), due, Box::new(call)));
        id
    }

    fn drop_one(&mut self, id: CallbackId) {
        self.serial.retain(|callback| callback.0 != id);
        self.resize.retain(|callback| callback.0 != id);
        self.once.retain(|callback| callback.0 != id);
        self.parallel.retain(|callback| callback.id != id);
    }

    /// Takes over what was added and removed at a safe point.
    pub(super) fn merge(&mut self, other: &mut Self) {
        self.serial.append(&mut other.serial);
        self.resize.append(&mut other.resize);
        self.once.append(&mut other.once);
        self.parallel.append(&mut other.parallel);
        for id in other.removed.drain(..).chain(std::mem::take(&mut self.removed)) {
            self.drop_one(id);
        }
    }

    pub(super) fn call(&mut self, moment: Moment, point: &mut SafePoint<'_, S>) -> Result<(), Caught> {
        for (_, name, _, call) in self.serial.iter_mut().filter(|callback| callback.2 == moment) {
            catch(format_args!("callback {name}"), || call(point))?;
        }
        Ok(())
    }

    pub(super) fn call_resize(
        &mut self,
        point: &mut SafePoint<'_, S>,
        channel: usize,
        size: Size,
    ) -> Result<(), Caught> {
        for (_, name, call) in &mut self.resize {
            catch(format_args!("callback {name}"), || call(point, channel, size))?;
        }
        Ok(())
    }

    /// Calls the one-shots that are due. Returns whether there were any.
    pub(super) fn call_due(&mut self, point: &mut SafePoint<'_, S>) -> Result<bool, Caught> {
        let (frame, time) = (point.frame, point.time);
        let mut any = false;
        for (_, name, _, call) in self.once.extract_if(.., |callback| callback.2.is_due(frame, time)) {
            any = true;
            catch(format_args!("callback {name}"), || call(point))?;
        }
        Ok(any)
    }

    pub(super) fn has(&self, moment: Moment) -> bool {
        self.serial.iter().any(|callback| callback.2 == moment)
    }

    pub(super) fn parallel(&self, moment: ParallelMoment) -> Vec<Arc<Parallel<S>>> {
        self.parallel.iter().filter(|callback| callback.moment == moment).cloned().collect()
    }

    /// Whether there is any animation callback.
    pub(super) fn animates(&self) -> bool {
        self.has(Moment::Animation) || self.parallel.iter().any(|callback| callback.moment == ParallelMoment::Animation)
    }

    /// When the next one-shot that waits for a time is due.
    pub(super) fn next_time(&self) -> Option<Duration> {
        let time = |due: &Due| if let Due::Time(time) = due { Some(*time) } else { None };
        self.once.iter().filter_map(|callback| time(&callback.2)).min()
    }
}

impl<S> Default for Callbacks<S> {
    fn default() -> Self {
        Self { serial: Vec::new(), resize: Vec::new(), once: Vec::new(), parallel: Vec::new(), removed: Vec::new() }
    }
}

impl<S> std::fmt::Debug for Callbacks<S> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let serial = self.serial.iter().map(|callback| &callback.1);
        let parallel = self.parallel.iter().map(|callback| &callback.name);
        f.debug_list().entries(serial).entries(parallel).finish()
    }
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

    /// Renders another frame even if the pipeline only renders on demand and nothing has changed: stages may refine the last one, or keep
    /// it.
    pub fn request_frame(&mut self) {
        self.requests.more = true;
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
    pub(super) more: bool,
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
            more: false,
            stop: false,
            threads: None,
            resize: Vec::new(),
            channels: Vec::new(),
            removed: Vec::new(),
            callbacks: Callbacks::default(),
        }
    }
}
