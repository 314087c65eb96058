//! Whether two peers found the same, and if not, who is right.
//!
//! Rays that pass a triangle's edge or a surface's rim, or end at a surface, may go either way by rounding. So where two
//! peers differ, the exact test (in `f64`) of each one's primitive says how far from its edges or its rim and from the ray's
//! ends the hit is: near them, the ray is in the *band* and either answer stands; well inside, somebody lost a hit.

use crate::rays::{Found, NOTHING, RaySet};
use crate::scenes::Primitives;

/// Distances count as equal up to this, relative.
const SAME: f32 = 1e-4;
/// A hit is near an edge if a barycentric coordinate is below this.
const EDGE: f64 = 1e-5;
/// Or if the edge is nearer than this part of the greatest coordinate: what rounding of positions to `f32` moves.
const ROUNDING: f64 = 4e-6;

/// How two sets of results compare.
#[derive(Clone, Debug, Default)]
pub struct Verdict {
    /// Hits of the first and of the second.
    pub hits: [usize; 2],
    /// Other primitive, same distance: shared edges and surfaces that lie in one another.
    pub ties: usize,
    /// Differ, but in the band.
    pub band: usize,
    /// The first lost a hit.
    pub lost_by_first: usize,
    /// The second lost a hit.
    pub lost_by_second: usize,
    /// The first rays of those that lost one, with who lost it.
    pub examples: Vec<String>,
}

impl Verdict {
    /// How many rays differ.
    pub fn differing(&self) -> usize {
        self.band + self.lost_by_first + self.lost_by_second
    }
}

/// The nearest primitive of a ray that has been found to be blocked.
pub type Blocker<'a> = &'a dyn Fn(usize) -> (u32, f32);

/// Compares closest hits, or blocked rays; for these, `blockers` names what blocks a ray according to each peer.
pub fn compare(
    primitives: &Primitives,
    rays: &RaySet,
    [first, second]: [&Found; 2],
    any_hit: bool,
    blockers: [Blocker<'_>; 2],
) -> Verdict {
    let mut verdict = Verdict { hits: [first.hits(any_hit), second.hits(any_hit)], ..Verdict::default() };
    for i in 0..rays.len() {
        let hit = [first.hit(i, any_hit), second.hit(i, any_hit)];
        if any_hit {
            match hit {
                [true, false] => verdict.judge(primitives, rays, i, blockers[0](i), None, 1),
                [false, true] => verdict.judge(primitives, rays, i, blockers[1](i), None, 0),
                _ => {}
            }
            continue;
        }
        let (a, b) = ((first.primitive[i], first.t[i]), (second.primitive[i], second.t[i]));
        match hit {
            [false, false] => {}
            [true, false] => verdict.judge(primitives, rays, i, a, None, 1),
            [false, true] => verdict.judge(primitives, rays, i, b, None, 0),
            [true, true] if (a.1 - b.1).abs() <= SAME * a.1.abs() => verdict.ties += usize::from(a.0 != b.0),
            [true, true] if a.1 < b.1 => verdict.judge(primitives, rays, i, a, Some(b.1), 1),
            [true, true] => verdict.judge(primitives, rays, i, b, Some(a.1), 0),
        }
    }
    verdict
}

impl Verdict {
    /// Ray `i` hits `(primitive, t)`, but peer `loser` did not find it; it found something at `instead`, or nothing.
    fn judge(
        &mut self,
        primitives: &Primitives,
        rays: &RaySet,
        i: usize,
        (primitive, t): (u32, f32),
        instead: Option<f32>,
        loser: usize,
    ) {
        if primitive == NOTHING || in_band(primitives, rays, i, (primitive, t), instead) {
            self.band += 1;
            return;
        }
        *(if loser == 0 { &mut self.lost_by_first } else { &mut self.lost_by_second }) += 1;
        if self.examples.len() < 4 {
            let (origin, direction) = rays.ray(i);
            let (far, peer) = (rays.t_max[i], ["the first", "the second"][loser]);
            self.examples.push(format!(
                "ray {i}, {origin:?} + t {direction:?} to {far}, hits primitive {primitive} at {t}; {peer} found {instead:?}"
            ));
        }
    }
}

/// Is the exact hit near an edge or the rim of the primitive, near an end of the ray, near the hit that was taken instead,
/// or does the ray lie in the plane?
fn in_band(primitives: &Primitives, rays: &RaySet, i: usize, hit: (u32, f32), instead: Option<f32>) -> bool {
    let (origin, direction) = rays.ray(i);
    let ray = (origin.map(f64::from), direction.map(f64::from));
    let exact = match primitives {
        Primitives::Triangles(triangles) => in_triangle(triangles.corners(hit.0 as usize), ray),
        Primitives::Spheres(spheres) => on_sphere(spheres[hit.0 as usize], ray, f64::from(hit.1)),
    };
    let Some((t, moved)) = exact else { return true };
    let near = |other: f32| (t - f64::from(other)).abs() <= moved;
    t <= moved || near(rays.t_max[i]) || instead.is_some_and(near)
}

/// Origin and direction.
type Ray = ([f64; 3], [f64; 3]);

/// Where the ray hits a triangle, and how far rounding moves that; nothing if it is near an edge or in the plane.
fn in_triangle(corners: [[f32; 3]; 3], (origin, direction): Ray) -> Option<(f64, f64)> {
    let [a, b, c] = corners.map(|corner| corner.map(f64::from));
    let scale = [a, b, c, origin].iter().flatten().fold(0.0f64, |s, x| s.max(x.abs()));
    let normal = cross(sub(b, a), sub(c, a));
    let area = dot(normal, normal).sqrt();
    let incidence = dot(normal, direction) / area;
    // In the plane: where the hit is along the ray is a matter of rounding.
    if area == 0.0 || incidence.abs() < 1e-4 {
        return None;
    }
    let t = dot(normal, sub(a, origin)) / dot(normal, direction);
    let moved = (ROUNDING * scale / incidence.abs()).max(1e-5 * t);
    let p = [0, 1, 2].map(|k| origin[k] + t * direction[k]);
    let near_edge = [[a, b], [b, c], [c, a]].iter().any(|&[from, to]| {
        let edge = sub(to, from);
        // Twice the area between the edge and the hit.
        let side = dot(cross(edge, sub(p, from)), normal) / area;
        side / area < EDGE || side / dot(edge, edge).sqrt() < moved
    });
    (!near_edge).then_some((t, moved))
}

/// The same of a sphere: its rim is where the ray touches it. A ray hits it twice, here near `at`.
fn on_sphere([x, y, z, radius]: [f32; 4], (origin, direction): Ray, at: f64) -> Option<(f64, f64)> {
    let (center, radius) = ([x, y, z].map(f64::from), f64::from(radius));
    let scale = [center, origin].iter().flatten().fold(radius, |s, x| s.max(x.abs()));
    let from = sub(origin, center);
    let length2 = dot(direction, direction);
    let middle = -dot(from, direction) / length2;
    let closest = [0, 1, 2].map(|k| from[k] + middle * direction[k]);
    let distance = dot(closest, closest).sqrt();
    if radius - distance <= ROUNDING * scale {
        return None;
    }
    let half = ((radius * radius - distance * distance) / length2).sqrt();
    let t = if (middle - half - at).abs() < (middle + half - at).abs() { middle - half } else { middle + half };
    let incidence = half * length2.sqrt() / radius;
    Some((t, (ROUNDING * scale / incidence).max(1e-5 * t)))
}

fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
