//! A window that shows scenes, from its opening to its end.

use std::sync::Arc;

use winit::event_loop::EventLoop;

use super::loading::Loader;
use super::news::{News, Ready, WindowError, without_place};
use super::screen::Screen;
use super::viewer::Viewer;
use crate::image::Size;

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

    /// Shows a scene until the window is closed or the run ends.
    ///
    /// The pipeline gets a display stage and a callback, and its pictures are refined while nothing changes, up to the samples of its
    /// sampler.
    ///
    /// # Errors
    /// If the window cannot be opened, or a component fails.
    pub fn show(self, ready: Ready) -> Result<(), WindowError> {
        let viewer = Viewer::new(Screen::new(self.events.create_proxy()), ready.settings.size, None);
        self.run(viewer, Some(ready))
    }

    /// Opens a window, loads a scene into it, and shows that until the window is closed; other files that are dropped on it take its place,
    /// and when its files change it is loaded again. `size` is the window's until the scene says another.
    ///
    /// # Errors
    /// If the window cannot be opened, nothing can be loaded, or a component fails.
    pub fn load(self, loader: Arc<dyn Loader>, size: Size) -> Result<(), WindowError> {
        let viewer = Viewer::new(Screen::new(self.events.create_proxy()), size, Some(loader));
        self.run(viewer, None)
    }

    fn run(self, mut viewer: Viewer, ready: Option<Ready>) -> Result<(), WindowError> {
        match ready {
            Some(ready) => viewer.put(ready, None)?,
            None => viewer.load_first(),
        }
        let shown = self.events.run_app(&mut viewer).map_err(|error| WindowError::Open(without_place(&error)));
        let ended = viewer.finish();
        match ended {
            Err(WindowError::Fault(fault)) => Err(fault.into()),
            ended => shown.and(ended),
        }
    }
}
