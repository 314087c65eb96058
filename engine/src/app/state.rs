//! What transactions change: the state of a pipeline that renders a scene.

use std::sync::{Mutex, MutexGuard, PoisonError};

use mobula_core::traverse::Paths;

use super::Components;
use super::refinement::{Refinement, ShownSamples};
use crate::balance::BalancerKind;
use crate::camera::{CameraKind, Lens, View};
use crate::pipeline::fault::scope;
use crate::pipeline::{Balance, Frame, Plan, Stage};
use crate::progress::Progress;
use crate::renderer::RendererKind;
use crate::sampler::SamplerKind;
use crate::stack::{Occlusion, Statistics};
use crate::tone::Tone;
use crate::traverse::{ImageTraverser, TileSize, TraverserKind, traverse_frame};

/// Everything that may change between frames. Changes go through [`Handle::send`](crate::pipeline::Handle::send).
pub struct State {
    /// The rendering stack from the pixel sampler down: scene, cameras, sampler, renderer.
    pub stack: Components,
    /// The image traverser with its load balancer.
    pub traverser: Box<dyn ImageTraverser>,
    /// Where the pixels are counted that have been rendered.
    pub progress: Progress,
    chosen: Chosen,
    rays: Mutex<RayCounts>,
    refinement: Option<Refinement>,
}

/// What was chosen by name: viewers show it, and change it with [`State::choose`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chosen {
    /// Where the first channel looks from.
    pub view: View,
    /// The first channel's camera.
    pub camera: CameraKind,
    /// Its lens, if it has one.
    pub lens: Lens,
    /// The renderer.
    pub renderer: RendererKind,
    /// The pixel sampler.
    pub sampler: SamplerKind,
    /// Are there shadows?
    pub shadows: bool,
    /// How far is it looked for what keeps ambient light away; `None`: nothing does.
    pub occlusion: Option<f32>,
    /// How what arrives is shown.
    pub tone: Tone,
}

impl Chosen {
    /// As many rays for each sample, however many there are: `n` samples of more are those of `n`.
    fn occlusion(&self) -> Option<Occlusion> {
        let distance = self.occlusion.or((self.renderer == RendererKind::AmbientOcclusion).then_some(f32::INFINITY));
        distance.map(|distance| Occlusion { distance, ..Occlusion::default() })
    }
}

/// Rays by kind.
#[derive(Clone, Copy, Debug, Default)]
pub struct RayCounts {
    /// From the camera.
    pub primary: u64,
    /// Any-hit rays towards lights.
    pub shadow: u64,
    /// All others.
    pub secondary: u64,
    /// Which paths they took through acceleration structures.
    pub paths: Paths,
}

impl RayCounts {
    /// All rays.
    pub fn total(&self) -> u64 {
        self.primary + self.shadow + self.secondary
    }
}

impl State {
    /// The state for a stack; `chosen` is what it renders from now on.
    pub fn new(mut stack: Components, traverser: Box<dyn ImageTraverser>, chosen: Chosen) -> Self {
        stack.set_camera(0, chosen.camera.build(chosen.view, chosen.lens));
        stack.renderer = chosen.renderer.build();
        stack.sampler = chosen.sampler.build();
        stack.scene.shadows = chosen.shadows;
        stack.scene.occlusion = chosen.occlusion();
        stack.tone = chosen.tone;
        Self { stack, traverser, progress: Progress::default(), chosen, rays: Mutex::default(), refinement: None }
    }

    /// What is rendered, and how, as far as it was chosen by name: components that were put into the stack directly are not known.
    pub fn chosen(&self) -> &Chosen {
        &self.chosen
    }

    /// Changes what is rendered, and how. What is chosen as before stays as it is.
    pub fn choose(&mut self, chosen: Chosen) {
        let before = std::mem::replace(&mut self.chosen, chosen);
        if (before.view, before.camera, before.lens) != (chosen.view, chosen.camera, chosen.lens) {
            self.stack.set_camera(0, chosen.camera.build(chosen.view, chosen.lens));
        }
        if before.renderer != chosen.renderer {
            self.stack.renderer = chosen.renderer.build();
        }
        if before.sampler != chosen.sampler {
            self.stack.sampler = chosen.sampler.build();
        }
        if before.shadows != chosen.shadows {
            self.stack.scene.shadows = chosen.shadows;
        }
        if before.tone != chosen.tone {
            self.stack.tone = chosen.tone;
        }
        if before.occlusion() != chosen.occlusion() {
            self.stack.scene.occlusion = chosen.occlusion();
        }
    }

    /// From now on, pictures of one channel begin with one sample a pixel after each change and get one more with each frame, until there are
    /// as many as the chosen sampler takes.
    pub fn refine(&mut self, balancer: BalancerKind) {
        self.refinement = Some(Refinement::new(TraverserKind::Tiled.build(TileSize::default(), balancer)));
    }

    /// While held, pictures are not refined: somebody moves the view, and wants the next picture soon.
    pub fn hold(&mut self, held: bool) {
        if let Some(refinement) = &mut self.refinement {
            refinement.hold(held);
        }
    }

    /// How many samples the last pictures have, if they are refined.
    pub fn shown_samples(&self) -> Option<&ShownSamples> {
        self.refinement.as_ref().map(Refinement::shown)
    }

    /// Rays traced since the beginning.
    pub fn rays(&self) -> RayCounts {
        *self.counts()
    }

    fn counts(&self) -> MutexGuard<'_, RayCounts> {
        self.rays.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn count(&self, statistics: &Statistics) {
        let mut counts = self.counts();
        counts.primary += statistics.primary.get();
        counts.shadow += statistics.shadow.get();
        counts.secondary += statistics.secondary.get();
        counts.paths += statistics.paths.get();
    }
}

impl std::fmt::Debug for State {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("State").field("chosen", &self.chosen).field("rays", &self.rays()).finish_non_exhaustive()
    }
}

/// The dynamically balanced stage that renders all channels.
#[derive(Clone, Copy, Debug, Default)]
pub struct RenderFrames;

impl Stage<State> for RenderFrames {
    fn name(&self) -> &str {
        "render"
    }

    fn balance(&self) -> Balance {
        Balance::Dynamic
    }

    fn begin(&mut self, state: &mut State, plan: &Plan<'_>) {
        if let Some(refinement) = &mut state.refinement {
            let sample = refinement.begin(plan, state.chosen.sampler);
            state.stack.frame = sample.unwrap_or(0);
            if sample.is_some() {
                return;
            }
        }
        let traverser = &mut state.traverser;
        scope(traverser.name(), || traverser.begin(plan.sizes, plan.threads, plan.changed));
    }

    fn run(&self, frame: &Frame<'_, State>) {
        let statistics = Statistics::default();
        match &frame.state.refinement {
            Some(refinement) => {
                let State { stack, traverser, progress, .. } = frame.state;
                refinement.run(frame, stack, &**traverser, progress, &statistics);
            }
            None => {
                traverse_frame(frame, &*frame.state.traverser, &|frame, fragment, out| {
                    frame.state.stack.render(*fragment, out, &statistics);
                    frame.state.progress.advance(fragment.pixels() as u64);
                });
            }
        }
        // Once a thread and frame: the lock is short.
        frame.state.count(&statistics);
    }
}
