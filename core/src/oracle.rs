//! What is true: ray/primitive tests in `f64`, naive on purpose. Tests hold every kernel and traversal against this.
//!
//! Nothing here is fast or clever. A test answers with the distance of the hit, if there is one, and with a *margin*: how
//! far the primitive or the ray may move before the answer could become the other one. Single precision moves things by
//! some 2^-24 of their distance; where the margin is less than that, hit and miss are both right.
//!
//! - NaN, zero direction: missed, by an infinite margin.
//! - Degenerate primitive: a triangle without area or a sphere without a positive radius is missed.

use crate::Rays;

/// A point or direction.
pub type Vector = [f64; 3];

/// A ray with the interval `(t_min, t_max]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExactRay {
    /// Where it starts.
    pub origin: Vector,
    /// Where it goes; of any length.
    pub direction: Vector,
    /// Near end of the interval, not in it.
    pub t_min: f64,
    /// Far end of the interval, in it.
    pub t_max: f64,
}

impl ExactRay {
    /// The ray from `origin` along `direction`, with the interval `(0, inf]`.
    pub fn new(origin: [f32; 3], direction: [f32; 3]) -> Self {
        Self { origin: origin.map(f64::from), direction: direction.map(f64::from), t_min: 0.0, t_max: f64::INFINITY }
    }

    /// ExactRay `i` of a packet.
    pub fn of<const N: usize>(rays: &Rays<N>, i: usize) -> Self {
        let (origin, direction) = rays.ray(i);
        let (t_min, t_max) = (f64::from(rays.t_min()[i]), f64::from(rays.t_max[i]));
        Self { t_min, t_max, ..Self::new(origin.to_array(), direction.to_array()) }
    }

    fn is_usable(&self) -> bool {
        let length = length(self.direction);
        is_finite(self.origin) && length > 0.0 && length.is_finite()
    }

    fn contains(&self, t: f64) -> bool {
        self.t_min < t && t <= self.t_max
    }

    /// The ends of the interval that are points, relative to the origin.
    fn ends(&self) -> impl Iterator<Item = Vector> {
        [self.t_min, self.t_max].into_iter().filter(|t| t.is_finite()).map(|t| scale(self.direction, t))
    }
}

/// What is true of a ray and a primitive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Truth {
    /// Where the ray meets it, if it does.
    pub t: Option<f64>,
    /// How far ray or primitive may move before hit could become miss or the other way round, as a fraction of the
    /// greatest distance from the ray's origin to a point of the primitive.
    pub margin: f64,
}

impl Truth {
    const NOTHING: Self = Self { t: None, margin: f64::INFINITY };
}

/// ExactRay and triangle, both sides: the point where the ray meets the plane must be to one side of all three edges.
pub fn triangle(ray: &ExactRay, corners: [[f32; 3]; 3]) -> Truth {
    let [a, b, c] = corners.map(|corner| sub(corner.map(f64::from), ray.origin));
    if !ray.is_usable() || ![a, b, c].into_iter().all(is_finite) {
        return Truth::NOTHING;
    }
    let edges = [(a, b), (b, c), (c, a)];
    let mut margin = f64::INFINITY;
    for (from, to) in edges {
        margin = margin.min(line_to_segment(ray.direction, from, to));
    }
    let size = length(a).max(length(b)).max(length(c));
    let normal = cross(sub(b, a), sub(c, a));
    let t = dot(normal, a) / dot(normal, ray.direction);
    let point = scale(ray.direction, t);
    let inside = edges.into_iter().all(|(from, to)| dot(normal, cross(sub(to, from), sub(point, from))) >= 0.0);
    if !t.is_finite() || !inside {
        return Truth { t: None, margin: margin / size };
    }
    for end in ray.ends() {
        margin = margin.min((dot(normal, sub(end, a)) / length(normal)).abs());
    }
    Truth { t: ray.contains(t).then_some(t), margin: margin / size }
}

/// ExactRay and sphere `[x, y, z, radius]`: the nearer of two roots in the interval, so a ray from inside hits the far side.
pub fn sphere(ray: &ExactRay, sphere: [f32; 4]) -> Truth {
    let [x, y, z, radius] = sphere.map(f64::from);
    let center = sub([x, y, z], ray.origin);
    if !ray.is_usable() || !is_finite(center) || !radius.is_finite() || radius <= 0.0 {
        return Truth::NOTHING;
    }
    let size = length(center) + radius;
    let length2 = dot(ray.direction, ray.direction);
    let middle = dot(center, ray.direction) / length2;
    let closest = length(sub(center, scale(ray.direction, middle)));
    let mut margin = (radius - closest).abs();
    if closest > radius {
        return Truth { t: None, margin: margin / size };
    }
    for end in ray.ends() {
        margin = margin.min((length(sub(end, center)) - radius).abs());
    }
    let half = libm::sqrt((radius - closest) * (radius + closest) / length2);
    let t = [middle - half, middle + half].into_iter().find(|&t| ray.contains(t));
    Truth { t, margin: margin / size }
}

/// ExactRay and axis-aligned box, closed: where the ray enters it, `t_min` if it starts inside. The interval is closed here,
/// at both ends.
pub fn aabb(ray: &ExactRay, low: [f32; 3], high: [f32; 3]) -> Truth {
    let [low, high] = [low, high].map(|corner| sub(corner.map(f64::from), ray.origin));
    if !ray.is_usable() || !is_finite(low) || !is_finite(high) {
        return Truth::NOTHING;
    }
    // Where each slab is entered and left, and how far that moves when the plane moves by 1. The interval is one more slab.
    let mut entries = [(ray.t_min, 0.0); 4];
    let mut exits = [(ray.t_max, 0.0); 4];
    let mut slack = f64::INFINITY;
    for axis in 0..3 {
        let d = ray.direction[axis];
        if d == 0.0 {
            slack = slack.min((-low[axis]).min(high[axis]));
        } else {
            let (near, far) = if d > 0.0 { (low[axis], high[axis]) } else { (high[axis], low[axis]) };
            entries[axis] = (near / d, 1.0 / d.abs());
            exits[axis] = (far / d, 1.0 / d.abs());
        }
    }
    let mut t = ray.t_min;
    for (entry, entry_moves) in entries {
        t = t.max(entry);
        for (exit, exit_moves) in exits {
            let moves: f64 = entry_moves + exit_moves;
            let gap = exit - entry;
            slack = slack.min(if moves > 0.0 {
                gap / moves
            } else if gap < 0.0 {
                f64::NEG_INFINITY
            } else {
                f64::INFINITY
            });
        }
    }
    let size = (0..3).fold(0.0f64, |size, axis| size.max(low[axis].abs()).max(high[axis].abs()));
    Truth { t: (slack >= 0.0).then_some(t), margin: slack.abs() / size }
}

/// The nearest of the hits whose margin is at least `guard`, and its index; of equally near ones the first.
pub fn closest(truths: impl IntoIterator<Item = Truth>, guard: f64) -> Option<(usize, f64)> {
    let mut nearest: Option<(usize, f64)> = None;
    for (index, truth) in truths.into_iter().enumerate() {
        if let Some(t) = truth.t
            && truth.margin >= guard
            && nearest.is_none_or(|(_, least)| t < least)
        {
            nearest = Some((index, t));
        }
    }
    nearest
}

/// Distance between the line through 0 along `direction` and the segment from `from` to `to`.
fn line_to_segment(direction: Vector, from: Vector, to: Vector) -> f64 {
    // Seen along the line, it is the distance of a segment from the point 0.
    let length2 = dot(direction, direction);
    let from = sub(from, scale(direction, dot(from, direction) / length2));
    let to = sub(to, scale(direction, dot(to, direction) / length2));
    let edge = sub(to, from);
    let edge2 = dot(edge, edge);
    let along = if edge2 > 0.0 { (-dot(from, edge) / edge2).clamp(0.0, 1.0) } else { 0.0 };
    let nearest = [0, 1, 2].map(|axis| from[axis] + along * edge[axis]);
    length(nearest)
}

fn sub(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn scale(v: Vector, by: f64) -> Vector {
    [v[0] * by, v[1] * by, v[2] * by]
}

fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn length(v: Vector) -> f64 {
    libm::sqrt(dot(v, v))
}

fn is_finite(v: Vector) -> bool {
    v.into_iter().all(f64::is_finite)
}

#[cfg(test)]
mod tests {
    use super::*;

    const FACE: [[f32; 3]; 3] = [[0.0, 0.0, 2.0], [4.0, 0.0, 2.0], [0.0, 4.0, 2.0]];

    #[test]
    fn a_triangle_is_hit_from_both_sides_at_the_plane_by_the_distance_to_its_outline() {
        let front = triangle(&ExactRay::new([1.0, 1.0, 0.0], [0.0, 0.0, 0.5]), FACE);
        assert_eq!(front.t, Some(4.0));
        assert!((front.margin * 14f64.sqrt() - 1.0).abs() < 1e-12, "1 from two edges, {front:?}");
        assert_eq!(triangle(&ExactRay::new([1.0, 1.0, 5.0], [0.0, 0.0, -1.0]), FACE).t, Some(3.0));
        let miss = triangle(&ExactRay::new([-1.0, 1.0, 0.0], [0.0, 0.0, 1.0]), FACE);
        assert_eq!(miss.t, None);
        assert!((miss.margin * 30f64.sqrt() - 1.0).abs() < 1e-12, "{miss:?}");
    }

    #[test]
    fn an_interval_ends_at_its_far_end_and_begins_after_its_near_end() {
        let ray = ExactRay::new([1.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
        assert_eq!(triangle(&ExactRay { t_max: 2.0, ..ray }, FACE).t, Some(2.0));
        assert_eq!(triangle(&ExactRay { t_min: 2.0, ..ray }, FACE).t, None);
        assert_eq!(triangle(&ExactRay { t_max: 2.0, ..ray }, FACE).margin, 0.0);
        assert_eq!(triangle(&ExactRay { t_max: 1.0, ..ray }, FACE).t, None);
    }

    #[test]
    fn what_is_not_a_ray_or_a_primitive_is_missed() {
        let ray = ExactRay::new([1.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
        assert_eq!(triangle(&ExactRay { direction: [0.0; 3], ..ray }, FACE), Truth::NOTHING);
        assert_eq!(triangle(&ExactRay { origin: [f64::NAN; 3], ..ray }, FACE), Truth::NOTHING);
        assert_eq!(triangle(&ray, [FACE[0], FACE[0], FACE[2]]).t, None);
        assert_eq!(sphere(&ray, [1.0, 1.0, 3.0, 0.0]), Truth::NOTHING);
        assert_eq!(sphere(&ray, [1.0, 1.0, f32::NAN, 1.0]), Truth::NOTHING);
        assert_eq!(aabb(&ExactRay { direction: [f64::INFINITY; 3], ..ray }, [0.0; 3], [1.0; 3]), Truth::NOTHING);
    }

    #[test]
    fn a_sphere_is_hit_in_front_from_outside_and_behind_from_inside() {
        let ray = ExactRay::new([0.0, 0.0, -3.0], [0.0, 0.0, 2.0]);
        assert_eq!(sphere(&ray, [0.0, 0.0, 0.0, 1.0]), Truth { t: Some(1.0), margin: 0.25 });
        assert_eq!(sphere(&ExactRay { t_min: 1.5, ..ray }, [0.0, 0.0, 0.0, 1.0]).t, Some(2.0));
        assert_eq!(sphere(&ray, [0.0, 2.0, 0.0, 1.0]).t, None);
    }

    #[test]
    fn a_box_is_entered_at_its_near_face_and_missed_by_the_move_that_would_meet_it() {
        let ray = ExactRay::new([-2.0, 0.5, 0.5], [1.0, 0.0, 0.0]);
        assert_eq!(aabb(&ray, [0.0; 3], [1.0; 3]), Truth { t: Some(2.0), margin: 0.5 / 3.0 });
        assert_eq!(aabb(&ray, [0.0; 3], [1.0, 0.25, 1.0]), Truth { t: None, margin: 0.25 / 3.0 });
        assert_eq!(aabb(&ExactRay { origin: [0.5; 3], ..ray }, [0.0; 3], [1.0; 3]).t, Some(0.0));
        let diagonal = ExactRay::new([-1.0, 0.0, 0.5], [1.0, 1.0, 0.0]);
        let touch = aabb(&diagonal, [0.0; 3], [1.0; 3]);
        assert_eq!((touch.t, touch.margin), (Some(1.0), 0.0));
        assert_eq!(aabb(&ExactRay { t_max: 0.5, ..diagonal }, [0.0; 3], [1.0; 3]).t, None);
    }

    #[test]
    fn the_closest_is_the_first_of_the_nearest_that_is_clear() {
        let truth = |t, margin| Truth { t: Some(t), margin };
        let truths = [truth(2.0, 1.0), truth(1.0, 1.0), truth(1.0, 1.0), truth(0.5, 0.01), Truth::NOTHING];
        assert_eq!(closest(truths, 0.0), Some((3, 0.5)));
        assert_eq!(closest(truths, 0.1), Some((1, 1.0)));
        assert_eq!(closest([], 0.0), None);
    }
}
