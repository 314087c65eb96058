//! Whether two peers found the same, and if not, who is right.
//!
//! Rays that pass a triangle's edge or a surface's rim, or end at a surface, may go either way by rounding. So where two
//! peers differ, the exact test (in `f64`) of each one's triangle says how far from its edges and from the ray's ends the
//! hit is: near them, the ray is in the *band* and either answer stands; well inside, somebody lost a hit.

use crate::rays::{Found, NOTHING, RaySet};
use crate::scenes::Triangles;

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
    /// Other triangle, same distance: shared edges and surfaces that lie in one another.
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

/// The nearest triangle of a ray that has been found to be blocked.
pub type Blocker<'a> = &'a dyn Fn(usize) -> (u32, f32);

/// Compares closest hits, or blocked rays; for these, `blockers` names what blocks a ray according to each peer.
pub fn compare(
    triangles: &Triangles,
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
                [true, false] => verdict.judge(triangles, rays, i, blockers[0](i), None, 1),
                [false, true] => verdict.judge(triangles, rays, i, blockers[1](i), None, 0),
                _ => {}
            }
            continue;
        }
        let (a, b) = ((first.primitive[i], first.t[i]), (second.primitive[i], second.t[i]));
        match hit {
            [false, false] => {}
            [true, false] => verdict.judge(triangles, rays, i, a, None, 1),
            [false, true] => verdict.judge(triangles, rays, i, b, None, 0),
            [true, true] if (a.1 - b.1).abs() <= SAME * a.1.abs() => verdict.ties += usize::from(a.0 != b.0),
            [true, true] if a.1 < b.1 => verdict.judge(triangles, rays, i, a, Some(b.1), 1),
            [true, true] => verdict.judge(triangles, rays, i, b, Some(a.1), 0),
        }
    }
    verdict
}

impl Verdict {
    /// Ray `i` hits `(triangle, t)`, but peer `loser` did not find it; it found something at `instead`, or nothing.
    fn judge(
        &mut self,
        triangles: &Triangles,
        rays: &RaySet,
        i: usize,
        (triangle, t): (u32, f32),
        instead: Option<f32>,
        loser: usize,
    ) {
        if triangle == NOTHING || in_band(triangles, rays, i, triangle, instead) {
            self.band += 1;
            return;
        }
        *(if loser == 0 { &mut self.lost_by_first } else { &mut self.lost_by_second }) += 1;
        if self.examples.len() < 4 {
            let (origin, direction) = rays.ray(i);
            let (far, peer) = (rays.t_max[i], ["the first", "the second"][loser]);
            self.examples.push(format!(
                "ray {i}, {origin:?} + t {direction:?} to {far}, hits triangle {triangle} at {t}; {peer} found {instead:?}"
            ));
        }
    }
}

/// Is the exact hit near an edge of the triangle, near an end of the ray, near the hit that was taken instead, or does
/// the ray lie in the plane?
fn in_band(triangles: &Triangles, rays: &RaySet, i: usize, triangle: u32, instead: Option<f32>) -> bool {
    let (origin, direction) = rays.ray(i);
    let (origin, direction) = (origin.map(f64::from), direction.map(f64::from));
    let [a, b, c] = triangles.corners(triangle as usize).map(|corner| corner.map(f64::from));
    let scale = [a, b, c, origin].iter().flatten().fold(0.0f64, |s, x| s.max(x.abs()));
    let normal = cross(sub(b, a), sub(c, a));
    let area = dot(normal, normal).sqrt();
    let incidence = dot(normal, direction) / area;
    // In the plane: where the hit is along the ray is a matter of rounding.
    if area == 0.0 || incidence.abs() < 1e-4 {
        return true;
    }
    let t = dot(normal, sub(a, origin)) / dot(normal, direction);
    let moved = (ROUNDING * scale / incidence.abs()).max(1e-5 * t);
    let near = |other: f32| (t - f64::from(other)).abs() <= moved;
    if t <= moved || near(rays.t_max[i]) || instead.is_some_and(near) {
        return true;
    }
    let p = [0, 1, 2].map(|k| origin[k] + t * direction[k]);
    [[a, b], [b, c], [c, a]].iter().any(|&[from, to]| {
        let edge = sub(to, from);
        // Twice the area between the edge and the hit.
        let side = dot(cross(edge, sub(p, from)), normal) / area;
        side / area < EDGE || side / dot(edge, edge).sqrt() < moved
    })
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
