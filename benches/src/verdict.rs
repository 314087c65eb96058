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
const EDGE: f64 = 1e-3;
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
                [true, false] => verdict.judge(triangles, rays, i, blockers[0](i), 1),
                [false, true] => verdict.judge(triangles, rays, i, blockers[1](i), 0),
                _ => {}
            }
            continue;
        }
        let (a, b) = ((first.primitive[i], first.t[i]), (second.primitive[i], second.t[i]));
        match hit {
            [false, false] => {}
            [true, false] => verdict.judge(triangles, rays, i, a, 1),
            [false, true] => verdict.judge(triangles, rays, i, b, 0),
            [true, true] if (a.1 - b.1).abs() <= SAME * a.1.abs() => verdict.ties += usize::from(a.0 != b.0),
            [true, true] if a.1 < b.1 => verdict.judge(triangles, rays, i, a, 1),
            [true, true] => verdict.judge(triangles, rays, i, b, 0),
        }
    }
    verdict
}

impl Verdict {
    /// Ray `i` hits `(triangle, t)`, but peer `loser` did not find it.
    fn judge(&mut self, triangles: &Triangles, rays: &RaySet, i: usize, (triangle, t): (u32, f32), loser: usize) {
        if triangle != NOTHING && !in_band(triangles, rays, i, triangle) {
            if self.examples.len() < 8 {
                let (origin, direction) = rays.ray(i);
                self.examples.push(format!(
                    "ray {i} ({origin:?} {direction:?} to {}) hits triangle {triangle} at {t}; peer {loser} did not",
                    rays.t_max[i]
                ));
            }
            *(if loser == 0 { &mut self.lost_by_first } else { &mut self.lost_by_second }) += 1;
        } else {
            self.band += 1;
        }
    }
}

/// Is the exact hit near an edge of the triangle or near an end of the ray, or does the ray graze the plane?
fn in_band(triangles: &Triangles, rays: &RaySet, i: usize, triangle: u32) -> bool {
    let (origin, direction) = rays.ray(i);
    let (origin, direction) = (origin.map(f64::from), direction.map(f64::from));
    let [a, b, c] = triangles.corners(triangle as usize).map(|corner| corner.map(f64::from));
    let scale = [a, b, c, origin].iter().flatten().fold(0.0f64, |s, x| s.max(x.abs()));
    let normal = cross(sub(b, a), sub(c, a));
    let area = dot(normal, normal).sqrt();
    let incidence = dot(normal, direction) / area;
    // In the plane: the position of the hit along the ray is a matter of rounding.
    if area == 0.0 || incidence.abs() < 1e-4 {
        return true;
    }
    let t = dot(normal, sub(a, origin)) / dot(normal, direction);
    let moved = ROUNDING * scale / incidence.abs();
    if t <= moved || (t - f64::from(rays.t_max[i])).abs() <= moved.max(1e-5 * t) {
        return true;
    }
    let p = [0, 1, 2].map(|k| origin[k] + t * direction[k]);
    [[a, b], [b, c], [c, a]].iter().any(|&[from, to]| {
        let edge = sub(to, from);
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
