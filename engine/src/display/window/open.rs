//! The window once it is open, and how pictures come into it.

use std::num::NonZeroU32;
use std::rc::Rc;

use softbuffer::{Context, SoftBufferError, Surface};
use winit::dpi::PhysicalSize;
use winit::event_loop::OwnedDisplayHandle;
use winit::window::Window;

use super::screen::Screen;
use super::strips::Strips;

/// The window once it is open.
pub(super) struct Open {
    pub(super) window: Rc<Window>,
    /// As the last event said: to ask a display that may be gone is a panic in `winit`.
    pub(super) size: PhysicalSize<u32>,
    surface: Surface<OwnedDisplayHandle, Rc<Window>>,
    /// Who draws what the surface cannot.
    strips: Option<Strips>,
}

impl Open {
    pub(super) fn new(window: Rc<Window>, display: OwnedDisplayHandle) -> Result<Self, String> {
        let context = Context::new(display).map_err(|error| error.to_string())?;
        let surface = Surface::new(&context, Rc::clone(&window)).map_err(|error| error.to_string())?;
        let size = window.inner_size();
        Ok(Self { window, size, surface, strips: None })
    }

    /// Draws the newest picture, enlarged or shrunk while the pipeline has not caught up with the window's size.
    pub(super) fn draw(&mut self, screen: &Screen) -> Result<(), String> {
        let Self { window, size: PhysicalSize { width, height }, surface, strips } = self;
        let (Some(width), Some(height)) = (NonZeroU32::new(*width), NonZeroU32::new(*height)) else {
            return Ok(());
        };
        let size = [width, height].map(|side| side.get() as usize);
        window.pre_present_notify();
        if strips.is_none() {
            let Err(problem) = draw_at_once(surface, [width, height], screen) else { return Ok(()) };
            *strips = Strips::new(window);
            if strips.as_ref().is_none_or(|strips| strips.fits(size)) {
                return Err(problem.to_string());
            }
        }
        // The picture is locked row by row: it takes its time to be sent.
        let fill = |y: usize, row: &mut [u32]| screen.lock().fill_row(size, y, row);
        strips.as_mut().map_or(Ok(()), |strips| strips.draw(size, &fill))
    }
}

fn draw_at_once(
    surface: &mut Surface<OwnedDisplayHandle, Rc<Window>>,
    [width, height]: [NonZeroU32; 2],
    screen: &Screen,
) -> Result<(), SoftBufferError> {
    surface.resize(width, height)?;
    let mut target = surface.buffer_mut()?;
    let size = [width, height].map(|side| side.get() as usize);
    let shared = screen.lock();
    for (y, row) in target.chunks_exact_mut(size[0]).enumerate() {
        shared.fill_row(size, y, row);
    }
    drop(shared);
    target.present()
}
