//! How the view moves by itself, in the window: the turntable, and flying.

use std::time::Instant;

use winit::window::CursorGrabMode;

use super::Viewer;
use crate::display::window::open::Open;

/// Radians for a movement of the mouse by a pixel.
const LOOK: f32 = 0.003;

impl Viewer {
    pub(super) fn toggle_turntable(&mut self) {
        self.end_flight();
        if self.engine.is_some() {
            self.travel.turn_or_stop();
        }
    }

    pub(super) fn toggle_flight(&mut self) {
        if self.travel.flies() {
            self.end_flight();
        } else if let Some(view) = self.view() {
            self.travel.fly(&view);
            grab(self.open.as_ref(), true);
            self.say("flying: w a s d, e up, q down, wheel: speed, g or Esc: stop");
        }
    }

    fn end_flight(&mut self) {
        if self.travel.flies() {
            self.travel.stop();
            grab(self.open.as_ref(), false);
        }
    }

    /// Nothing moves by itself any more.
    pub(super) fn stand_still(&mut self) {
        self.end_flight();
        self.travel.stop();
    }

    /// The mouse was moved while somebody flies.
    pub(super) fn look_around(&mut self, [x, y]: [f32; 2]) {
        if let (true, Some(view)) = (self.travel.flies(), self.view()) {
            self.look(view.turn(x * LOOK, -y * LOOK));
        }
    }

    /// Moves the view as far as time has gone on. Returns when to do so again.
    pub(super) fn move_on(&mut self) -> Option<Instant> {
        if let (Some(moves), Some(engine)) = (self.travel.has_begun_or_ended(), &self.engine) {
            engine.hold(moves);
        }
        let (view, due) = self.travel.go_on(&self.view()?)?;
        self.look(view);
        Some(due)
    }
}

/// Keeps the mouse in the window and hides it, or lets it go. Where the system does not do so the mouse looks around all the same.
fn grab(open: Option<&Open>, grabbed: bool) {
    let Some(Open { window, .. }) = open else { return };
    if !grabbed {
        let _ = window.set_cursor_grab(CursorGrabMode::None);
    } else if window.set_cursor_grab(CursorGrabMode::Locked).is_err() {
        let _ = window.set_cursor_grab(CursorGrabMode::Confined);
    }
    window.set_cursor_visible(!grabbed);
}
