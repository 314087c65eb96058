//! Views that move by themselves: the turntable, and flying with keys and mouse.

use std::time::{Duration, Instant};

use winit::event::{ElementState, KeyEvent};
use winit::keyboard::{KeyCode, PhysicalKey};

use crate::camera::View;

/// The view moves on as often as this, if pictures come as fast.
const TICK: Duration = Duration::from_millis(16);
/// Radians a second of the turntable: a turn in half a minute.
const TURN: f32 = std::f32::consts::TAU / 30.0;
/// What is looked at is reached within so many seconds.
const REACH: f32 = 2.5;

/// The keys of the flight: where each goes (right, up, forward).
const KEYS: [(KeyCode, [f32; 3]); 6] = [
    (KeyCode::KeyW, [0.0, 0.0, 1.0]),
    (KeyCode::KeyS, [0.0, 0.0, -1.0]),
    (KeyCode::KeyA, [-1.0, 0.0, 0.0]),
    (KeyCode::KeyD, [1.0, 0.0, 0.0]),
    (KeyCode::KeyE, [0.0, 1.0, 0.0]),
    (KeyCode::KeyQ, [0.0, -1.0, 0.0]),
];

/// How the view moves by itself.
#[derive(Default)]
pub(super) struct Travel {
    turns: bool,
    flight: Option<Flight>,
    /// When it moved last; none while it rests.
    moved: Option<Instant>,
}

struct Flight {
    held: [bool; KEYS.len()],
    /// Lengths a second.
    speed: f32,
}

impl Flight {
    fn direction(&self) -> [f32; 3] {
        let mut sum = [0.0; 3];
        for ((_, way), _) in KEYS.iter().zip(self.held).filter(|(_, held)| *held) {
            sum = [0, 1, 2].map(|axis| sum[axis] + way[axis]);
        }
        sum
    }
}

impl Travel {
    pub(super) fn flies(&self) -> bool {
        self.flight.is_some()
    }

    /// What the status says.
    pub(super) fn describe(&self) -> Option<String> {
        match &self.flight {
            Some(Flight { speed, .. }) => Some(format!("flying, {speed:.3} a second (wheel)")),
            None => self.turns.then(|| "turning".to_owned()),
        }
    }

    /// Is the view about to move?
    fn moves(&self) -> bool {
        self.turns || self.flight.as_ref().is_some_and(|flight| flight.direction() != [0.0; 3])
    }

    /// A key of the flight, if it is one and somebody flies.
    pub(super) fn key(&mut self, event: &KeyEvent) -> bool {
        let Some(flight) = &mut self.flight else { return false };
        let place = KEYS.iter().position(|(code, _)| event.physical_key == PhysicalKey::Code(*code));
        if let Some(place) = place {
            flight.held[place] = event.state == ElementState::Pressed;
        }
        place.is_some()
    }

    /// Flies faster or slower.
    pub(super) fn hurry(&mut self, notches: f32) {
        if let Some(flight) = &mut self.flight {
            flight.speed = (flight.speed * 1.25_f32.powf(notches.clamp(-20.0, 20.0))).clamp(1e-9, 1e9);
        }
    }

    /// Begins to turn, or stops.
    pub(super) fn turn_or_stop(&mut self) {
        (self.turns, self.flight) = (!self.turns, None);
    }

    /// Begins to fly, from a view.
    pub(super) fn fly(&mut self, view: &View) {
        self.turns = false;
        self.flight = Some(Flight { held: [false; KEYS.len()], speed: view.distance() / REACH });
    }

    /// Stops both.
    pub(super) fn stop(&mut self) {
        (self.turns, self.flight) = (false, None);
    }

    /// Has the view begun to move, or come to rest, since this was asked last?
    pub(super) fn has_begun_or_ended(&mut self) -> Option<bool> {
        let moves = self.moves();
        if moves == self.moved.is_some() {
            return None;
        }
        self.moved = moves.then(Instant::now);
        Some(moves)
    }

    /// The view after the time that has passed, and when to look again; none while it rests.
    pub(super) fn go_on(&mut self, view: &View) -> Option<(View, Instant)> {
        let moved = self.moved?;
        let now = Instant::now();
        if now < moved + TICK {
            return Some((*view, moved + TICK));
        }
        self.moved = Some(now);
        // After a long frame it goes on from where it is.
        Some((self.after(view, (now - moved).as_secs_f32().min(0.5)), now + TICK))
    }

    /// The view after so many seconds.
    fn after(&self, view: &View, seconds: f32) -> View {
        match &self.flight {
            Some(flight) => view.walk(flight.direction().map(|part| part * flight.speed * seconds)),
            None => view.orbit(TURN * seconds, 0.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    const VIEW: View = View { eye: Vec3::new(0.0, 0.0, 4.0), at: Vec3::ZERO, up: Vec3::Y, fov: 40.0 };

    #[test]
    fn the_turntable_turns_once_in_half_a_minute() {
        let travel = Travel { turns: true, ..Travel::default() };
        assert!(travel.moves());
        let half = travel.after(&VIEW, 15.0);
        assert!((half.eye + VIEW.eye).length() < 1e-4, "{half:?}");
    }

    #[test]
    fn keys_fly_forward_and_up() {
        let mut flight = Flight { held: [false; 6], speed: 2.0 };
        let travel = |held| Travel { flight: Some(Flight { held, speed: 2.0 }), ..Travel::default() };
        assert!(!travel(flight.held).moves());
        (flight.held[0], flight.held[4]) = (true, true);
        let travel = travel(flight.held);
        assert!(travel.moves() && travel.flies());
        assert!((travel.after(&VIEW, 0.5).eye - Vec3::new(0.0, 1.0, 3.0)).length() < 1e-5);
    }
}
