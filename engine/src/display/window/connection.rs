//! From a pipeline to a window that shows it.

use std::thread;

use winit::event_loop::EventLoop;

use super::news::{News, Titles, WindowError, without_place};
use super::screen::Screen;
use super::viewer::Viewer;
use crate::app::{Settings, State};
use crate::pipeline::{DisplayStage, Pipeline};

/// A connection to the system's display, not yet a window. One process can make one.
#[derive(Debug)]
pub struct Connection {
    events: EventLoop<News>,
}

/// Is there a display to open a window on? A guess from the environment.
pub fn has_display() -> bool {
    let set = |name| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    cfg!(any(not(unix), target_vendor = "apple")) || set("DISPLAY") || set("WAYLAND_DISPLAY")
}

impl Connection {
    /// Connects to the display. Must be called on the first thread of the process.
    ///
    /// # Errors
    /// If there is none.
    pub fn open() -> Result<Self, WindowError> {
        let mut builder = EventLoop::with_user_event();
        #[cfg(all(unix, not(target_vendor = "apple")))]
        if std::env::var_os("DISPLAY").is_some_and(|value| !value.is_empty()) {
            // Where there is both, X11 draws the title bar, in which the frame statistics are.
            use winit::platform::x11::EventLoopBuilderExtX11;
            builder.with_x11();
        }
        let events = builder.build().map_err(|error| WindowError::Open(without_place(&error)))?;
        Ok(Self { events })
    }

    /// Shows the first channel of a pipeline, made with these settings, until the window is closed or the run ends.
    ///
    /// The pipeline should render on demand. It gets a display stage and a callback.
    ///
    /// # Errors
    /// If the window cannot be opened, or a component fails.
    pub fn show(self, mut pipeline: Pipeline<State>, settings: &Settings, titles: &Titles) -> Result<(), WindowError> {
        let proxy = self.events.create_proxy();
        let screen = Screen::new(proxy.clone());
        pipeline.add_stage(DisplayStage::new().with(0, screen.display()));
        let rays = screen.ray_counter();
        pipeline.callbacks().serial_pre_render("window statistics", move |point| rays.note(&point.state.rays()));
        let mut viewer = Viewer::new(titles, screen, settings, &mut pipeline);

        thread::scope(|scope| {
            let handle = pipeline.handle();
            let rendering = thread::Builder::new().spawn_scoped(scope, move || {
                let result = pipeline.run_until_stopped();
                // Nobody listens when the window was closed first.
                let _ = proxy.send_event(News::Ended);
                result
            });
            let rendering =
                rendering.map_err(|error| WindowError::Open(format!("no thread to render with: {error}")))?;
            let shown = self.events.run_app(&mut viewer).map_err(|error| WindowError::Open(without_place(&error)));
            let opened = viewer.finish();
            // Nobody waits for a frame that nobody will see.
            handle.halt();
            let rendered = rendering.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
            rendered?;
            shown.and(opened)
        })
    }
}
