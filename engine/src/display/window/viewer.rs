//! The event loop's handler: input becomes transactions, pictures become pixels on the screen.

mod keep;
mod mouse;
mod moves;
mod overlay;

use std::path::PathBuf;
use std::rc::Rc;
use std::sync::Arc;
use std::time::{Duration, Instant};

use winit::application::ApplicationHandler;
use winit::dpi::{PhysicalPosition, PhysicalSize};
use winit::event::{DeviceEvent, DeviceId, ElementState, KeyEvent, MouseButton, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow};
use winit::keyboard::ModifiersState;
use winit::window::{Fullscreen, Window, WindowId};

use super::engine::Engine;
use super::keys::{Action, action};
use super::loading::{Loader, Loading};
use super::navigation::Drag;
use super::news::{News, Ready, WindowError, tell, without_place};
use super::open::Open;
use super::screen::Screen;
use super::travel::Travel;
use crate::camera::View;
use crate::image::Size;

/// Files that are dropped together come one by one, within this.
const TOGETHER: Duration = Duration::from_millis(100);

/// The window and what it knows. The state itself is changed by transactions only.
pub(super) struct Viewer {
    screen: Screen,
    /// The size of pictures.
    size: Size,
    engine: Option<Engine>,
    /// The number of the engine that comes next.
    engines: u64,
    loading: Loading,
    /// Files that were dropped on the window, and when the first was.
    dropped: Option<(Instant, Vec<PathBuf>)>,
    overlay: Overlay,
    press: Option<Press>,
    clicked: Option<(Instant, PhysicalPosition<f64>)>,
    mouse: PhysicalPosition<f64>,
    modifiers: ModifiersState,
    travel: Travel,
    kept: [Option<View>; 3],
    screenshots: u32,
    open: Option<Open>,
    problem: Option<WindowError>,
}

/// A button that is held down.
struct Press {
    button: MouseButton,
    drag: Drag,
    at: PhysicalPosition<f64>,
    /// Has it moved farther than a click does?
    moved: bool,
}

/// What is laid over the picture.
#[derive(Default)]
struct Overlay {
    /// The page of the help that is shown.
    help: Option<usize>,
    status: bool,
    /// A message, and when it goes.
    message: Option<(String, Instant)>,
    /// When all of it was laid out last.
    laid_out: Option<Instant>,
    /// When the title was set, and when it is to be set again.
    set: Option<Instant>,
    due: Option<Instant>,
}

impl Viewer {
    pub(super) fn new(screen: Screen, size: Size, loader: Option<Arc<dyn Loader>>) -> Self {
        Self {
            screen,
            size,
            engine: None,
            engines: 0,
            loading: Loading::new(loader),
            dropped: None,
            overlay: Overlay::default(),
            press: None,
            clicked: None,
            mouse: PhysicalPosition::default(),
            modifiers: ModifiersState::empty(),
            travel: Travel::default(),
            kept: [None; 3],
            screenshots: 0,
            open: None,
            problem: None,
        }
    }

    /// Loads the scene that the window was opened for.
    pub(super) fn load_first(&mut self) {
        self.loading.begin(Vec::new(), &self.screen);
    }

    /// Shows a scene, in place of the one before; if that is the same scene, with all that was chosen of it.
    pub(super) fn put(&mut self, ready: Ready, files: Option<(Vec<PathBuf>, bool)>) -> Result<(), WindowError> {
        let mut before = None;
        if let Some(engine) = self.engine.take() {
            let again = files.as_ref().is_some_and(|(_, again)| *again);
            before = again.then_some((engine.chosen, engine.first_view));
            engine.stop()?;
        } else if let (Some(open), true) = (&self.open, ready.settings.size != self.size) {
            // What the scene says of its size is known now.
            let size = PhysicalSize::new(ready.settings.size.width() as u32, ready.settings.size.height() as u32);
            if let Some(given) = open.window.request_inner_size(size) {
                self.resize(given);
            }
        }
        self.loading.shows(files.map(|(files, _)| files).unwrap_or_default(), &ready.titles.files);
        self.engines += 1;
        let chosen = before.map(|(chosen, _)| chosen);
        let mut engine = Engine::start(ready, self.size, chosen, &self.screen, self.engines)?;
        if let Some((_, first_view)) = before {
            engine.first_view = first_view;
        }
        self.engine = Some(engine);
        self.kept = if before.is_some() { self.kept } else { [None; 3] };
        self.stand_still();
        self.refit();
        self.title_soon();
        Ok(())
    }

    /// What went wrong with the window, or with rendering.
    pub(super) fn finish(&mut self) -> Result<(), WindowError> {
        self.open = None;
        if let Some(engine) = self.engine.take() {
            engine.stop()?;
        }
        self.problem.take().map_or(Ok(()), Err)
    }

    fn fail(&mut self, problem: WindowError, events: &ActiveEventLoop) {
        self.problem = Some(problem);
        events.exit();
    }

    fn open(&mut self, events: &ActiveEventLoop) -> Result<(), String> {
        let size = PhysicalSize::new(self.size.width() as u32, self.size.height() as u32);
        let attributes = Window::default_attributes().with_title("mobula").with_inner_size(size);
        let window = Rc::new(events.create_window(attributes).map_err(|error| without_place(&error))?);
        let open = Open::new(window, events.owned_display_handle())?;
        let size = open.size;
        self.open = Some(open);
        self.resize(size);
        Ok(())
    }

    fn resize(&mut self, size: PhysicalSize<u32>) {
        // A minimised window has no size; a window larger than any picture may be keeps the last one, enlarged.
        if let Ok(size) = Size::new(size.width as usize, size.height as usize)
            && size != self.size
        {
            self.size = size;
            if let Some(engine) = &self.engine {
                engine.handle.resize(0, size);
            }
            self.refit();
            self.lay_out();
        }
    }

    /// Fits the view to the size of the window, unless somebody has moved it.
    fn refit(&mut self) {
        if let Some(engine) = self.engine.as_mut().filter(|engine| engine.automatic) {
            engine.refit(self.size, &self.screen);
        }
    }

    /// Changes the view.
    fn look(&mut self, view: View) {
        if let Some(engine) = &mut self.engine {
            engine.look(view);
        }
    }

    fn view(&self) -> Option<View> {
        self.engine.as_ref().map(|engine| engine.chosen.view)
    }

    fn act(&mut self, action: Action, events: &ActiveEventLoop) {
        match action {
            Action::Screenshot => self.take_screenshot(),
            Action::Save => self.save(),
            Action::Help => self.next_help(),
            Action::Status => self.show_or_hide_status(),
            Action::Legend => {
                self.screen.lock().hides_legend ^= true;
                self.redraw();
            }
            Action::Turntable => self.toggle_turntable(),
            Action::Fly => self.toggle_flight(),
            Action::Pick => self.pick(self.mouse, false),
            Action::FullScreen => {
                if let Some(Open { window, .. }) = &self.open {
                    let full = window.fullscreen().is_none().then_some(Fullscreen::Borderless(None));
                    window.set_fullscreen(full);
                }
            }
            Action::Reload => self.reload(),
            Action::Recall(number) => self.keep_or_recall(number),
            Action::Close if self.travel.flies() => self.toggle_flight(),
            Action::Close if self.engine.is_some() && self.loading.cancel() => self.say("loading was cancelled"),
            Action::Close => events.exit(),
            Action::Side(_) | Action::Fit | Action::Home => {
                self.stand_still();
                self.act_on_engine(action);
            }
            _ => self.act_on_engine(action),
        }
        self.title_soon();
    }

    fn act_on_engine(&mut self, action: Action) {
        if let Some(engine) = &mut self.engine {
            engine.act(action, &self.screen);
        }
    }

    fn reload(&mut self) {
        if self.loading.is_possible() {
            self.loading.begin(Vec::new(), &self.screen);
        }
    }

    fn keep_or_recall(&mut self, number: u8) {
        let place = usize::from(number);
        if self.modifiers.control_key() {
            self.kept[place] = self.view();
            self.say(&format!("view kept: {} brings it back", number + 7));
        } else if let Some(view) = self.kept[place] {
            self.look(view);
        } else {
            self.say(&format!("no view was kept: ctrl+{} keeps one", number + 7));
        }
    }

    fn redraw(&self) {
        if let Some(Open { window, .. }) = &self.open {
            window.request_redraw();
        }
    }

    /// Draws the newest picture.
    fn draw(&mut self) -> Result<(), String> {
        self.open.as_mut().map_or(Ok(()), |open| open.draw(&self.screen))
    }

    fn key(&mut self, event: &KeyEvent, events: &ActiveEventLoop) {
        if self.travel.key(event) {
            return;
        }
        let pressed = event.state == ElementState::Pressed;
        if pressed && self.overlay.message.take().is_some() {
            self.lay_out();
        }
        if let Some(action) = action(&event.logical_key).filter(|_| pressed) {
            // A key that is held down loads nothing again and again.
            let repeats = !matches!(action, Action::Reload | Action::Help | Action::FullScreen | Action::Screenshot);
            if !event.repeat || repeats {
                self.act(action, events);
            }
        }
    }

    /// Something was loaded, or not.
    fn loaded(
        &mut self,
        number: u64,
        files: Vec<PathBuf>,
        loaded: Result<Box<Ready>, String>,
        events: &ActiveEventLoop,
    ) {
        let Some(again) = self.loading.end(number) else { return };
        match loaded {
            Ok(ready) => {
                self.overlay.message = None;
                if let Err(problem) = self.put(*ready, Some((files, again))) {
                    self.fail(problem, events);
                }
            }
            Err(problem) if self.engine.is_none() => self.fail(WindowError::Load(problem), events),
            Err(problem) => self.warn(&problem),
        }
        self.lay_out();
    }

    /// News of an engine that has been replaced is old.
    fn engine_of(&mut self, number: u64) -> Option<&mut Engine> {
        self.engine.as_mut().filter(|engine| engine.number == number)
    }

    fn drop_file(&mut self, file: PathBuf) {
        let (_, files) = self.dropped.get_or_insert_with(|| (Instant::now(), Vec::new()));
        files.push(file);
    }

    /// Loads what was dropped, or what has changed, when it is time. Returns when to look again.
    fn look_after_files(&mut self) -> Option<Instant> {
        let due = self.dropped.as_ref().map(|(since, _)| *since + TOGETHER);
        if due.is_some_and(|due| Instant::now() >= due) {
            let (_, files) = self.dropped.take().unwrap_or_else(|| (Instant::now(), Vec::new()));
            if self.loading.is_possible() {
                self.loading.begin(files, &self.screen);
            } else {
                self.warn("this window shows no other files");
            }
        }
        if self.loading.have_changed() {
            self.reload();
        }
        [self.dropped.as_ref().map(|(since, _)| *since + TOGETHER), self.loading.due()].into_iter().flatten().min()
    }
}

impl ApplicationHandler<News> for Viewer {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        if self.open.is_none()
            && let Err(problem) = self.open(events)
        {
            self.fail(WindowError::Open(problem), events);
        }
    }

    fn user_event(&mut self, events: &ActiveEventLoop, news: News) {
        match news {
            News::Picture => {
                self.redraw();
                self.title_soon();
            }
            News::Screenshot(Ok(file)) => {
                tell(format_args!("mobula: wrote {file}"));
                self.say(&format!("wrote {}", file.split("; ").next().unwrap_or_default()));
            }
            News::Screenshot(Err(problem)) => self.warn(&problem),
            News::Loaded(number, files, loaded) => self.loaded(number, files, loaded, events),
            News::View(number, view, first) => {
                if let Some(engine) = self.engine_of(number) {
                    engine.chosen.view = view;
                    engine.automatic &= first;
                    if first {
                        engine.first_view = view;
                    }
                }
            }
            News::Picked(number, picked, center) => self.picked(number, picked, center),
            News::Ended(number) => {
                if self.engine_of(number).is_some() {
                    events.exit();
                }
            }
        }
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        match event {
            WindowEvent::CloseRequested => events.exit(),
            WindowEvent::Resized(size) => {
                self.open.iter_mut().for_each(|open| open.size = size);
                self.resize(size);
                self.redraw();
            }
            WindowEvent::RedrawRequested => {
                if let Err(problem) = self.draw() {
                    self.fail(WindowError::Open(problem), events);
                }
            }
            WindowEvent::ModifiersChanged(modifiers) => self.modifiers = modifiers.state(),
            WindowEvent::KeyboardInput { event, .. } => self.key(&event, events),
            WindowEvent::MouseInput { button, state, .. } => self.mouse_button(button, state),
            WindowEvent::CursorMoved { position, .. } => self.mouse_moved(position),
            WindowEvent::MouseWheel { delta, .. } => self.wheel(delta),
            WindowEvent::DroppedFile(file) => self.drop_file(file),
            WindowEvent::Focused(false) => {
                self.let_go();
                self.stand_still();
            }
            _ => {}
        }
    }

    fn device_event(&mut self, _: &ActiveEventLoop, _: DeviceId, event: DeviceEvent) {
        if let DeviceEvent::MouseMotion { delta: (x, y) } = event {
            self.look_around([x as f32, y as f32]);
        }
    }

    fn about_to_wait(&mut self, events: &ActiveEventLoop) {
        let step_due = self.engine.as_mut().and_then(|engine| engine.volumes.tick(&engine.handle));
        if step_due.is_some() {
            self.title_soon();
        }
        let files_due = self.look_after_files();
        let travel_due = self.move_on();
        let overlay_due = self.look_after_overlay();
        let due = [step_due, files_due, travel_due, overlay_due].into_iter().flatten().min();
        events.set_control_flow(due.map_or(ControlFlow::Wait, ControlFlow::WaitUntil));
    }
}
