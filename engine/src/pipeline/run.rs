//! The render threads: how they come, what each does between two crossings of the barrier, how they leave.
//!
//! Source: Bigler, Stephens and Parker 2006, section 5.2, Figures 2 and 3.

use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex, PoisonError, RwLock, RwLockReadGuard, RwLockWriteGuard};
use std::thread::{Builder, Scope};
use std::time::{Duration, Instant};

use super::barrier::{Barrier, Pass, Turn};
use super::config::Config;
use super::fault::{Fault, catch};
use super::lead::{FIRST, Lead, Leader, Member, Phase, Shared};
use super::moment::Worker;
use super::report::{Report, Tally};
use super::stage::{Balance, Frame, Signals, StageBuffer};
use super::threads::{cores, may_pin, pin_current};
use super::transaction::Receiver;

/// What a run needs of its pipeline.
pub(super) struct Parts<'p, S, B> {
    pub(super) config: &'p Config,
    pub(super) inbox: &'p Receiver<S>,
    pub(super) shared: &'p RwLock<Shared<S, B>>,
    pub(super) leader: &'p Mutex<Leader<S>>,
}

/// What belongs to one run.
pub(super) struct Run<'p, S, B> {
    pipeline: Parts<'p, S, B>,
    barrier: Barrier,
    signals: Signals,
    fault: Mutex<Option<Fault>>,
    report: Mutex<Report>,
}

impl<'p, S: Send + Sync + 'static, B: StageBuffer> Run<'p, S, B> {
    pub(super) fn new(pipeline: Parts<'p, S, B>, report: Report) -> Self {
        let signals = Signals { halted: Arc::clone(&pipeline.inbox.halted), ..Signals::default() };
        Self { pipeline, barrier: Barrier::new(1), signals, fault: Mutex::new(None), report: Mutex::new(report) }
    }

    /// Runs until the run is over. It begins with one thread, which sends for the others at its first safe point. The
    /// calling thread only waits, so that its affinity and its thread-local values stay as they are; where no thread is to be
    /// had it is itself the one.
    pub(super) fn drive(self) -> (Report, Option<Fault>) {
        std::thread::scope(|threads| {
            if let Err(error) = self.spawn(threads, FIRST, None) {
                self.note(format!("no render thread could be started, so the calling thread renders: {error}"));
                self.write().pinning = false;
                self.live(threads, FIRST, None);
            }
        });
        let report = self.report.into_inner().unwrap_or_else(PoisonError::into_inner);
        (report, self.fault.into_inner().unwrap_or_else(PoisonError::into_inner))
    }

    fn spawn<'scope>(
        &'scope self,
        threads: &'scope Scope<'scope, '_>,
        member: Member,
        pass: Option<Pass>,
    ) -> std::io::Result<()> {
        let mut builder = Builder::new().name(format!("render {}", member.index));
        if let Some(bytes) = self.pipeline.config.stack_size {
            builder = builder.stack_size(bytes);
        }
        builder.spawn_scoped(threads, move || self.live(threads, member, pass))?;
        Ok(())
    }

    fn live<'scope>(&'scope self, threads: &'scope Scope<'scope, '_>, member: Member, pass: Option<Pass>) {
        let home = &self.pipeline.inbox.home;
        if let Err(caught) = home.render(|| catch("pipeline", || self.work(threads, member, pass))) {
            self.give_up(caught.at(member.index, 0));
        }
    }

    /// The life of a render thread.
    fn work<'scope>(&'scope self, threads: &'scope Scope<'scope, '_>, member: Member, pass: Option<Pass>) {
        let index = member.index;
        if pass.is_some_and(|pass| self.barrier.join(pass).is_err()) {
            return;
        }
        let pinning = self.read().pinning;
        let pinned = if pinning { pin_current() } else { None };
        if pinning && pinned.is_none() {
            self.note(format!("thread {index} is not pinned: no core is free, or the system refused"));
        }
        let mut tally = Tally::default();
        loop {
            let start = Instant::now();
            let shared = self.read();
            if shared.phase == Phase::Over || shared.members.get(index) != Some(&member) {
                break;
            }
            let done = self.run_phase(&shared, index, &mut tally);
            drop(shared);
            let arrived = Instant::now();
            tally.busy += arrived - start;
            if let Err(fault) = done {
                self.give_up(fault);
                break;
            }
            let mut serial = Duration::ZERO;
            let crossed = self.barrier.cross(index, |turn| serial = self.lead(turn, threads, index));
            tally.serial += serial;
            tally.waiting += arrived.elapsed().saturating_sub(serial);
            if crossed.is_err() {
                break;
            }
        }
        self.report.lock().unwrap_or_else(PoisonError::into_inner).add(index, pinned.is_some(), &tally);
    }

    fn run_phase(&self, shared: &Shared<S, B>, thread: usize, tally: &mut Tally) -> Result<(), Fault> {
        match shared.phase {
            Phase::Setup | Phase::Over => Ok(()),
            Phase::Animation | Phase::PreRender => {
                let (state, threads) = (&shared.state, shared.members.len());
                let worker = Worker { state, thread, threads, frame: shared.frame, time: shared.time };
                let called = shared.parallel.iter().try_for_each(|callback| callback.call(&worker));
                called.map_err(|caught| caught.at(thread, shared.frame))
            }
            Phase::Turn => self.run_turn(shared, thread, tally),
        }
    }

    /// One turn of the loop: each stage works on its own frame, in the order of Figure 3.
    fn run_turn(&self, shared: &Shared<S, B>, thread: usize, tally: &mut Tally) -> Result<(), Fault> {
        let mut imbalanced = 0;
        for balance in [Balance::Balanced, Balance::Imbalanced, Balance::Dynamic] {
            for (index, stage) in shared.stages.iter().enumerate().filter(|stage| stage.1.balance() == balance) {
                let Some(stamp) = shared.buffers.stamp(index) else { continue };
                let views = shared.buffers.views(index, &shared.channels);
                // In an imbalanced stage each channel is the task of one thread; any other is one task of all.
                let alone = balance == Balance::Imbalanced;
                let tasks = if alone { views.len() } else { 1 };
                for task in 0..tasks {
                    let views = if alone { &views[task..=task] } else { &views[..] };
                    let mine = !alone || imbalanced % shared.members.len() == thread;
                    imbalanced += usize::from(alone);
                    if !mine {
                        continue;
                    }
                    let frame = Frame {
                        state: &shared.state,
                        number: stamp.number,
                        time: stamp.time,
                        changed: stamp.changed,
                        thread,
                        threads: shared.members.len(),
                        views,
                        signals: &self.signals,
                    };
                    let start = Instant::now();
                    let done = catch(stage.name(), || stage.run(&frame));
                    tally.add_stage(index, start.elapsed());
                    done.map_err(|caught| caught.at(thread, stamp.number))?;
                }
            }
        }
        Ok(())
    }

    /// The work of the last thread to arrive, while all others wait. Returns the time it took.
    fn lead<'scope>(&'scope self, turn: &mut Turn<'_>, threads: &'scope Scope<'scope, '_>, thread: usize) -> Duration {
        let start = Instant::now();
        let mut shared = self.write();
        let mut leader = self.pipeline.leader.lock().unwrap_or_else(PoisonError::into_inner);
        let slept = leader.slept;
        let lead = Lead { config: self.pipeline.config, inbox: self.pipeline.inbox, signals: &self.signals };
        let mut next = lead.next_phase(&mut shared, &mut leader);
        if let Ok(phase @ (Phase::Animation | Phase::PreRender | Phase::Turn)) = next {
            self.change_threads(turn, threads, &mut shared, &mut leader);
            if phase == Phase::Turn {
                next = lead.begin_stages(&mut shared).map(|()| Phase::Turn);
            }
        }
        shared.phase = next.unwrap_or_else(|caught| {
            self.note_fault(caught.at(thread, shared.frame));
            Phase::Over
        });
        let serial = start.elapsed().saturating_sub(leader.slept - slept);
        leader.serial += serial;
        serial
    }

    /// Sends for threads, or sends some away, if that was asked for. All are exchanged when pinning has to change, since
    /// a thread cannot be unpinned.
    fn change_threads<'scope>(
        &'scope self,
        turn: &mut Turn<'_>,
        threads: &'scope Scope<'scope, '_>,
        shared: &mut Shared<S, B>,
        leader: &mut Leader<S>,
    ) {
        let Some(wanted) = leader.requests.threads.take() else { return };
        leader.threads = wanted;
        let pinning = self.pipeline.config.pin && may_pin(wanted);
        let keep = if pinning == shared.pinning { shared.members.len().min(wanted) } else { 0 };
        let mut members = shared.members[..keep].to_vec();
        for index in keep..wanted {
            let member = Member { index, number: leader.next_member };
            leader.next_member += 1;
            if let Err(error) = self.spawn(threads, member, Some(turn.pass(index))) {
                self.note(format!("only {index} of {wanted} threads could be started: {error}"));
                break;
            }
            members.push(member);
        }
        if members.is_empty() {
            return; // none could be started: the old ones stay
        }
        let count = members.len();
        (shared.members, shared.pinning) = (members, pinning);
        turn.set_threads(count);
        self.pipeline.inbox.progress.threads.store(count, Ordering::Relaxed);
        if self.pipeline.config.pin && !pinning {
            self.note(format!("{count} threads are not pinned: there are {} cores", cores().len()));
        }
        if count > cores().len().max(1) {
            self.report.lock().unwrap_or_else(PoisonError::into_inner).oversubscribed = true;
        }
    }

    fn note(&self, note: String) {
        let mut report = self.report.lock().unwrap_or_else(PoisonError::into_inner);
        if !report.notes.contains(&note) {
            report.notes.push(note);
        }
    }

    /// Keeps the first fault. (It is logged when all have left: a logger may fail too.)
    fn note_fault(&self, fault: Fault) {
        self.fault.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(fault);
    }

    /// Ends the run at once, from a thread that will not reach the barrier.
    fn give_up(&self, fault: Fault) {
        self.note_fault(fault);
        self.signals.halted.store(true, Ordering::Relaxed);
        self.barrier.abort();
    }

    // By the protocol these locks are free when they are asked for: readers hold theirs between two crossings, the
    // writer holds its own while all others stand at the barrier. They are there so that the compiler need not be told.
    fn read(&self) -> RwLockReadGuard<'_, Shared<S, B>> {
        self.pipeline.shared.read().unwrap_or_else(PoisonError::into_inner)
    }

    fn write(&self) -> RwLockWriteGuard<'_, Shared<S, B>> {
        self.pipeline.shared.write().unwrap_or_else(PoisonError::into_inner)
    }
}
