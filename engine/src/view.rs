//! Where a camera stands and looks: plain data, with the operations of a viewer.

use glam::{Vec2, Vec3};

use crate::math::{normalize, normalize_or};

/// Which axis of a model points up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Up {
    /// The y axis, as most modellers have it.
    #[default]
    Y,
    /// The z axis, as engineering and geography have it.
    Z,
}

impl Up {
    /// The unit vector.
    pub const fn vector(self) -> Vec3 {
        match self {
            Self::Y => Vec3::Y,
            Self::Z => Vec3::Z,
        }
    }

    /// Turns a direction that was thought of with y up and z towards the viewer.
    pub const fn from_y_up(self, v: Vec3) -> Vec3 {
        match self {
            Self::Y => v,
            Self::Z => Vec3::new(v.x, -v.z, v.y),
        }
    }

    /// As [`from_y_up`](Self::from_y_up), turned around the axis by so many quarters of a turn, to the right as seen from in front.
    pub const fn turned(self, v: Vec3, quarters: u8) -> Vec3 {
        self.from_y_up(match quarters % 4 {
            0 => v,
            1 => Vec3::new(v.z, v.y, -v.x),
            2 => Vec3::new(-v.x, v.y, -v.z),
            _ => Vec3::new(-v.z, v.y, v.x),
        })
    }

    /// As one thinks of a direction with y up and z towards the viewer: the inverse of [`from_y_up`](Self::from_y_up).
    pub const fn to_y_up(self, v: Vec3) -> Vec3 {
        match self {
            Self::Y => v,
            Self::Z => Vec3::new(v.x, v.z, -v.y),
        }
    }

    /// Guesses from the bounds of a model. It is z where the model stands on z = 0 but not on y = 0, or where it is
    /// much flatter in z than in x and y (a terrain, a house) and does not have its middle at z = 0; else y.
    pub fn guess(bounds: (Vec3, Vec3)) -> Self {
        let (low, high) = bounds;
        let size = high - low;
        let stands = |axis: usize| low[axis].abs() <= 0.01 * size[axis];
        let flat = size.z < 0.6 * size.x.min(size.y);
        let centered = (low.z + high.z).abs() <= 0.1 * size.z;
        if !stands(1) && (stands(2) || (flat && !centered)) { Self::Z } else { Self::Y }
    }
}

impl std::str::FromStr for Up {
    type Err = crate::choice::UnknownName;
    fn from_str(name: &str) -> Result<Self, Self::Err> {
        match name {
            "y" | "Y" => Ok(Self::Y),
            "z" | "Z" => Ok(Self::Z),
            _ => Err(Self::Err { kind: "up axis", name: name.to_owned(), known: "y, z".to_owned() }),
        }
    }
}

/// A corner of a box, 0 to 7.
fn corner((low, high): (Vec3, Vec3), i: usize) -> Vec3 {
    let pick = |axis: usize| if i >> axis & 1 == 0 { low[axis] } else { high[axis] };
    Vec3::new(pick(0), pick(1), pick(2))
}

/// A side of a model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// What faces the viewer where y is up and x goes to the right.
    Front,
    /// The opposite.
    Back,
    /// Where x is greatest, seen from the front.
    Right,
    /// The opposite.
    Left,
    /// From above.
    Top,
    /// From below.
    Bottom,
}

impl Side {
    /// Towards the eye, with y up. Straight from above or below nobody could tell what is up in the picture: a thousandth in front.
    fn backward(self) -> Vec3 {
        match self {
            Self::Front => Vec3::Z,
            Self::Back => Vec3::NEG_Z,
            Self::Right => Vec3::X,
            Self::Left => Vec3::NEG_X,
            Self::Top => Vec3::new(0.0, 1.0, 1e-3),
            Self::Bottom => Vec3::new(0.0, -1.0, 1e-3),
        }
    }
}

/// A point of view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Where the eye is.
    pub eye: Vec3,
    /// What it looks at; orbits turn around it.
    pub at: Vec3,
    /// Which way is up; need not be perpendicular to anything.
    pub up: Vec3,
    /// Vertical field of view, degrees.
    pub fov: f32,
}

/// The lens of a camera that has one. What is `None` is as usual for it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lens {
    /// Its radius, in units of the scene; 0: all is in focus.
    pub aperture: Option<f32>,
    /// The distance of what is in focus, along the view; `None`: that of the point that is looked at.
    pub focus: Option<f32>,
}

impl View {
    /// The greatest vertical field of view of a camera that projects to a plane, degrees.
    pub const WIDEST: f32 = 170.0;
    /// Vertical field of view of [`frame`](Self::frame), degrees.
    pub const DEFAULT_FOV: f32 = 35.0;
    /// Part of the half image that framed models may fill.
    const FILL: f32 = 0.92;
    /// From the model towards the eye, with y up: from the right, in front, above.
    const THREE_QUARTERS: Vec3 = Vec3::new(0.58, 0.40, 0.74);

    /// From the model towards the eye, a unit vector: from the right, in front, above, turned by so many quarters of a turn.
    pub fn usual_direction(up: Up, quarters: u8) -> Vec3 {
        normalize(up.turned(Self::THREE_QUARTERS, quarters))
    }

    /// The three-quarter view that shows all of `bounds`, with a small margin, in an image whose width is `aspect` times
    /// its height. Bounds that are empty or not finite give a view of the unit cube.
    pub fn frame(bounds: (Vec3, Vec3), up: Up, aspect: f32) -> Self {
        Self::frame_points(|visit| (0..8).map(|i| corner(bounds, i)).for_each(visit), bounds, up, aspect)
    }

    /// As [`frame`](Self::frame), but fits the points that `visit_all` calls its argument with, which should all be within
    /// `bounds`: tighter where a model leaves its bounds' corners empty.
    pub fn frame_points(
        visit_all: impl FnOnce(&mut dyn FnMut(Vec3)),
        bounds: (Vec3, Vec3),
        up: Up,
        aspect: f32,
    ) -> Self {
        let eye = Self::usual_direction(up, 0);
        let toward = Self { eye, at: Vec3::ZERO, up: up.vector(), fov: Self::DEFAULT_FOV };
        toward.fit(visit_all, bounds, aspect)
    }

    /// A view in the same direction, with the same field of view, that shows all points that `visit_all` calls its argument with: see
    /// [`frame_points`](Self::frame_points).
    pub fn fit(&self, visit_all: impl FnOnce(&mut dyn FnMut(Vec3)), bounds: (Vec3, Vec3), aspect: f32) -> Self {
        let (mut low, mut high) = bounds;
        let mut radius = 0.5 * (high * 0.5 - low * 0.5).length() * 2.0;
        let sound = low.cmple(high).all() && low.is_finite() && high.is_finite() && radius.is_finite();
        if !sound {
            (low, high) = (Vec3::splat(-0.5), Vec3::splat(0.5));
            radius = 0.5 * (high - low).length();
        }
        let middle = low * 0.5 + high * 0.5;
        // One point is framed as a small cube around it would be.
        let scale = if radius > 0.0 { radius } else { middle.abs().max_element().max(1.0) * 1e-3 };

        let [right, upward, forward] = self.basis();
        let backward = -forward;
        let aspect = if aspect.is_finite() && aspect > 0.0 { aspect } else { 1.0 };
        let slope_y = self.slope() * Self::FILL;
        let slopes = Vec2::new(slope_y * aspect, slope_y);

        // In coordinates relative to the middle, in units of the scale: with depth d towards the eye, a point is within
        // the image if |p.x - eye.x| <= slope.x (eye.d - p.d), and likewise y. Both sides' limits give the least eye.d;
        // the eye goes half way between them.
        let mut limits = [Vec2::splat(f32::NEG_INFINITY); 2];
        let mut nearest = f32::NEG_INFINITY;
        let mut include = |point: Vec3| {
            let p = (point - middle) / scale;
            let (flat, depth) = (Vec2::new(p.dot(right), p.dot(upward)), p.dot(backward));
            limits[0] = limits[0].max(flat + slopes * depth);
            limits[1] = limits[1].max(slopes * depth - flat);
            nearest = nearest.max(depth);
        };
        if sound {
            visit_all(&mut include);
        } else {
            (0..8).for_each(|i| include(corner((low, high), i)));
        }
        let offset = (limits[0] - limits[1]) * 0.5;
        let depths = (limits[0] + limits[1]) / (slopes * 2.0);
        // A tenth of the size is kept free before the eye: a model that is seen end on may need no distance at all.
        let depth = depths.max_element().max(nearest + 0.1);
        let (offset, depth) = if depth.is_finite() { (offset, depth) } else { (Vec2::ZERO, 2.0 / slope_y) };

        let at = middle + (right * offset.x + upward * offset.y) * scale;
        Self { eye: at + backward * (depth * scale), at, ..*self }
    }

    /// The same in another direction: from a side of the model, whose axis `axis` points up.
    pub fn from_side(&self, side: Side, axis: Up) -> Self {
        let backward = axis.from_y_up(side.backward());
        let distance = self.distance();
        Self { eye: self.at + normalize(backward) * distance, up: axis.vector(), ..*self }
    }

    /// Unit vectors right, up and forward of the image. Total: where `up` is parallel to the view, or eye and `at` are
    /// the same, some sensible basis.
    pub fn basis(&self) -> [Vec3; 3] {
        let difference = [0, 1, 2].map(|i| f64::from(self.at[i]) - f64::from(self.eye[i]));
        let forward = normalize_or(difference, Vec3::NEG_Z);
        let up = normalize_or(self.up.to_array().map(f64::from), Vec3::Y);
        let across = forward.cross(up);
        let right = if across.length_squared() > 1e-8 {
            normalize(across)
        } else {
            // The axis that is least parallel to forward.
            let size = forward.abs();
            let other = if size.x <= size.y && size.x <= size.z {
                Vec3::X
            } else if size.y <= size.z {
                Vec3::Y
            } else {
                Vec3::Z
            };
            normalize(forward.cross(other))
        };
        [right, right.cross(forward), forward]
    }

    /// Distance from the eye to what it looks at.
    pub fn distance(&self) -> f32 {
        (self.at - self.eye).length()
    }

    /// Turns the eye around `at`: by `yaw` radians around the up axis (positive: the model turns to the right), and by
    /// `pitch` up or down (positive: the eye rises), stopping short of the poles.
    pub fn orbit(&self, yaw: f32, pitch: f32) -> Self {
        let up = normalize_or(self.up.to_array().map(f64::from), Vec3::Y);
        let backward = self.eye - self.at;
        let distance = backward.length();
        if !(distance > 0.0 && yaw.is_finite() && pitch.is_finite()) {
            return *self;
        }
        let [right, ..] = self.basis();
        let backward = normalize(backward);
        let level = right.cross(up);
        let height = libm::asinf(backward.dot(up).clamp(-1.0, 1.0));
        const POLE: f32 = 1.55;
        let height = (height + pitch).clamp(-POLE, POLE);
        let (sin_yaw, cos_yaw) = (libm::sinf(-yaw), libm::cosf(-yaw));
        let flat = level * cos_yaw + right * sin_yaw;
        let backward = normalize(flat * libm::cosf(height) + up * libm::sinf(height));
        Self { eye: self.at + backward * distance, ..*self }
    }

    /// The left and the right eye, so far apart, both looking at `at`: what is there has the same place in both pictures.
    pub fn eyes(&self, apart: f32) -> [Self; 2] {
        let [right, ..] = self.basis();
        [-0.5, 0.5].map(|side| Self { eye: self.eye + right * (side * apart), ..*self })
    }

    /// Moves eye and `at` sideways, by fractions of the image's height at the distance of `at` (positive: the model
    /// moves right and up).
    pub fn pan(&self, right: f32, up: f32) -> Self {
        let [r, u, _] = self.basis();
        let height = 2.0 * self.distance() * self.slope();
        let by = (r * right + u * up) * -height;
        if by.is_finite() { Self { eye: self.eye + by, at: self.at + by, ..*self } } else { *self }
    }

    /// Moves the eye towards `at` (`factor` below 1) or away from it: the distance is multiplied by `factor`.
    pub fn dolly(&self, factor: f32) -> Self {
        let eye = self.at + (self.eye - self.at) * factor;
        if factor > 0.0 && eye.is_finite() && eye != self.at { Self { eye, ..*self } } else { *self }
    }

    /// As [`dolly`](Self::dolly), towards what is at a place of the picture, which keeps its place: `[0, 0]` is the middle, 1 upwards half the
    /// picture's height.
    pub fn dolly_toward(&self, [x, y]: [f32; 2], factor: f32) -> Self {
        let [right, up, _] = self.basis();
        let fixed = self.at + (right * x + up * y) * (self.distance() * self.slope());
        let [eye, at] = [self.eye, self.at].map(|point| fixed + (point - fixed) * factor);
        let moved = eye.is_finite() && at.is_finite() && eye != at;
        if factor > 0.0 && moved { Self { eye, at, ..*self } } else { *self }
    }

    /// Moves eye and `at` together so that a point is in the middle of the picture, and looks at it: orbits turn around it then. What is
    /// behind the eye does not change the view.
    pub fn center(&self, point: Vec3) -> Self {
        let [.., forward] = self.basis();
        let depth = (point - self.eye).dot(forward);
        let eye = point - forward * depth;
        if depth > 0.0 && eye.is_finite() && eye != point { Self { eye, at: point, ..*self } } else { *self }
    }

    /// Turns what is looked at around the eye: to the right by `yaw` radians around the up axis, and up by `pitch`, stopping short of the
    /// poles.
    pub fn turn(&self, yaw: f32, pitch: f32) -> Self {
        // What is looked at orbits around the eye.
        let turned = Self { eye: self.at, at: self.eye, ..*self }.orbit(yaw, pitch);
        Self { eye: turned.at, at: turned.eye, ..*self }
    }

    /// Moves eye and `at` to the right, up along the up axis, and forward, by lengths.
    pub fn walk(&self, [right, up, forward]: [f32; 3]) -> Self {
        let [r, _, f] = self.basis();
        let by = r * right + normalize_or(self.up.to_array().map(f64::from), Vec3::Y) * up + f * forward;
        if by.is_finite() { Self { eye: self.eye + by, at: self.at + by, ..*self } } else { *self }
    }

    /// Narrows (`factor` below 1) or widens the field of view, within 1 to 150 degrees.
    pub fn zoom(&self, factor: f32) -> Self {
        let fov = (self.fov * factor).clamp(1.0, 150.0);
        if fov.is_finite() { Self { fov, ..*self } } else { *self }
    }

    /// Half the image's height at distance 1.
    pub fn slope(&self) -> f32 {
        let fov = if self.fov.is_finite() { self.fov.clamp(1e-3, 179.0) } else { Self::DEFAULT_FOV };
        libm::tanf(fov.to_radians() * 0.5)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Image coordinates of a point, -1..1 where it is seen; `None` behind the eye.
    fn project(view: &View, aspect: f32, point: Vec3) -> Option<Vec2> {
        let [r, u, f] = view.basis();
        let v = point - view.eye;
        let depth = v.dot(f);
        (depth > 0.0).then(|| Vec2::new(v.dot(r) / aspect, v.dot(u)) / (depth * view.slope()))
    }

    fn corners(low: Vec3, high: Vec3) -> impl Iterator<Item = Vec3> {
        (0..8).map(move |i| {
            let pick = |a: usize| if i >> a & 1 == 0 { low[a] } else { high[a] };
            Vec3::new(pick(0), pick(1), pick(2))
        })
    }

    proptest! {
        #[test]
        fn framing_keeps_all_corners_in_view(
            low in prop::array::uniform3(-1.0_f32..1.0),
            size in prop::array::uniform3(prop_oneof![Just(0.0_f32), 0.0_f32..2.0]),
            scale in prop_oneof![Just(1e-6_f32), Just(1.0), Just(1e6)],
            aspect in 0.2_f32..5.0,
            z in any::<bool>(),
        ) {
            let (low, size) = (Vec3::from(low) * scale, Vec3::from(size) * scale);
            let up = if z { Up::Z } else { Up::Y };
            let view = View::frame((low, low + size), up, aspect);
            let mut widest = 0.0_f32;
            for corner in corners(low, low + size) {
                let at = project(&view, aspect, corner);
                prop_assert!(at.is_some(), "{:?} is behind {:?}", corner, view);
                widest = widest.max(at.unwrap().abs().max_element());
            }
            prop_assert!(widest < 0.97, "a corner at {} in {:?}", widest, view);
            let solid = size.max_element() > 1e-2 * low.abs().max_element();
            prop_assert!(!solid || widest > 0.5, "wasted space: {} in {:?}", widest, view);
        }

        #[test]
        fn orbits_keep_the_distance(yaw in -7.0_f32..7.0, pitch in -4.0_f32..4.0) {
            let view = View::frame((Vec3::NEG_ONE, Vec3::ONE), Up::Z, 1.5);
            let turned = view.orbit(yaw, pitch);
            prop_assert!((turned.distance() / view.distance() - 1.0).abs() < 1e-4);
            prop_assert!(turned.basis().iter().all(|v| (v.length() - 1.0).abs() < 1e-5));
        }
    }

    #[test]
    fn two_eyes_are_apart_and_look_at_the_same() {
        let view = View::frame((Vec3::NEG_ONE, Vec3::ONE), Up::Z, 1.5);
        let [left, right] = view.eyes(0.25);
        assert!(((right.eye - left.eye).length() - 0.25).abs() < 1e-6);
        assert!((right.eye - left.eye).dot(view.basis()[0]) > 0.0, "the right eye is on the right");
        assert!([left, right].iter().all(|eye| eye.at == view.at && eye.up == view.up && eye.fov == view.fov));
    }

    #[test]
    fn orbits_turn_back() {
        let view = View::frame((Vec3::NEG_ONE, Vec3::ONE), Up::Y, 1.0);
        let back = view.orbit(0.3, 0.2).orbit(0.0, -0.2).orbit(-0.3, 0.0);
        assert!((back.eye - view.eye).length() < 1e-4 * view.distance());
    }

    #[test]
    fn what_is_under_the_mouse_stays_there() {
        let view = View::frame((Vec3::NEG_ONE, Vec3::ONE), Up::Z, 1.0);
        let place = [0.4, -0.7];
        let [r, u, f] = view.basis();
        let ray = f + (r * place[0] + u * place[1]) * view.slope();
        let near = view.dolly_toward(place, 0.5);
        for depth in [1.5 * view.distance(), 3.0 * view.distance()] {
            let seen = project(&near, 1.0, view.eye + ray * depth).unwrap();
            assert!((seen - Vec2::from(place)).length() < 1e-4, "{seen}");
        }
        assert!((near.distance() - 0.5 * view.distance()).abs() < 1e-4);
        let point = view.at + Vec3::new(0.3, 0.2, -0.1);
        let centered = view.center(point);
        assert!(project(&centered, 1.0, point).unwrap().length() < 1e-4);
        assert!((centered.basis()[2] - f).length() < 1e-5 && centered.at == point);
        assert_eq!(view.center(view.eye - f), view, "behind the eye");
    }

    #[test]
    fn turning_and_walking() {
        let view = View { eye: Vec3::ZERO, at: Vec3::NEG_Z, up: Vec3::Y, fov: 40.0 };
        let right = view.turn(0.5, 0.0);
        assert!(right.at.x > 0.4 && right.at.y.abs() < 1e-5 && right.eye == view.eye, "{right:?}");
        let up = view.turn(0.0, 0.5);
        assert!(up.at.y > 0.4 && up.at.x.abs() < 1e-5, "{up:?}");
        let moved = view.walk([1.0, 2.0, 3.0]);
        assert!(
            (moved.eye - Vec3::new(1.0, 2.0, -3.0)).length() < 1e-5 && (moved.at - moved.eye + Vec3::Z).length() < 1e-5
        );
    }

    #[test]
    fn sides_are_seen_upright() {
        let view = View::frame((Vec3::NEG_ONE, Vec3::ONE), Up::Z, 1.0);
        for (side, right, up) in [
            (Side::Front, Vec3::X, Vec3::Z),
            (Side::Back, Vec3::NEG_X, Vec3::Z),
            (Side::Right, Vec3::Y, Vec3::Z),
            (Side::Left, Vec3::NEG_Y, Vec3::Z),
            (Side::Top, Vec3::X, Vec3::Y),
            (Side::Bottom, Vec3::X, Vec3::NEG_Y),
        ] {
            let [r, u, _] = view.from_side(side, Up::Z).basis();
            assert!((r - right).length() < 0.01 && (u - up).length() < 0.01, "{side:?}: {r} {u}");
        }
    }

    #[test]
    fn empty_and_broken_bounds_give_a_view() {
        let empty = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for bounds in [empty, (Vec3::NAN, Vec3::ONE), (Vec3::MIN, Vec3::MAX), (Vec3::ZERO, Vec3::ZERO)] {
            let view = View::frame(bounds, Up::Y, 1.0);
            assert!(view.eye.is_finite() && view.distance() > 0.0, "{view:?}");
        }
    }

    #[test]
    fn a_basis_exists_for_any_view() {
        let base = View { eye: Vec3::ZERO, at: Vec3::NEG_Y, up: Vec3::Y, fov: 30.0 };
        for view in
            [base, View { at: Vec3::ZERO, ..base }, View { up: Vec3::NAN, ..base }, View { at: Vec3::MAX, ..base }]
        {
            let [r, u, f] = view.basis();
            assert!(r.dot(u).abs() < 1e-5 && r.dot(f).abs() < 1e-5 && u.dot(f).abs() < 1e-5, "{view:?}");
            assert!([r, u, f].iter().all(|v| (v.length() - 1.0).abs() < 1e-5), "{view:?}");
        }
    }

    #[test]
    fn the_up_axis_of_known_models_is_guessed() {
        let guess = |low: [f32; 3], high: [f32; 3]| Up::guess((low.into(), high.into()));
        let bunny = guess([-1.0, -0.991233, -0.775047], [1.0, 0.991233, 0.775047]);
        let motorbike = guess([-0.291665, -0.350289, -4.232e-05], [1.75115, 0.332267, 1.35152]);
        let engine2cyl = guess([-371.692, -180.972, -140.0], [371.692, 92.042, 128.0]);
        let fzk_house = guess([-3.0, -3.0, -1.0], [15.0, 13.0, 6.31769]);
        let funnel = guess([-94.9827, -14.9998, -80.0], [49.9996, 200.0, 124.779]);
        assert_eq!([bunny, motorbike, engine2cyl, fzk_house, funnel], [Up::Y, Up::Z, Up::Y, Up::Z, Up::Y]);
    }
}
