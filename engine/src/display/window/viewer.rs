//! The event loop's handler: input becomes transactions, pictures become pixels on the screen.

mod keep;

use std::rc::Rc;
use std::time::{Duration, Instant};

use winit::application::ApplicationHandler;
use winit::dpi::{PhysicalPosition, PhysicalSize};
use winit::event::{ElementState, MouseButton, MouseScrollDelta, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow};
use winit::keyboard::ModifiersState;
use winit::window::{Window, WindowId};

use super::keys::{Action, HELP, action};
use super::navigation::{Drag, dolly};
use super::news::{News, Titles, WindowError, tell, without_place};
use super::open::Open;
use super::particles::{ParticleControls, legend_of};
use super::screen::Screen;
use super::volumes::VolumeControls;
use crate::app::{Chosen, Settings, State};
use crate::camera::{Up, View};
use crate::display::Sheet;
use crate::image::Size;
use crate::pipeline::{Handle, MAX_THREADS, Pipeline};
use crate::renderer::RendererKind;
use crate::sampler::SamplerKind;
use crate::tone::{Curve, Tone};

/// A third of a stop, as cameras have it.
const EXPOSURE_STEP: f32 = 1.0 / 3.0;
/// The title changes no more often.
const TITLE_INTERVAL: Duration = Duration::from_millis(200);

/// The window and what it knows. The state itself is changed by transactions only.
pub(super) struct Viewer {
    titles: Titles,
    engine: String,
    screen: Screen,
    handle: Handle<State>,
    size: Size,
    threads: usize,
    /// What was asked for, which the state has or is about to have.
    chosen: Chosen,
    first_view: View,
    /// The axis of the scene that points up.
    axis: Up,
    volumes: VolumeControls,
    particles: ParticleControls,
    antialiased: SamplerKind,
    /// How far ambient occlusion looks, when it is on.
    reach: f32,
    drag: Option<(MouseButton, Drag)>,
    mouse: PhysicalPosition<f64>,
    modifiers: ModifiersState,
    screenshots: u32,
    title_due: Option<Instant>,
    title_set: Option<Instant>,
    open: Option<Open>,
    problem: Option<WindowError>,
}

impl Viewer {
    pub(super) fn new(titles: &Titles, screen: Screen, settings: &Settings, pipeline: &mut Pipeline<State>) -> Self {
        let handle = pipeline.handle();
        let (size, threads) = (settings.size, settings.threads);
        let state = pipeline.state();
        let chosen = *state.chosen();
        screen.lock().legend = legend_of(state);
        let (volumes, particles) = (VolumeControls::new(state, titles, &handle), ParticleControls::new(state, titles));
        let axis = state.stack.scene.up;
        let engine = format!("{} x {}", state.stack.token.level(), state.stack.width);
        let antialiased = match chosen.sampler {
            SamplerKind::Single => SamplerKind::of_samples(9),
            several => several,
        };
        Self {
            titles: titles.clone(),
            engine,
            screen,
            handle,
            size,
            threads,
            chosen,
            first_view: chosen.view,
            axis,
            volumes,
            particles,
            antialiased,
            reach: chosen.occlusion.unwrap_or(f32::INFINITY),
            drag: None,
            mouse: PhysicalPosition::default(),
            modifiers: ModifiersState::empty(),
            screenshots: 0,
            title_due: None,
            title_set: None,
            open: None,
            problem: None,
        }
    }

    /// What went wrong with the window.
    pub(super) fn finish(&mut self) -> Result<(), WindowError> {
        self.open = None;
        self.problem.take().map_or(Ok(()), Err)
    }

    fn open(&mut self, events: &ActiveEventLoop) -> Result<(), String> {
        let size = PhysicalSize::new(self.size.width() as u32, self.size.height() as u32);
        let attributes = Window::default_attributes().with_title("mobula").with_inner_size(size);
        let window = Rc::new(events.create_window(attributes).map_err(|error| without_place(&error))?);
        let inner = window.inner_size();
        self.open = Some(Open::new(window, events.owned_display_handle())?);
        self.resize(inner);
        Ok(())
    }

    /// Changes the view, by one transaction.
    fn look(&mut self, view: View) {
        if view != self.chosen.view {
            self.chosen.view = view;
            self.handle.send("view", move |state| state.choose(Chosen { view, ..*state.chosen() }));
        }
    }

    fn resize(&mut self, size: PhysicalSize<u32>) {
        // A minimised window has no size; a window larger than any picture may be keeps the last one, enlarged.
        if let Ok(size) = Size::new(size.width as usize, size.height as usize)
            && size != self.size
        {
            self.size = size;
            self.handle.resize(0, size);
        }
    }

    fn show(&mut self, tone: Tone) {
        self.chosen.tone = tone;
        self.handle.send("tone", move |state| state.choose(Chosen { tone, ..*state.chosen() }));
    }

    fn act(&mut self, action: Action, events: &ActiveEventLoop) {
        match action {
            Action::Shadows => {
                self.chosen.shadows ^= true;
                let shadows = self.chosen.shadows;
                self.handle.send("shadows", move |state| state.choose(Chosen { shadows, ..*state.chosen() }));
            }
            Action::Occlusion => {
                self.chosen.occlusion = if self.chosen.occlusion.is_none() { Some(self.reach) } else { None };
                let occlusion = self.chosen.occlusion;
                self.handle.send("occlusion", move |state| state.choose(Chosen { occlusion, ..*state.chosen() }));
            }
            Action::Tone => {
                let at = Curve::ALL.iter().position(|&curve| curve == self.chosen.tone.curve).unwrap_or(0);
                self.show(Tone { curve: Curve::ALL[(at + 1) % Curve::ALL.len()], ..self.chosen.tone });
            }
            Action::Exposure(steps) => {
                let most = Tone::MOST_EXPOSURE;
                let exposure = self.chosen.tone.exposure + f32::from(steps) * EXPOSURE_STEP;
                self.show(Tone { exposure: exposure.clamp(-most, most), ..self.chosen.tone });
            }
            Action::Antialiasing => {
                let single = self.chosen.sampler == SamplerKind::Single;
                let sampler = if single { self.antialiased } else { SamplerKind::Single };
                self.chosen.sampler = sampler;
                self.handle.send("sampler", move |state| state.choose(Chosen { sampler, ..*state.chosen() }));
            }
            Action::Renderer => {
                let all = RendererKind::ALL;
                let place = all.iter().position(|kind| *kind == self.chosen.renderer).unwrap_or(0);
                let renderer = all[(place + 1) % all.len()];
                self.chosen.renderer = renderer;
                self.handle.send("renderer", move |state| state.choose(Chosen { renderer, ..*state.chosen() }));
            }
            Action::MoreThreads => self.set_threads(self.threads + 1),
            Action::FewerThreads => self.set_threads(self.threads - 1),
            Action::Iso(steps) => self.volumes.move_iso(steps.into(), &self.handle),
            Action::Level(steps) => {
                self.move_window([steps.into(), 0.0]);
            }
            Action::Width(steps) => {
                self.move_window([0.0, steps.into()]);
            }
            Action::Transfer => self.volumes.next_transfer(&self.handle),
            Action::InHand => self.particles.in_hand = !self.particles.in_hand && self.volumes.has_window(),
            Action::ColorBy => self.particles.next_attribute(&self.handle, &self.screen),
            Action::Map => self.particles.next_map(&self.handle, &self.screen),
            Action::Step(by) => self.volumes.move_step(by.into(), &self.handle),
            Action::Play => self.volumes.play_or_pause(),
            Action::Faster => self.volumes.speed(2.0),
            Action::Slower => self.volumes.speed(0.5),
            Action::Screenshot => self.take_screenshot(),
            Action::Save => self.save(),
            Action::Reset => self.look(self.first_view),
            Action::Help => self.show_or_hide_help(),
            Action::Legend => self.show_or_hide_legend(),
            Action::Close => events.exit(),
        }
        self.title_soon();
    }

    fn show_or_hide_help(&mut self) {
        let mut shared = self.screen.lock();
        shared.help = if shared.help.is_some() { None } else { Some(Sheet::of_text(HELP)) };
        let shown = shared.help.is_some();
        drop(shared);
        if shown {
            tell(format_args!("{HELP}"));
        }
        self.redraw();
    }

    fn show_or_hide_legend(&mut self) {
        let mut shared = self.screen.lock();
        shared.hides_legend ^= true;
        drop(shared);
        self.redraw();
    }

    fn redraw(&self) {
        if let Some(Open { window, .. }) = &self.open {
            window.request_redraw();
        }
    }

    fn set_threads(&mut self, threads: usize) {
        let threads = threads.clamp(1, MAX_THREADS);
        if self.handle.set_threads(threads).is_ok() && threads != self.threads {
            self.threads = threads;
            // Another frame, so that the title shows what it brought.
            self.handle.at_barrier("threads", |point| point.mark_changed());
        }
    }

    fn mouse_button(&mut self, button: MouseButton, state: ElementState) {
        match (state, self.drag) {
            (ElementState::Pressed, None) => {
                self.drag = match button {
                    MouseButton::Left if self.modifiers.shift_key() => Some((button, Drag::Pan)),
                    MouseButton::Left if self.modifiers.control_key() => Some((button, Drag::Values)),
                    MouseButton::Left => Some((button, Drag::Orbit)),
                    MouseButton::Right | MouseButton::Middle => Some((button, Drag::Pan)),
                    _ => None,
                };
            }
            (ElementState::Released, Some((held, _))) if held == button => self.drag = None,
            _ => {}
        }
    }

    fn mouse_moved(&mut self, to: PhysicalPosition<f64>) {
        let from = std::mem::replace(&mut self.mouse, to);
        if let Some((_, drag)) = self.drag {
            let by = [(to.x - from.x) as f32, (to.y - from.y) as f32];
            if drag == Drag::Values {
                self.move_values(by);
            } else {
                self.look(drag.apply(&self.chosen.view, by, self.size.height() as f32));
            }
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
    fn move_values(&mut self, [x, y]: [f32; 2]) {
        let steps = [f64::from(x), -f64::from(y)].map(|pixels| pixels / 8.0);
        if !self.move_window(steps) {
            self.volumes.move_iso(steps[0], &self.handle);
        }
        self.title_soon();
    }

    /// Draws the newest picture.
    fn draw(&mut self) -> Result<(), String> {
        self.open.as_mut().map_or(Ok(()), |open| open.draw(&self.screen))
    }

    /// Sets the title when enough time has passed since the last time.
    fn title_soon(&mut self) {
        let due = self.title_set.map_or_else(Instant::now, |set| set + TITLE_INTERVAL);
        self.title_due.get_or_insert(due);
    }

    fn set_title(&mut self) {
        let Some(Open { window, .. }) = &self.open else { return };
        let progress = self.handle.progress();
        let seconds = progress.frame_seconds.max(1e-9);
        // Those of the first frame are known when the second begins.
        let rays = match self.screen.lock().rays_per_frame {
            0 => String::new(),
            rays => format!(", {:.1} Mrays/s", rays as f64 / seconds * 1e-6),
        };
        let Chosen { renderer, sampler, shadows, .. } = self.chosen;
        let shadows = if shadows { "shadows" } else { "no shadows" };
        let volumes = self.volumes.title() + &self.particles.title();
        window.set_title(&format!(
            "mobula: {} | {} | {:.1} frames/s{rays} | {}, {} thread{} | {renderer}, {sampler}, {shadows}{volumes} | h: help",
            self.titles.name,
            self.size,
            1.0 / seconds,
            self.engine,
            self.threads,
            if self.threads == 1 { "" } else { "s" },
        ));
        self.title_set = Some(Instant::now());
        self.title_due = None;
    }
}

impl ApplicationHandler<News> for Viewer {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        if self.open.is_none()
            && let Err(problem) = self.open(events)
        {
            self.problem = Some(WindowError::Open(problem));
            events.exit();
        }
    }

    fn user_event(&mut self, events: &ActiveEventLoop, news: News) {
        match news {
            News::Picture => {
                if let Some(open) = &self.open {
                    open.window.request_redraw();
                }
                self.title_soon();
            }
            News::Screenshot(Ok(file)) => tell(format_args!("mobula: wrote {file}")),
            News::Screenshot(Err(problem)) => tell(format_args!("mobula: warning: {problem}")),
            News::Ended => events.exit(),
        }
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        match event {
            WindowEvent::CloseRequested => events.exit(),
            WindowEvent::Resized(size) => {
                self.resize(size);
                if let Some(open) = &self.open {
                    open.window.request_redraw();
                }
            }
            WindowEvent::RedrawRequested => {
                if let Err(problem) = self.draw() {
                    self.problem = Some(WindowError::Open(problem));
                    events.exit();
                }
            }
            WindowEvent::ModifiersChanged(modifiers) => self.modifiers = modifiers.state(),
            WindowEvent::KeyboardInput { event, .. } if event.state == ElementState::Pressed => {
                if let Some(action) = action(&event.logical_key) {
                    self.act(action, events);
                }
            }
            WindowEvent::MouseInput { button, state, .. } => self.mouse_button(button, state),
            WindowEvent::CursorMoved { position, .. } => self.mouse_moved(position),
            WindowEvent::MouseWheel { delta, .. } => {
                let notches = match delta {
                    MouseScrollDelta::LineDelta(_, lines) => lines,
                    MouseScrollDelta::PixelDelta(pixels) => pixels.y as f32 / 40.0,
                };
                self.look(dolly(&self.chosen.view, notches));
            }
            WindowEvent::Focused(false) => self.drag = None,
            _ => {}
        }
    }

    fn about_to_wait(&mut self, events: &ActiveEventLoop) {
        let step_due = self.volumes.tick(&self.handle);
        if step_due.is_some() {
            self.title_soon();
        }
        if self.title_due.is_some_and(|due| Instant::now() >= due) {
            self.set_title();
        }
        let due = [self.title_due, step_due].into_iter().flatten().min();
        events.set_control_flow(due.map_or(ControlFlow::Wait, ControlFlow::WaitUntil));
    }
}
