//! Mouse movements as movements of the view.

use crate::camera::View;

/// Turning by half a circle takes a drag of the window's height.
const ORBIT: f32 = std::f32::consts::PI;
/// One notch of the wheel brings the eye this much nearer.
const NOTCH: f32 = 0.88;

/// What a drag does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Drag {
    /// Turns the eye around what it looks at.
    Orbit,
    /// Moves the eye sideways.
    Pan,
    /// Changes what volumes are shown as.
    Values,
}

impl Drag {
    /// The view after a movement of the mouse by `(dx, dy)` pixels (down is positive) in a window of this height.
    pub(super) fn apply(self, view: &View, [dx, dy]: [f32; 2], height: f32) -> View {
        let (x, y) = (dx / height.max(1.0), dy / height.max(1.0));
        match self {
            Self::Orbit => view.orbit(x * ORBIT, y * ORBIT),
            Self::Pan => view.pan(x, -y),
            Self::Values => *view,
        }
    }
}

/// The view after turning the wheel, away from the user where `notches` is positive, with the mouse at a place of the picture as
/// [`View::dolly_toward`] has it.
pub(super) fn dolly(view: &View, place: [f32; 2], notches: f32) -> View {
    view.dolly_toward(place, NOTCH.powf(notches.clamp(-20.0, 20.0)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    const VIEW: View = View { eye: Vec3::new(0.0, 0.0, 4.0), at: Vec3::ZERO, up: Vec3::Y, fov: 40.0 };

    #[test]
    fn dragging_down_raises_the_eye() {
        let view = Drag::Orbit.apply(&VIEW, [0.0, 50.0], 400.0);
        assert!(view.eye.y > 0.1 && (view.distance() - 4.0).abs() < 1e-4, "{view:?}");
        // What was in the middle in front turns with the mouse: the eye goes the other way.
        let view = Drag::Orbit.apply(&VIEW, [50.0, 0.0], 400.0);
        assert!(view.eye.x < -0.1 && view.eye.y.abs() < 1e-4, "{view:?}");
    }

    #[test]
    fn panning_keeps_what_is_under_the_mouse() {
        let view = Drag::Pan.apply(&VIEW, [200.0, 0.0], 400.0);
        let height = 2.0 * 4.0 * 20.0_f32.to_radians().tan();
        assert!((view.at.x + height / 2.0).abs() < 1e-4, "{view:?}");
    }

    #[test]
    fn the_wheel_goes_and_comes_back() {
        let near = dolly(&VIEW, [0.5, 0.2], 1.0);
        assert!(near.distance() < 3.6);
        assert!((dolly(&near, [0.5, 0.2], -1.0).distance() - 4.0).abs() < 1e-4);
    }
}
