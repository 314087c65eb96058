//! What the mouse does: drags, clicks, the wheel.

use std::time::{Duration, Instant};

use winit::dpi::PhysicalPosition;
use winit::event::{ElementState, MouseButton, MouseScrollDelta};

use super::{Press, Viewer};
use crate::app::Picked;
use crate::camera::CameraKind;
use crate::display::window::navigation::{Drag, dolly};
use crate::display::window::news::{News, tell};

/// What moves less, in pixels, is a click.
const CLICK: f64 = 4.0;
/// Two clicks within this are a double click.
const DOUBLE: Duration = Duration::from_millis(400);

impl Viewer {
    pub(super) fn mouse_button(&mut self, button: MouseButton, state: ElementState) {
        match (state, &self.press) {
            (ElementState::Pressed, None) => {
                let drag = match button {
                    MouseButton::Left if self.modifiers.shift_key() => Drag::Pan,
                    MouseButton::Left if self.modifiers.control_key() => Drag::Values,
                    MouseButton::Left => Drag::Orbit,
                    MouseButton::Right | MouseButton::Middle => Drag::Pan,
                    _ => return,
                };
                self.press = Some(Press { button, drag, at: self.mouse, moved: false });
            }
            (ElementState::Released, Some(press)) if press.button == button => {
                let click = !press.moved && press.drag == Drag::Orbit;
                self.let_go();
                if click {
                    self.click();
                }
            }
            _ => {}
        }
    }

    /// Ends a drag: pictures are refined again.
    pub(super) fn let_go(&mut self) {
        if self.press.take().is_some_and(|press| press.moved)
            && let Some(engine) = &self.engine
        {
            engine.hold(false);
        }
    }

    fn click(&mut self) {
        let (at, now) = (self.mouse, Instant::now());
        let double =
            self.clicked.take().is_some_and(|(then, there)| now - then <= DOUBLE && distance(at, there) < CLICK);
        self.pick(at, double);
        if !double {
            self.clicked = Some((now, at));
        }
    }

    pub(super) fn mouse_moved(&mut self, to: PhysicalPosition<f64>) {
        let from = std::mem::replace(&mut self.mouse, to);
        let (Some(press), Some(engine)) = (&mut self.press, &mut self.engine) else { return };
        let mut by = [(to.x - from.x) as f32, (to.y - from.y) as f32];
        if !press.moved {
            if distance(to, press.at) < CLICK {
                return;
            }
            press.moved = true;
            engine.hold(true);
            by = [(to.x - press.at.x) as f32, (to.y - press.at.y) as f32];
        }
        if press.drag == Drag::Values {
            engine.move_values(by);
            self.title_soon();
        } else {
            engine.look(press.drag.apply(&engine.chosen.view, by, self.size.height() as f32));
        }
    }

    pub(super) fn wheel(&mut self, delta: MouseScrollDelta) {
        let notches = match delta {
            MouseScrollDelta::LineDelta(_, lines) => lines,
            MouseScrollDelta::PixelDelta(pixels) => pixels.y as f32 / 40.0,
        };
        if self.travel.flies() {
            self.travel.hurry(notches);
            return;
        }
        let (width, height) = (self.size.width() as f32, self.size.height() as f32);
        let place =
            [2.0 * self.mouse.x as f32 - width, height - 2.0 * self.mouse.y as f32].map(|pixels| pixels / height);
        if let Some(engine) = &mut self.engine {
            // Where pictures are not flat the view goes straight on.
            let flat = [CameraKind::Pinhole, CameraKind::ThinLens, CameraKind::Orthographic];
            let plain = flat.contains(&engine.chosen.camera);
            let place = if plain { place } else { [0.0; 2] };
            engine.look(dolly(&engine.chosen.view, place, notches));
        }
    }

    /// Asks what is at a place; `center`: and brings it into the middle.
    pub(super) fn pick(&mut self, at: PhysicalPosition<f64>, center: bool) {
        let Some(engine) = &self.engine else { return };
        let (screen, number, place) = (self.screen.clone(), engine.number, [at.x as f32, at.y as f32]);
        engine.handle.at_barrier("pick", move |point| {
            let size = point.channels()[0].size;
            screen.tell(News::Picked(number, point.state.pick(size, place), center));
        });
    }

    /// Tells what is at a place.
    pub(super) fn picked(&mut self, number: u64, picked: Option<Picked>, center: bool) {
        let Some(engine) = self.engine.as_mut().filter(|engine| engine.number == number) else { return };
        if let (Some(picked), true) = (&picked, center) {
            engine.look(engine.chosen.view.center(picked.position));
            return;
        }
        let text = picked.map_or("nothing is there".to_owned(), |picked| {
            let Picked { geometry, kind, primitive, material, position, distance } = picked;
            let place = engine.titles.place;
            let [x, y, z] = place.back(position.into()).map(|x| short(x, f64::from(distance) / place.scale));
            let distance = short(f64::from(distance) / place.scale, f64::from(distance) / place.scale);
            let name = if geometry.is_empty() { String::new() } else { format!("{geometry}: ") };
            format!("{name}{kind} {primitive}, material {material}, at {x}, {y}, {z}, {distance} away")
        });
        tell(format_args!("mobula: {text}"));
        self.say(&text);
    }
}

fn distance(a: PhysicalPosition<f64>, b: PhysicalPosition<f64>) -> f64 {
    (a.x - b.x).hypot(a.y - b.y)
}

/// A coordinate in as many digits as make sense at a distance: a hundred thousandth of it.
fn short(value: f64, distance: f64) -> String {
    let digits = (5.0 - distance.abs().max(1e-300).log10().ceil()).clamp(0.0, 12.0) as usize;
    let text = format!("{value:.digits$}");
    if digits > 0 { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_have_digits_that_make_sense() {
        let texts = [(1.234_567_89, 3.0), (2.5, 100.0), (481_234.567, 20_000.0), (0.001_234_56, 0.01), (-7.0, 0.0)];
        let texts = texts.map(|(value, distance)| short(value, distance));
        assert_eq!(texts, ["1.2346", "2.5", "481235", "0.0012346", "-7"]);
    }
}
