//! What the last thread to reach the barrier does there, alone: transactions, serial callbacks, the next frame.
//!
//! Source: Bigler, Stephens and Parker 2006, sections 5.2 and 5.3.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use crossbeam_utils::sync::Parker;

use super::buffers::{Buffers, Stamp};
use super::callback::{Callbacks, Requests, SafePoint};
use super::channel::Channel;
use super::config::Config;
use super::fault::{Caught, catch};
use super::moment::{Moment, Parallel, ParallelMoment};
use super::report::Stopwatch;
use super::stage::{Plan, Signals, Stage, StageBuffer};
use super::transaction::Receiver;

/// What the render threads do between two crossings of the barrier.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Phase {
    /// Nothing: the run begins.
    Setup,
    /// Parallel animation callbacks.
    Animation,
    /// Parallel pre-render callbacks.
    PreRender,
    /// The stages.
    Turn,
    /// Nothing: the run is over, leave.
    Over,
}

/// A render thread. Its number is its own for ever: a thread that was sent away and is slow to look never takes a
/// newcomer of the same index for itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Member {
    pub(super) index: usize,
    pub(super) number: u64,
}

/// The thread that each run begins with.
pub(super) const FIRST: Member = Member { index: 0, number: 0 };

/// What all render threads read between two crossings, and one of them writes at the barrier.
pub(super) struct Shared<S, B> {
    pub(super) state: S,
    pub(super) channels: Vec<Channel>,
    pub(super) stages: Vec<Box<dyn Stage<S, B>>>,
    pub(super) buffers: Buffers<B>,
    /// The callbacks of a parallel phase.
    pub(super) parallel: Vec<Arc<Parallel<S>>>,
    pub(super) phase: Phase,
    /// The frame in stage 0, or the next one to be there.
    pub(super) frame: u64,
    pub(super) time: Duration,
    /// Who takes part. A thread that is not on the list leaves.
    pub(super) members: Vec<Member>,
    pub(super) pinning: bool,
}

/// What only the thread that works at the barrier touches.
pub(super) struct Leader<S> {
    pub(super) callbacks: Callbacks<S>,
    pub(super) requests: Requests<S>,
    pub(super) parker: Parker,
    /// Channels that no resize callback has heard of.
    pub(super) new_channels: Vec<usize>,
    /// The threads that the next run begins with.
    pub(super) threads: usize,
    pub(super) next_member: u64,
    pub(super) frames_left: u64,
    /// A stage asked for another frame.
    pub(super) more: bool,
    /// The run does not end while a stage asks for another frame.
    pub(super) refine: bool,
    /// The present turn renders a new frame.
    pub(super) rendering: bool,
    /// Time of earlier runs.
    pub(super) earlier: Duration,
    pub(super) run_start: Instant,
    pub(super) turn_start: Instant,
    pub(super) serial: Duration,
    pub(super) slept: Duration,
    pub(super) transactions: u64,
    pub(super) watch: Stopwatch,
}

impl<S> Leader<S> {
    pub(super) fn new(parker: Parker, threads: usize) -> Self {
        let now = Instant::now();
        Self {
            callbacks: Callbacks::default(),
            requests: Requests::default(),
            parker,
            new_channels: Vec::new(),
            threads,
            next_member: 1,
            frames_left: 0,
            more: false,
            refine: false,
            rendering: false,
            earlier: Duration::ZERO,
            run_start: now,
            turn_start: now,
            serial: Duration::ZERO,
            slept: Duration::ZERO,
            transactions: 0,
            watch: Stopwatch::default(),
        }
    }

    /// Makes ready for a run of so many frames.
    pub(super) fn begin_run(&mut self, frames: u64, refine: bool) {
        let now = Instant::now();
        (self.run_start, self.turn_start) = (now, now);
        (self.serial, self.slept) = (Duration::ZERO, Duration::ZERO);
        (self.more, self.rendering, self.transactions) = (false, false, 0);
        self.watch = Stopwatch::default();
        (self.frames_left, self.refine) = (frames, refine);
        self.requests.stop = false;
        self.next_member = FIRST.number + 1;
        self.requests.threads = Some(self.threads);
    }

    /// The safe point, and the callbacks to call with it.
    pub(super) fn point<'a, B>(&'a mut self, shared: &'a mut Shared<S, B>) -> (&'a mut Callbacks<S>, SafePoint<'a, S>) {
        let point = SafePoint {
            state: &mut shared.state,
            frame: shared.frame,
            time: shared.time,
            threads: shared.members.len(),
            channels: &shared.channels,
            requests: &mut self.requests,
            fault: None,
        };
        (&mut self.callbacks, point)
    }

    /// The time of a frame that begins now.
    fn now(&self, frame: u64, frame_time: Option<Duration>) -> Duration {
        match frame_time {
            Some(step) => {
                let nanoseconds = step.as_nanos().saturating_mul(frame.into());
                Duration::from_nanos(u64::try_from(nanoseconds).unwrap_or(u64::MAX))
            }
            None => self.earlier + self.run_start.elapsed(),
        }
    }
}

/// What the work at the barrier needs of the pipeline and of the run.
#[derive(Clone, Copy)]
pub(super) struct Lead<'a, S> {
    pub(super) config: &'a Config,
    pub(super) inbox: &'a Receiver<S>,
    pub(super) signals: &'a Signals,
}

impl<S: Send + Sync + 'static> Lead<'_, S> {
    /// Decides what the render threads do next, and does what comes before it.
    pub(super) fn next_phase<B: StageBuffer>(
        &self,
        shared: &mut Shared<S, B>,
        leader: &mut Leader<S>,
    ) -> Result<Phase, Caught> {
        if self.halted() {
            return Ok(Phase::Over);
        }
        match shared.phase {
            Phase::Setup => {
                leader.requests.changed = true;
                let (callbacks, mut point) = leader.point(shared);
                callbacks.call(Moment::Setup, &mut point)?;
                self.safe_point(shared, leader)
            }
            Phase::Turn => {
                self.finish_turn(shared, leader);
                self.safe_point(shared, leader)
            }
            Phase::Animation => self.pre_render(shared, leader),
            Phase::PreRender => self.begin_turn(shared, leader),
            Phase::Over => Ok(Phase::Over),
        }
    }

    fn halted(&self) -> bool {
        self.signals.halted.load(Ordering::Relaxed)
    }

    fn finish_turn<B: StageBuffer>(&self, shared: &mut Shared<S, B>, leader: &mut Leader<S>) {
        let now = Instant::now();
        let time = now - leader.turn_start;
        leader.turn_start = now;
        if leader.rendering {
            leader.rendering = false;
            leader.watch.record(time);
            shared.frame += 1;
            let meter = &self.inbox.progress;
            meter.frames.store(shared.frame, Ordering::Relaxed);
            meter.frame_nanoseconds.store(time.as_nanos() as u64, Ordering::Relaxed);
        }
        shared.buffers.rotate();
        leader.requests.stop |= self.signals.stop.swap(false, Ordering::Relaxed);
        leader.more |= self.signals.more.swap(false, Ordering::Relaxed);
    }

    /// Transactions and callbacks; sleep if there is nothing to do; then the next frame.
    fn safe_point<B: StageBuffer>(&self, shared: &mut Shared<S, B>, leader: &mut Leader<S>) -> Result<Phase, Caught> {
        let Self { inbox, config, .. } = self;
        loop {
            shared.time = leader.now(shared.frame, config.frame_time);
            let (_, mut point) = leader.point(shared);
            leader.transactions += inbox.flush(&mut point)? as u64;
            if self.halted() {
                return Ok(Phase::Over);
            }
            if leader.requests.stop || (leader.frames_left == 0 && !(leader.refine && leader.more)) {
                return Ok(drain(shared));
            }
            let (callbacks, mut point) = leader.point(shared);
            callbacks.call_due(&mut point)?;
            if is_due(leader, config.on_demand) {
                return self.begin_frame(shared, leader);
            }
            self.apply_requests(shared, leader)?;
            if shared.buffers.in_flight() {
                return Ok(drain(shared));
            }
            if !is_due(leader, true) {
                let (callbacks, mut point) = leader.point(shared);
                callbacks.call(Moment::Idle, &mut point)?;
            }
            if is_due(leader, true) {
                continue;
            }
            let again = leader.callbacks.has(Moment::Idle).then_some(config.idle_interval);
            let wake = leader.callbacks.next_time().filter(|_| config.frame_time.is_none());
            let wake = wake.map(|time| time.saturating_sub(shared.time));
            let limit = [again, wake].into_iter().flatten().min();
            if limit.is_none() && inbox.nobody_can_send() && inbox.is_empty() {
                return Ok(Phase::Over); // nothing can ever change again
            }
            let start = Instant::now();
            inbox.sleep(&leader.parker, limit);
            leader.turn_start = Instant::now();
            leader.slept += leader.turn_start - start;
        }
    }

    fn begin_frame<B: StageBuffer>(&self, shared: &mut Shared<S, B>, leader: &mut Leader<S>) -> Result<Phase, Caught> {
        let (callbacks, mut point) = leader.point(shared);
        callbacks.call(Moment::Animation, &mut point)?;
        self.apply_requests(shared, leader)?;
        if leader.callbacks.animates() {
            leader.requests.changed = true;
        }
        if leader.requests.changed {
            let (callbacks, mut point) = leader.point(shared);
            callbacks.call(Moment::Changed, &mut point)?;
        }
        if leader.requests.stop {
            return Ok(drain(shared));
        }
        let callbacks = leader.callbacks.parallel(ParallelMoment::Animation);
        if callbacks.is_empty() {
            return self.pre_render(shared, leader);
        }
        shared.parallel = callbacks;
        Ok(Phase::Animation)
    }

    fn pre_render<B: StageBuffer>(&self, shared: &mut Shared<S, B>, leader: &mut Leader<S>) -> Result<Phase, Caught> {
        let (callbacks, mut point) = leader.point(shared);
        callbacks.call(Moment::PreRender, &mut point)?;
        let callbacks = leader.callbacks.parallel(ParallelMoment::PreRender);
        if callbacks.is_empty() {
            return self.begin_turn(shared, leader);
        }
        shared.parallel = callbacks;
        Ok(Phase::PreRender)
    }

    fn begin_turn<B: StageBuffer>(&self, shared: &mut Shared<S, B>, leader: &mut Leader<S>) -> Result<Phase, Caught> {
        let stamp = Stamp { number: shared.frame, time: shared.time, changed: leader.requests.changed };
        leader.requests.changed = false;
        leader.requests.more = false;
        leader.more = false;
        leader.rendering = true;
        leader.frames_left = leader.frames_left.saturating_sub(1);
        shared.parallel.clear();
        catch("frame buffer", || shared.buffers.begin(stamp, &shared.channels))?;
        Ok(Phase::Turn)
    }

    /// Carries out what was asked of the pipeline, except for thread counts and the end.
    fn apply_requests<B: StageBuffer>(&self, shared: &mut Shared<S, B>, leader: &mut Leader<S>) -> Result<(), Caught> {
        leader.callbacks.merge(&mut leader.requests.callbacks);
        let mut resized = std::mem::take(&mut leader.new_channels);
        for channel in std::mem::take(&mut leader.requests.channels) {
            resized.push(shared.channels.len());
            shared.buffers.add_channel();
            shared.channels.push(channel);
        }
        for (index, size) in std::mem::take(&mut leader.requests.resize) {
            if let Some(channel) = shared.channels.get_mut(index).filter(|channel| channel.size != size) {
                channel.size = size;
                resized.push(index);
            }
        }
        for index in std::mem::take(&mut leader.requests.removed) {
            if let Some(channel) = shared.channels.get_mut(index).filter(|channel| channel.open) {
                channel.open = false;
                leader.requests.changed = true;
            }
        }
        resized.retain(|&index| shared.channels[index].open);
        resized.sort_unstable();
        resized.dedup();
        for index in resized {
            leader.requests.changed = true;
            let size = shared.channels[index].size;
            let (callbacks, mut point) = leader.point(shared);
            callbacks.call_resize(&mut point, index, size)?;
        }
        Ok(())
    }

    /// Lets the stages prepare for the turn.
    pub(super) fn begin_stages<B: StageBuffer>(&self, shared: &mut Shared<S, B>) -> Result<(), Caught> {
        let Shared { state, stages, buffers, channels, members, .. } = shared;
        // As `Frame::channels` has them: in the first stage, those that are open.
        let sizes: Vec<_> = channels.iter().filter(|channel| channel.open).map(|channel| channel.size).collect();
        for (index, stage) in stages.iter_mut().enumerate() {
            let Some(Stamp { number, time, changed }) = buffers.stamp(index) else { continue };
            let plan = Plan { number, time, changed, threads: members.len(), sizes: &sizes };
            let name = stage.name().to_owned();
            catch(name, || stage.begin(state, &plan))?;
        }
        Ok(())
    }
}

/// No new frame: let those on their way pass through, if there are any.
fn drain<S, B: StageBuffer>(shared: &Shared<S, B>) -> Phase {
    if shared.buffers.in_flight() { Phase::Turn } else { Phase::Over }
}

/// Whether a new frame should be rendered, or the run ended.
fn is_due<S>(leader: &Leader<S>, on_demand: bool) -> bool {
    let Requests { changed, more, stop, threads, .. } = &leader.requests;
    !on_demand || *changed || *more || *stop || threads.is_some() || leader.more || leader.callbacks.animates()
}
