//! The parallel pipeline: threads, stages, transactions, callbacks. It knows nothing of rays.
//!
//! Source: Bigler, Stephens and Parker 2006, sections 5.2 and 5.3.
//!
//! A [`Pipeline`] owns the application's state and runs frames through a list of [`Stage`]s. Its render threads share the
//! state while they work and meet at one [`barrier`] at the end of each turn. There, and only there, one of them changes
//! the state: it carries out the transactions that other threads have sent through a [`Handle`], and calls the serial
//! [`Callbacks`]. `README.md` beside this module explains the protocol.
//!
//! | file | idea |
//! |---|---|
//! | [`barrier`] | where the threads meet |
//! | `run`, `lead` | the loop of a render thread; what the last to arrive does at the barrier |
//! | [`mod@stage`], [`mod@display`], `buffers`, `channel` | what is done with a frame, and where its pictures are |
//! | `transaction`, `ticket` | how other threads change the state, and hear of it |
//! | [`callback`], `moment` | how the application takes part in the loop |
//! | [`fault`] | how a panic becomes an error that names a component |
//! | [`threads`], `config`, `report` | thread counts and pinning; settings; what a run took |
//!
//! ```
//! use mobula::image::{Size, rgba8};
//! use mobula::pipeline::{Balance, Config, DisplayStage, Frame, NullDisplay, Pipeline, stage};
//!
//! let mut pipeline = Pipeline::new(0_u8, Config::with_threads(2))?;
//! pipeline.add_channel("main", Size::new(64, 48)?);
//! pipeline.add_stage(stage("render", Balance::Balanced, |frame: &Frame<'_, u8>| {
//!     let picture = frame.channels()[0].buffer;
//!     for y in frame.share(picture.height()) {
//!         picture.set_row(0, y, &[rgba8(*frame.state, 0, 0, 255); 64]);
//!     }
//! }));
//! pipeline.add_stage(DisplayStage::new().with(0, NullDisplay));
//! pipeline.callbacks().at_frame("brighten", 2, |point| *point.state = 200);
//!
//! let handle = pipeline.handle();
//! let sender = std::thread::spawn(move || handle.send("dim", |red| *red = 100).wait());
//! let report = pipeline.run(10)?;
//! assert_eq!(report.frames, 10);
//! match sender.join().expect("the sender does not panic") {
//!     Ok(frame) => println!("frame {frame} is the first dim one"),
//!     Err(error) => println!("too late: {error}"),
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod barrier;
mod buffers;
pub mod callback;
mod channel;
mod config;
pub mod display;
pub mod fault;
mod lead;
mod moment;
mod report;
mod run;
pub mod stage;
mod sync;
pub mod threads;
mod ticket;
mod transaction;

use std::sync::{Mutex, PoisonError, RwLock};
use std::time::Duration;

use crossbeam_utils::sync::Parker;

pub use callback::{Callbacks, SafePoint};
pub use channel::Channel;
pub use config::Config;
pub use display::{Display, DisplayStage, NullDisplay, Picture, Shown, display};
pub use fault::Fault;
pub use moment::{CallbackId, Worker};
pub use report::{FrameTimes, Report, StageReport, ThreadReport};
pub use stage::{Balance, Frame, Plan, Stage, StageBuffer, View, stage};
pub use threads::{MAX_THREADS, ThreadCountError};
pub use ticket::{Ticket, TransactionError};
pub use transaction::{Batch, Handle, Progress};

use crate::image::{FrameBuffer, Size};
use buffers::Buffers;
use lead::{FIRST, Leader, Phase, Shared};
use moment::Moment;
use run::{Parts, Run};
use transaction::Receiver;

/// A parallel pipeline over the application's state `S`, with a buffer `B` for each stage and channel.
pub struct Pipeline<S, B = FrameBuffer> {
    config: Config,
    inbox: Receiver<S>,
    shared: RwLock<Shared<S, B>>,
    leader: Mutex<Leader<S>>,
    fault: Option<Fault>,
}

impl<S: Send + Sync + 'static> Pipeline<S> {
    /// A pipeline without channels and stages, with [`FrameBuffer`]s. Errors when the thread count is out of range.
    pub fn new(state: S, config: Config) -> Result<Self, ThreadCountError> {
        Self::with_buffers(state, config)
    }
}

impl<S: Send + Sync + 'static, B: StageBuffer> Pipeline<S, B> {
    /// A pipeline as [`new`](Pipeline::new) makes it, with buffers of another type.
    pub fn with_buffers(state: S, config: Config) -> Result<Self, ThreadCountError> {
        config.check()?;
        threads::cores();
        if config.quiet_panics {
            fault::install_quiet_hook();
        }
        let parker = Parker::new();
        let shared = Shared {
            state,
            channels: Vec::new(),
            stages: Vec::new(),
            buffers: Buffers::new(),
            parallel: Vec::new(),
            phase: Phase::Setup,
            frame: 0,
            time: Duration::ZERO,
            members: vec![FIRST],
            pinning: false,
        };
        Ok(Self {
            inbox: Receiver::new(&parker),
            shared: RwLock::new(shared),
            leader: Mutex::new(Leader::new(parker, config.threads)),
            fault: None,
            config,
        })
    }

    /// Adds a viewpoint; returns its index. (While running: [`SafePoint::add_channel`].)
    pub fn add_channel(&mut self, name: impl Into<String>, size: Size) -> usize {
        let (shared, leader) = self.parts();
        let index = shared.channels.len();
        shared.channels.push(Channel { name: name.into(), size, open: true });
        shared.buffers.add_channel();
        leader.new_channels.push(index);
        index
    }

    /// Adds a stage behind the others: it works on the frames that they are done with.
    pub fn add_stage(&mut self, stage: impl Stage<S, B> + 'static) {
        let (shared, _) = self.parts();
        shared.stages.push(Box::new(stage));
        shared.buffers.add_stage(&shared.channels);
    }

    /// A handle for sending transactions, before and during a run, from any thread.
    pub fn handle(&self) -> Handle<S> {
        self.inbox.handle()
    }

    /// The callbacks. (While running: [`SafePoint::callbacks`].)
    pub fn callbacks(&mut self) -> &mut Callbacks<S> {
        &mut self.parts().1.callbacks
    }

    /// How many threads the next run begins with. (While running: [`Handle::set_threads`].) Errors when there cannot be so
    /// many.
    pub fn set_threads(&mut self, threads: usize) -> Result<(), ThreadCountError> {
        threads::check_thread_count(threads)?;
        self.parts().1.threads = threads;
        Ok(())
    }

    /// The state, between runs.
    pub fn state(&mut self) -> &mut S {
        &mut self.parts().0.state
    }

    /// The state, when the pipeline is no longer needed.
    pub fn into_state(self) -> S {
        self.shared.into_inner().unwrap_or_else(PoisonError::into_inner).state
    }

    /// The newest picture of a channel and the number of its frame, between runs.
    pub fn picture(&mut self, channel: usize) -> Option<(u64, &B)> {
        self.parts().0.buffers.newest(channel)
    }

    /// Renders `frames` frames, or until somebody stops it, and returns when all of them have passed through all stages.
    ///
    /// Transactions that were sent before the first run are carried out before its first frame. When a run ends,
    /// queued and later transactions are refused ([`TransactionError::Stopped`]) until the next run begins. A fault ends
    /// the pipeline for good: every later run returns the same fault at once; the state can still be taken out.
    pub fn run(&mut self, frames: u64) -> Result<Report, Fault> {
        self.run_on(frames, false)
    }

    /// As [`run`](Self::run), and goes on until no stage asks for another frame ([`Frame::request_frame`]): pictures that are
    /// refined from frame to frame are finished.
    pub fn run_refined(&mut self, frames: u64) -> Result<Report, Fault> {
        self.run_on(frames, true)
    }

    fn run_on(&mut self, frames: u64, refine: bool) -> Result<Report, Fault> {
        if let Some(fault) = &self.fault {
            return Err(fault.clone());
        }
        self.begin_run(frames, refine);
        let stages = self.parts().0.stages.iter();
        let stages = stages.map(|stage| StageReport::new(stage.name(), stage.balance())).collect();
        let report = Report { stages, ..Report::default() };
        let Self { config, inbox, shared, leader, .. } = self;
        let (report, fault) = Run::new(Parts { config, inbox, shared, leader }, report).drive();
        self.end_run(report, fault)
    }

    /// Renders until somebody stops it: [`Handle::stop`], [`SafePoint::stop`], [`Frame::request_stop`].
    pub fn run_until_stopped(&mut self) -> Result<Report, Fault> {
        self.run(u64::MAX)
    }

    fn begin_run(&mut self, frames: u64, refine: bool) {
        let pin = self.config.pin;
        self.inbox.home.begin();
        self.inbox.open();
        let (shared, leader) = self.parts();
        leader.begin_run(frames, refine);
        shared.pinning = pin && threads::may_pin(leader.threads);
        shared.phase = Phase::Setup;
        shared.members = vec![FIRST];
    }

    fn end_run(&mut self, mut report: Report, mut fault: Option<Fault>) -> Result<Report, Fault> {
        let refused = self.inbox.close();
        let (shared, leader) = self.parts();
        if let Some(caught) = refused {
            let later = caught.at(0, shared.frame);
            log::error!("at the end of the run: {later}");
            fault.get_or_insert(later);
        }
        shared.buffers.forget();
        shared.parallel.clear();
        let (callbacks, mut point) = leader.point(shared);
        point.fault = fault.as_ref();
        let ended = callbacks.call(Moment::Termination, &mut point);
        if let Err(caught) = ended {
            let later = caught.at(0, shared.frame);
            log::error!("at the end of the run: {later}");
            fault.get_or_insert(later);
        }
        leader.earlier += leader.run_start.elapsed();
        report.frames = leader.watch.frames();
        report.seconds = leader.run_start.elapsed().as_secs_f64();
        report.frame_times = leader.watch.times();
        report.serial_seconds = leader.serial.as_secs_f64();
        report.transactions = leader.transactions;
        report.threads.sort_by_key(|thread| thread.index);
        report.notes.iter().for_each(|note| log::info!("{note}"));
        if let Some(fault) = &fault {
            log::error!("{fault}");
        }
        self.fault = fault.clone();
        fault.map_or(Ok(report), Err)
    }

    fn parts(&mut self) -> (&mut Shared<S, B>, &mut Leader<S>) {
        self.inbox.home.owned_here();
        (
            self.shared.get_mut().unwrap_or_else(PoisonError::into_inner),
            self.leader.get_mut().unwrap_or_else(PoisonError::into_inner),
        )
    }
}

impl<S, B> std::fmt::Debug for Pipeline<S, B> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Pipeline").field("config", &self.config).field("fault", &self.fault).finish_non_exhaustive()
    }
}
