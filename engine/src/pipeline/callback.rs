//! Callbacks: the application's functions that the pipeline calls at fixed places of its loop.
//!
//! Source: Bigler, Stephens and Parker 2006, section 5.3. The order within a frame: transactions, one-shots, serial
//! animation, resize, changed; parallel animation; serial pre-render; parallel pre-render; the stages. A serial callback
//! runs on one render thread (any of them) while the others stand at the barrier; a parallel one runs on all of them.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use super::fault::{Caught, catch};
use super::safe_point::SafePoint;
use crate::image::Size;

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

type SerialCall<S> = Box<dyn FnMut(&mut SafePoint<'_, S>) + Send>;
type ResizeCall<S> = Box<dyn FnMut(&mut SafePoint<'_, S>, usize, Size) + Send>;
type OnceCall<S> = Box<dyn FnOnce(&mut SafePoint<'_, S>) + Send>;
type ParallelCall<S> = Box<dyn Fn(&Worker<'_, S>) + Send + Sync>;

/// A list of callbacks. Names are for error messages.
pub struct Callbacks<S> {
    serial: Vec<(CallbackId, String, Moment, SerialCall<S>)>,
    resize: Vec<(CallbackId, String, ResizeCall<S>)>,
    once: Vec<(CallbackId, String, Due, OnceCall<S>)>,
    parallel: Vec<Arc<Parallel<S>>>,
    removed: Vec<CallbackId>,
}

/// A parallel callback, shared with the render threads during its phase.
pub(super) struct Parallel<S> {
    id: CallbackId,
    name: String,
    moment: ParallelMoment,
    call: ParallelCall<S>,
}

#[derive(Clone, Copy, Debug)]
enum Due {
    Frame(u64),
    Time(Duration),
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

impl<S> Parallel<S> {
    pub(super) fn call(&self, worker: &Worker<'_, S>) -> Result<(), Caught> {
        catch(format_args!("callback {}", self.name), || (self.call)(worker))
    }
}

impl Due {
    fn is_due(self, frame: u64, time: Duration) -> bool {
        match self {
            Self::Frame(due) => frame >= due,
            Self::Time(due) => time >= due,
        }
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

fn next_id() -> CallbackId {
    static NEXT: AtomicU64 = AtomicU64::new(0);
    // Relaxed: only uniqueness matters.
    CallbackId(NEXT.fetch_add(1, Ordering::Relaxed))
}
