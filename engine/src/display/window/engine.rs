//! A scene that is shown: its pipeline, which renders on a thread of its own, and what was asked of it.

use std::thread::{self, JoinHandle};

use super::keys::Action;
use super::news::{News, Ready, Titles, WindowError};
use super::particles::{ParticleControls, legend_of};
use super::screen::Screen;
use super::volumes::VolumeControls;
use crate::app::{Chosen, Settings, State};
use crate::camera::{Up, View};
use crate::geometry::Role;
use crate::image::Size;
use crate::pipeline::{DisplayStage, Fault, Handle, MAX_THREADS};
use crate::renderer::RendererKind;
use crate::sampler::SamplerKind;
use crate::tone::{Curve, Tone};
use crate::traverse::TraverserKind;

/// How many samples a pixel gets while nothing changes, unless somebody says how many; then the machine may rest.
pub const SAMPLES: u32 = 1024;
/// A third of a stop, as cameras have it.
const EXPOSURE_STEP: f32 = 1.0 / 3.0;

pub(super) struct Engine {
    pub(super) titles: Titles,
    /// Level and packet width.
    pub(super) kernels: String,
    /// What is in the scene, in a few words.
    pub(super) contents: String,
    pub(super) handle: Handle<State>,
    pub(super) threads: usize,
    /// What was asked for, which the state has or is about to have.
    pub(super) chosen: Chosen,
    pub(super) first_view: View,
    /// Is the view still the one that shows everything? Then it goes with the window's size.
    pub(super) automatic: bool,
    /// The axis of the scene that points up.
    pub(super) axis: Up,
    pub(super) volumes: VolumeControls,
    pub(super) particles: ParticleControls,
    antialiased: SamplerKind,
    /// What to go back to from the edges of triangles.
    surfaces: RendererKind,
    /// How far ambient occlusion looks, when it is on.
    reach: f32,
    /// Tells which of several this is.
    pub(super) number: u64,
    thread: JoinHandle<Result<(), Fault>>,
}

impl Engine {
    /// Runs a pipeline at a size, on a thread of its own. `before` is what was chosen of a scene that this one takes the place of.
    pub(super) fn start(
        ready: Ready,
        size: Size,
        before: Option<Chosen>,
        screen: &Screen,
        number: u64,
    ) -> Result<Self, WindowError> {
        let Ready { mut pipeline, settings, titles } = ready;
        let Settings { threads, traverser, balancer, .. } = settings;
        if traverser != TraverserKind::Null {
            pipeline.state().refine(balancer);
        }
        let state = pipeline.state();
        if let Some(before) = before {
            state.choose(before);
        }
        let samples = state.shown_samples().cloned();
        let screen = screen.of_engine(samples);
        let handle = pipeline.handle();
        let state = pipeline.state();
        let chosen = *state.chosen();
        screen.lock().legend = legend_of(state);
        let (volumes, particles) =
            (VolumeControls::new(state, &titles, &handle), ParticleControls::new(state, &titles));
        let (axis, automatic) = (state.stack.scene.up, before.is_none() && titles.automatic);
        let kernels = format!("{} x {}", state.stack.token.level(), state.stack.width);
        let census = state.stack.scene.geometry.census();
        let counted = census.items().iter().filter(|(item, count)| item.role == Role::Primitives && *count > 0);
        let parts = counted.map(|(item, count)| format!("{count} {}", if *count == 1 { item.one } else { item.many }));
        let contents = parts.collect::<Vec<_>>().join(", ");
        let antialiased = match chosen.sampler {
            SamplerKind::Single => SamplerKind::of_samples(SAMPLES),
            several => several,
        };
        pipeline.add_stage(DisplayStage::new().with(0, screen.display()));
        let rays = screen.ray_counter();
        pipeline.callbacks().serial_pre_render("window statistics", move |point| rays.note(&point.state.rays()));
        handle.resize(0, size);
        let run = move || {
            let result = pipeline.run_until_stopped();
            // Nobody listens when the window was closed first.
            screen.tell(News::Ended(number));
            result.map(|_| ())
        };
        let thread = thread::Builder::new().spawn(run);
        let thread = thread.map_err(|error| WindowError::Open(format!("no thread to render with: {error}")))?;
        Ok(Self {
            titles,
            kernels,
            contents,
            handle,
            threads,
            chosen,
            first_view: chosen.view,
            automatic,
            axis,
            volumes,
            particles,
            antialiased,
            surfaces: RendererKind::Raytracer,
            reach: chosen.occlusion.unwrap_or(f32::INFINITY),
            number,
            thread,
        })
    }

    /// Ends the run: nobody waits for a frame that nobody will see.
    pub(super) fn stop(self) -> Result<(), Fault> {
        self.handle.halt();
        self.thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    }

    /// Changes something of what is chosen, here and in the state.
    fn choose(&mut self, name: &'static str, change: impl Fn(&mut Chosen) + Send + 'static) {
        change(&mut self.chosen);
        self.handle.send(name, move |state| {
            let mut chosen = *state.chosen();
            change(&mut chosen);
            state.choose(chosen);
        });
    }

    /// Changes the view, by one transaction.
    pub(super) fn look(&mut self, view: View) {
        if view != self.chosen.view {
            self.automatic = false;
            self.choose("view", move |chosen| chosen.view = view);
        }
    }

    /// While held, pictures have one sample a pixel; then they are refined again.
    pub(super) fn hold(&self, held: bool) {
        self.handle.at_barrier("hold", move |point| {
            point.state.hold(held);
            if !held {
                point.request_frame();
            }
        });
    }

    fn set_threads(&mut self, threads: usize) {
        let threads = threads.clamp(1, MAX_THREADS);
        if self.handle.set_threads(threads).is_ok() && threads != self.threads {
            self.threads = threads;
            // Another frame, so that people see what it brought.
            self.handle.at_barrier("threads", |point| point.mark_changed());
        }
    }

    /// Moves level and width of media, or of the particles that are shown. Says whether there are any.
    fn move_window(&mut self, by: [f64; 2]) -> bool {
        match self.volumes.has_window() && !self.particles.in_hand {
            true => self.volumes.move_window(by, &self.handle),
            false => self.particles.move_crop(by, &self.handle),
        }
    }

    /// A drag over volumes: level to the right and width upwards, or without media iso values to the right.
    pub(super) fn move_values(&mut self, [x, y]: [f32; 2]) {
        let steps = [f64::from(x), -f64::from(y)].map(|pixels| pixels / 8.0);
        if !self.move_window(steps) {
            self.volumes.move_iso(steps[0], &self.handle);
        }
    }

    /// Does what a key asks of the scene; what it asks of the window is not done here.
    pub(super) fn act(&mut self, action: Action, screen: &Screen) {
        match action {
            Action::Shadows => {
                let shadows = !self.chosen.shadows;
                self.choose("shadows", move |chosen| chosen.shadows = shadows);
            }
            Action::Occlusion => {
                let occlusion = if self.chosen.occlusion.is_none() { Some(self.reach) } else { None };
                self.choose("occlusion", move |chosen| chosen.occlusion = occlusion);
            }
            Action::Tone => {
                let at = Curve::ALL.iter().position(|&curve| curve == self.chosen.tone.curve).unwrap_or(0);
                self.choose("tone", move |chosen| chosen.tone.curve = Curve::ALL[(at + 1) % Curve::ALL.len()]);
            }
            Action::Exposure(steps) => {
                let most = Tone::MOST_EXPOSURE;
                let exposure = self.chosen.tone.exposure + f32::from(steps) * EXPOSURE_STEP;
                self.choose("exposure", move |chosen| chosen.tone.exposure = exposure.clamp(-most, most));
            }
            Action::Antialiasing => {
                let single = self.chosen.sampler == SamplerKind::Single;
                let sampler = if single { self.antialiased } else { SamplerKind::Single };
                self.choose("sampler", move |chosen| chosen.sampler = sampler);
            }
            Action::Renderer => {
                let all = RendererKind::ALL;
                let place = all.iter().position(|kind| *kind == self.chosen.renderer).unwrap_or(0);
                self.choose("renderer", move |chosen| chosen.renderer = all[(place + 1) % all.len()]);
            }
            Action::Wireframe => {
                let shown = self.chosen.renderer;
                let next = if shown == RendererKind::Wireframe { self.surfaces } else { RendererKind::Wireframe };
                if shown != RendererKind::Wireframe {
                    self.surfaces = shown;
                }
                self.choose("renderer", move |chosen| chosen.renderer = next);
            }
            Action::MoreThreads => self.set_threads(self.threads + 1),
            Action::FewerThreads => self.set_threads(self.threads - 1),
            Action::Iso(steps) => self.volumes.move_iso(steps.into(), &self.handle),
            Action::Level(steps) => drop(self.move_window([steps.into(), 0.0])),
            Action::Width(steps) => drop(self.move_window([0.0, steps.into()])),
            Action::Transfer => self.volumes.next_transfer(&self.handle),
            Action::InHand => self.particles.in_hand = !self.particles.in_hand && self.volumes.has_window(),
            Action::ColorBy => self.particles.next_attribute(&self.handle, screen),
            Action::Map => self.particles.next_map(&self.handle, screen),
            Action::Step(by) => self.volumes.move_step(by.into(), &self.handle),
            Action::Play => self.volumes.play_or_pause(),
            Action::Faster => self.volumes.speed(2.0),
            Action::Slower => self.volumes.speed(0.5),
            Action::Home => self.look(self.first_view),
            Action::Side(side) => self.fit(Some(side), screen),
            Action::Fit => self.fit(None, screen),
            _ => {}
        }
    }

    /// Shows all of the scene in a picture of a size, as at first.
    pub(super) fn refit(&self, size: Size, screen: &Screen) {
        let (screen, number) = (screen.clone(), self.number);
        self.handle.at_barrier("refit", move |point| {
            let view = point.state.stack.scene.view(size.width() as f32 / size.height() as f32);
            let chosen = *point.state.chosen();
            if view != chosen.view {
                point.state.choose(Chosen { view, ..chosen });
                point.mark_changed();
                screen.tell(News::View(number, view, true));
            }
        });
    }

    /// Shows all of the scene, from a side or in the present direction. Only the state knows where things are.
    fn fit(&mut self, side: Option<crate::camera::Side>, screen: &Screen) {
        let (screen, number, axis) = (screen.clone(), self.number, self.axis);
        self.handle.at_barrier("fit", move |point| {
            let size = point.channels()[0].size;
            let chosen = *point.state.chosen();
            let toward = side.map_or(chosen.view, |side| chosen.view.from_side(side, axis));
            let view = point.state.stack.scene.fitted(&toward, size.width() as f32 / size.height() as f32);
            point.state.choose(Chosen { view, ..chosen });
            point.mark_changed();
            screen.tell(News::View(number, view, false));
        });
    }
}
