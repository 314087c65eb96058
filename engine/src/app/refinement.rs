//! Pictures that get better while nothing changes: sample is added to sample, frame by frame.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use super::Components;
use crate::image::{FrameBuffer, Size};
use crate::pipeline::fault::scope;
use crate::pipeline::{Frame, Plan};
use crate::progress::Progress;
use crate::sampler::{Film, SamplerKind, SingleSample, Sobol};
use crate::stack::{Fragment, Statistics};
use crate::traverse::{ImageTraverser, traverse_frame};

/// Means of fewer samples are not shown: they look worse than the sample in the middle of the pixel that is there before them.
const FEWEST: u32 = 4;

/// How the pictures of a state are refined.
///
/// The first frame after a change has one sample in the middle of each pixel, in the order of the state's own traverser. When that is
/// finished, each frame adds a sample until there are as many as the chosen sampler takes; then nothing is done any more. A picture of `n`
/// samples is, byte for byte, that of [`SamplerKind::Sobol`] with `n`.
pub(super) struct Refinement {
    /// The film, and who adds a sample to it, without and with showing it.
    film: Option<(Arc<Film>, [Sobol; 2])>,
    /// Who renders the frames after the first.
    traverser: Box<dyn ImageTraverser>,
    step: Step,
    /// Samples on the film after this frame.
    taken: u32,
    /// Another frame would make it better.
    more: bool,
    /// The state's own traverser has not finished the first frame.
    unfinished: AtomicBool,
    held: bool,
    shown: ShownSamples,
}

/// What a frame does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Step {
    /// By the state's own traverser: all samples, or only one a pixel, as others follow.
    First { all: bool },
    /// One more, shown or not.
    Add { shows: bool },
    /// The picture before is shown again.
    Keep,
}

impl Refinement {
    pub(super) fn new(traverser: Box<dyn ImageTraverser>) -> Self {
        Self {
            film: None,
            traverser,
            step: Step::First { all: true },
            taken: 0,
            more: false,
            unfinished: AtomicBool::new(true),
            held: false,
            shown: ShownSamples::default(),
        }
    }

    pub(super) fn shown(&self) -> &ShownSamples {
        &self.shown
    }

    /// While held, pictures have one sample a pixel.
    pub(super) fn hold(&mut self, held: bool) {
        self.held = held;
    }

    /// Decides what the frame of a plan does, at the barrier. Returns the number of its sample; none if the state's own traverser and sampler
    /// are to render it.
    pub(super) fn begin(&mut self, plan: &Plan<'_>, chosen: SamplerKind) -> Option<u32> {
        // Pictures of several channels are not refined.
        let size = if let [size] = *plan.sizes { Some(size) } else { None };
        let most = if size.is_some() { chosen.samples() } else { 1 };
        let unfinished = *self.unfinished.get_mut();
        let before = self.shown.of(plan.number.wrapping_sub(1));
        if plan.changed {
            self.taken = 0;
        }
        let adds = !self.held && most > 1 && self.taken < most;
        self.step = match () {
            () if plan.changed || unfinished => Step::First { all: most <= 1 },
            () if adds && (self.taken > 0 || self.begin_film(size, chosen)) => {
                self.taken += 1;
                Step::Add { shows: self.taken >= most.min(FEWEST) }
            }
            () => Step::Keep,
        };
        // Noted as finished: whoever finds that it is not says so.
        *self.unfinished.get_mut() = false;
        self.more = !self.held && most > 1 && self.taken < most && self.step != Step::Keep;
        let samples = match self.step {
            Step::First { all: true } => chosen.samples(),
            Step::First { all: false } => 1,
            Step::Add { shows: true } => self.taken,
            _ => before,
        };
        self.shown.note(plan.number, samples);
        if let Step::First { .. } = self.step {
            return None;
        }
        scope(self.traverser.name(), || self.traverser.begin(plan.sizes, plan.threads, false));
        Some(self.taken.saturating_sub(1))
    }

    /// Makes the film ready for the first sample. False where there is no memory for one: the picture then stays as it is.
    fn begin_film(&mut self, size: Option<Size>, chosen: SamplerKind) -> bool {
        let (Some(size), SamplerKind::Sobol { filter, .. }) = (size, chosen) else { return false };
        if self.film.as_ref().is_none_or(|(film, _)| film.size() != size || film.filter() != filter) {
            // The old one first: there may be no room for both.
            self.film = None;
            let Ok(film) = Film::new(size, filter) else { return false };
            let film = Arc::new(film);
            let samplers = [false, true].map(|shows| Sobol::onto(Arc::clone(&film), shows));
            self.film = Some((film, samplers));
        }
        true
    }

    /// One thread's part of a frame, with the state's own traverser.
    pub(super) fn run<S>(
        &self,
        frame: &Frame<'_, S>,
        stack: &Components,
        traverser: &dyn ImageTraverser,
        progress: &Progress,
        statistics: &Statistics,
    ) {
        match self.step {
            Step::First { all } => {
                let sampler = if all { &*stack.sampler } else { &SingleSample };
                let unfinished = traverse_frame(frame, traverser, &|_, fragment, out| {
                    stack.render_with(sampler, *fragment, out, statistics);
                    progress.advance(fragment.pixels() as u64);
                });
                if unfinished {
                    self.unfinished.store(true, Ordering::Relaxed);
                    self.shown.note(frame.number, 0);
                }
            }
            Step::Add { shows } => {
                let Some((_, samplers)) = &self.film else { return };
                let sampler = &samplers[usize::from(shows)];
                traverse_frame(frame, &*self.traverser, &|frame, fragment, out| {
                    stack.render_with(sampler, *fragment, out, statistics);
                    progress.advance(fragment.pixels() as u64);
                    if !shows {
                        keep(frame, fragment, out);
                    }
                });
            }
            Step::Keep => {
                traverse_frame(frame, &*self.traverser, &|frame, fragment, out| {
                    if !keep(frame, fragment, out) {
                        stack.render_with(&SingleSample, *fragment, out, statistics);
                    }
                });
            }
        }
        if self.more {
            frame.request_frame();
        }
    }
}

/// Puts the pixels of the picture before in the place of a fragment; false if there is none.
fn keep<S>(frame: &Frame<'_, S>, fragment: &Fragment, out: &FrameBuffer) -> bool {
    let view = frame.channels().iter().find(|view| view.index == fragment.channel);
    let Some(previous) = view.and_then(|view| view.previous) else { return false };
    if !std::ptr::eq(previous, out) {
        out.copy_from(previous, fragment.x0, fragment.y0, fragment.x1, fragment.y1);
    }
    true
}

/// How many samples a pixel the last pictures have, by the numbers of their frames. Clones know the same.
#[derive(Clone, Debug, Default)]
pub struct ShownSamples(Arc<[AtomicU32; 4]>);

// Relaxed throughout: the barrier orders what frames note before what displays ask. More frames are not on their way at once.
impl ShownSamples {
    fn note(&self, frame: u64, samples: u32) {
        self.0[frame as usize % 4].store(samples, Ordering::Relaxed);
    }

    /// Those of a frame that is being displayed; 0 while its traverser has not finished it.
    pub fn of(&self, frame: u64) -> u32 {
        self.0[frame as usize % 4].load(Ordering::Relaxed)
    }
}
