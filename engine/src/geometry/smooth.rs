//! Normals for the corners of meshes that have none: smooth across edges where triangles meet at a small angle, with a crease where they
//! meet at a large one.
//!
//! The normal of a corner is the sum of the normals of triangles that share it, each weighted by its angle there and by its area: the angle
//! so that it does not matter how flat sides are cut into triangles (Thuermer and Wuethrich 1998), the area so that large flat sides stay
//! flat, and small rounded edges between them bend to their directions; by angles alone a machine's plates shine in stars around their
//! bolts. Triangles whose normal is further than the crease angle from that of the corner's own do not count. What shares a corner is told
//! by positions, not by indices: files often repeat them.
//!
//! Most vertices are smooth or flat all round, which one sum decides for all of their corners; at the others each corner looks at all
//! others, but at no more than [`MOST_NEIGHBOURS`] of them.

use glam::Vec3;

use super::fans::Fans;
use super::triangle::normal_f64;
use super::{Mesh, NO_INDEX};
use crate::math::{angle, normalize, normalize_or};

/// The usual angle between normals, in degrees, from which on an edge is a crease.
pub const CREASE_ANGLE: f32 = 30.0;

/// Directions that differ by less are the same, in radians: so far may rounded corners turn the triangles of a flat wall, and no picture
/// shows it.
const SAME: f32 = 1e-4;

/// Where creases and more triangles than this meet, as at the tip of a cone, each corner looks at so many of them, evenly spaced: time
/// must not go with the square of how many a file lets share a corner.
const MOST_NEIGHBOURS: usize = 128;

impl Mesh {
    /// Gives corners normals if no triangle has any: smooth where neighbours meet at less than `degrees`. Triangles that would look the
    /// same without stay without; of a mesh that is flat or has creases only, that is all of them. 0 smooths nothing. Returns how many
    /// normals were made.
    pub fn smooth(&mut self, degrees: f32) -> usize {
        let has_normals = self.triangle_normals.iter().any(|normals| *normals != [NO_INDEX; 3]);
        // Corners have numbers of 32 bits.
        if degrees.is_nan() || degrees <= 0.0 || has_normals || self.triangles.len() >= (NO_INDEX / 3) as usize {
            return 0;
        }
        let triangles: Vec<Facet> = (0..self.triangles.len()).map(|i| Facet::of(self, i)).collect();
        let fans = Fans::of(self, |i| triangles[i].has_normal());
        let mut smoothed = Smoothed::new(degrees, triangles.len());
        let mut fan = Vec::new();
        for corners in fans.iter() {
            fan.clear();
            fan.extend(corners.iter().map(|&corner| {
                let Facet { normal, weights } = triangles[corner as usize / 3];
                Member { normal, weight: weights[corner as usize % 3], corner }
            }));
            smoothed.add(&fan);
        }
        drop(fans);
        self.triangle_normals = smoothed.finish(&triangles);
        self.normals = smoothed.normals;
        self.normals.len()
    }
}

/// A triangle: its unit normal, zero if it has none, and the weights of that at its corners.
#[derive(Clone, Copy)]
struct Facet {
    normal: Vec3,
    weights: [f32; 3],
}

impl Facet {
    fn of(mesh: &Mesh, triangle: usize) -> Self {
        const NONE: Facet = Facet { normal: Vec3::ZERO, weights: [0.0; 3] };
        let Some(corners) = mesh.corners(triangle) else { return NONE };
        // In f64, so that neither the size of a triangle nor how thin it is matters.
        let normal = normal_f64(corners);
        let length = dot(normal, normal).sqrt();
        if !(length > f64::MIN_POSITIVE && length.is_finite()) {
            return NONE;
        }
        let [a, b, c] = corners.map(|corner| corner.to_array().map(f64::from));
        let edge = |from: [f64; 3], to: [f64; 3]| [0, 1, 2].map(|k| to[k] - from[k]);
        let (ab, bc, ca) = (edge(a, b), edge(b, c), edge(c, a));
        // The sine of each angle times its sides is twice the area.
        let first = angle(length, -dot(ab, ca));
        let second = angle(length, -dot(bc, ab));
        let third = (std::f32::consts::PI - first - second).max(0.0);
        let scale = 1.0 / length;
        let [x, y, z] = normal.map(|x| (x * scale) as f32);
        // Sums of so many as there can be stay within the range of f32.
        let area = length.clamp(1e-24, 1e24) as f32;
        Self { normal: Vec3::new(x, y, z), weights: [first, second, third].map(|angle| angle * area) }
    }

    fn has_normal(&self) -> bool {
        self.normal != Vec3::ZERO
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// A corner among those at one point.
#[derive(Clone, Copy)]
struct Member {
    normal: Vec3,
    weight: f32,
    corner: u32,
}

impl Member {
    fn weighted(&self) -> Vec3 {
        self.normal * self.weight
    }
}

/// A vector at length 1, however short or long it is; `otherwise` if it is zero.
fn direction(v: Vec3, otherwise: Vec3) -> Vec3 {
    let usual = (1e-20..1e20).contains(&v.dot(v));
    if usual { normalize(v) } else { normalize_or(v.to_array().map(f64::from), otherwise) }
}

/// The normals that were made.
struct Smoothed {
    /// Normals this near count: the cosine of the crease angle, and of half of it.
    near: f32,
    half: f32,
    normals: Vec<[f32; 3]>,
    /// The normal of each corner, where one was made.
    of_corners: Vec<[u32; 3]>,
    /// Does any corner of the triangle have another normal than itself?
    curved: Vec<bool>,
}

impl Smoothed {
    fn new(degrees: f32, triangles: usize) -> Self {
        // A little more, so that a prism whose sides meet at that very angle is not smooth here and not there.
        let crease = (degrees.min(180.0).to_radians() + SAME).min(std::f32::consts::PI);
        Self {
            near: libm::cosf(crease),
            half: libm::cosf(0.5 * crease),
            normals: Vec::new(),
            of_corners: vec![[NO_INDEX; 3]; triangles],
            curved: vec![false; triangles],
        }
    }

    /// Adds the corners at one point.
    fn add(&mut self, fan: &[Member]) {
        let mean = direction(fan.iter().fold(Vec3::ZERO, |sum, member| sum + member.weighted()), Vec3::ZERO);
        // Then no two are further apart than twice the half.
        if mean != Vec3::ZERO && fan.iter().all(|member| member.normal.dot(mean) >= self.half) {
            if fan.iter().any(|member| differ(member.normal, mean)) {
                let index = self.push(mean);
                fan.iter().for_each(|member| self.set(member, mean, index));
            }
            return;
        }
        let step = fan.len().div_ceil(MOST_NEIGHBOURS);
        let first = self.normals.len();
        for (i, own) in fan.iter().enumerate() {
            let looked_at = fan.iter().step_by(step).filter(|other| other.normal.dot(own.normal) >= self.near);
            let mut sum = looked_at.fold(Vec3::ZERO, |sum, other| sum + other.weighted());
            if i % step != 0 {
                sum += own.weighted();
            }
            let normal = direction(sum, own.normal);
            if !differ(normal, own.normal) {
                continue;
            }
            // Corners that see the same neighbours have the same sum.
            let recent = first.max(self.normals.len().saturating_sub(MOST_NEIGHBOURS));
            let known = self.normals[recent..].iter().position(|known| *known == normal.to_array());
            let index = known.map_or_else(|| self.push(normal), |at| (recent + at) as u32);
            self.set(own, normal, index);
        }
    }

    fn push(&mut self, normal: Vec3) -> u32 {
        self.normals.push(normal.to_array());
        (self.normals.len() - 1) as u32
    }

    fn set(&mut self, member: &Member, normal: Vec3, index: u32) {
        let (triangle, corner) = (member.corner as usize / 3, member.corner as usize % 3);
        self.of_corners[triangle][corner] = index;
        self.curved[triangle] |= differ(normal, member.normal);
    }

    /// The normals of the corners of all triangles: of those that are curved all three, of the others none; nothing if none is.
    fn finish(&mut self, triangles: &[Facet]) -> Vec<[u32; 3]> {
        if !self.curved.contains(&true) {
            self.normals.clear();
            return Vec::new();
        }
        let mut of_corners = std::mem::take(&mut self.of_corners);
        for (i, corners) in of_corners.iter_mut().enumerate() {
            if !self.curved[i] {
                *corners = [NO_INDEX; 3];
            } else if corners.contains(&NO_INDEX) {
                let own = self.push(triangles[i].normal);
                corners.iter_mut().filter(|index| **index == NO_INDEX).for_each(|index| *index = own);
            }
        }
        of_corners
    }
}

/// Do unit vectors differ by more than rounding?
fn differ(a: Vec3, b: Vec3) -> bool {
    a.distance_squared(b) > SAME * SAME
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The normal of each corner that has one.
    fn normals(mesh: &Mesh) -> Vec<[Option<Vec3>; 3]> {
        let of = |index: u32| mesh.normals.get(index as usize).map(|&normal| Vec3::from(normal));
        mesh.triangle_normals.iter().map(|corners| corners.map(of)).collect()
    }

    fn mesh(positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>) -> Mesh {
        Mesh { positions, triangles, ..Mesh::default() }
    }

    /// The same with corners of its own for each triangle.
    fn torn(mesh: &Mesh) -> Mesh {
        let positions = mesh.triangles.as_flattened().iter().map(|&corner| mesh.positions[corner as usize]).collect();
        let triangles = (0..mesh.triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        Mesh { positions, triangles, ..Mesh::default() }
    }

    /// Of side 2 about the origin.
    fn cube() -> Mesh {
        let corner = |i: u32| [0, 1, 2].map(|k| if i >> k & 1 == 0 { -1.0 } else { 1.0 });
        let faces = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        mesh((0..8).map(corner).collect(), faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect())
    }

    /// With a tip below and one above, and `sides` around.
    fn spindle(sides: u32, radius: impl Fn(u32) -> f32) -> Mesh {
        let around = |i: u32| {
            let turn = std::f32::consts::TAU * i as f32 / sides as f32;
            [radius(i) * turn.cos(), radius(i) * turn.sin(), 0.0]
        };
        let positions = [[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]].into_iter().chain((0..sides).map(around)).collect();
        let side = |i: u32| [2 + i, 2 + (i + 1) % sides];
        let halves = (0..sides).map(side).flat_map(|[a, b]| [[0, b, a], [1, a, b]]);
        mesh(positions, halves.collect())
    }

    /// A sphere of `2 n` times `n` patches.
    fn sphere(n: u32) -> Mesh {
        let at = |i: u32| {
            let [turn, height] = [i % (2 * n), i / (2 * n)].map(|part| std::f32::consts::PI * part as f32 / n as f32);
            // All points of a pole are one.
            let radius = if i / (2 * n) == n { 0.0 } else { height.sin() };
            [radius * turn.cos(), radius * turn.sin(), height.cos()]
        };
        let patch = |i: u32| {
            let (row, next) = (i / (2 * n) * 2 * n, (i + 1) % (2 * n));
            let (a, b) = (i, row + next);
            [[a, a + 2 * n, b], [b, a + 2 * n, b + 2 * n]]
        };
        mesh((0..2 * n * (n + 1)).map(at).collect(), (0..2 * n * n).flat_map(patch).collect())
    }

    #[test]
    fn what_has_creases_only_stays_without_normals() {
        let mut cube = cube();
        assert_eq!(cube.smooth(30.0), 0);
        assert!(cube.normals.is_empty() && cube.triangle_normals.is_empty());
        assert_eq!(cube.smooth(0.0), 0);
        // Neither does what was given normals get others.
        let mut given =
            Mesh { normals: vec![[1.0, 0.0, 0.0]], triangle_normals: vec![[NO_INDEX; 3]; 12], ..cube.clone() };
        given.triangle_normals[5] = [0; 3];
        assert_eq!((given.smooth(180.0), given.normals.len()), (0, 1));
    }

    #[test]
    fn how_flat_sides_are_cut_does_not_matter() {
        for mut cube in [cube(), torn(&cube())] {
            assert_eq!(cube.smooth(100.0), 8);
            for (corners, normals) in normals(&cube).into_iter().enumerate() {
                let corners = cube.corners(corners).unwrap();
                for (corner, normal) in corners.into_iter().zip(normals) {
                    assert!((normal.unwrap() - corner.normalize()).length() < 1e-4, "{normal:?} at {corner}");
                }
            }
        }
    }

    #[test]
    fn round_things_are_round() {
        let (mut whole, mut torn) = (sphere(12), torn(&sphere(12)));
        assert!(whole.smooth(30.0) > 0);
        assert_eq!(torn.smooth(30.0), whole.normals.len());
        assert_eq!(normals(&torn), normals(&whole));
        let mut corners = 0;
        for (i, normals) in normals(&whole).into_iter().enumerate() {
            for (corner, normal) in whole.corners(i).unwrap().into_iter().zip(normals) {
                // Those at the poles have no area.
                let Some(normal) = normal else { continue };
                assert!(corner.dot(normal).abs() > 0.999, "{normal} at {corner}");
                corners += 1;
            }
        }
        assert_eq!(corners, 3 * (whole.triangles.len() - 2 * 24));
    }

    #[test]
    fn edges_at_the_crease_angle_are_smooth_all_round_and_sharper_ones_are_not() {
        // Neighbours of a prism of twelve sides meet at 30 degrees, but for rounding; its ends at 90.
        let around = |i: u32| (std::f32::consts::PI * (i / 2 % 12) as f32 / 6.0 + 0.1).sin_cos();
        let positions: Vec<_> = (0..24).map(|i| [around(i).0 * 7.7, around(i).1 * 7.7, (i % 2) as f32]).collect();
        let sides = (0..12).map(|i| [2 * i, 2 * i + 1, (2 * i + 2) % 24, (2 * i + 3) % 24]);
        let sides = sides.flat_map(|[a, b, c, d]| [[a, b, c], [c, b, d]]);
        let end = (1..11).map(|i| [0, 2 * i, 2 * i + 2]);
        let mut prism = mesh(positions, sides.chain(end).collect());
        assert_eq!(prism.smooth(30.0), 24);
        let normals = normals(&prism);
        for (i, normals) in normals[..24].iter().enumerate() {
            for (corner, normal) in prism.corners(i).unwrap().into_iter().zip(normals) {
                let out = Vec3::new(corner.x, corner.y, 0.0).normalize();
                assert!(normal.unwrap().dot(out).abs() > 0.999_9, "{normal:?} at {corner}");
            }
        }
        assert_eq!(normals[24..], [[None; 3]; 10]);
        prism.triangle_normals.clear();
        assert_eq!(prism.smooth(29.0), 0);
    }

    #[test]
    fn a_triangle_with_a_smooth_corner_has_normals_at_all() {
        // Two triangles that meet at 20 degrees, and a third that meets the second at 90.
        let (sine, cosine) = 20_f32.to_radians().sin_cos();
        let positions = vec![[0.0; 3], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [cosine, 0.0, sine], [cosine, 0.0, -9.0]];
        let mut bent = mesh(positions, vec![[0, 1, 2], [0, 3, 1], [4, 1, 3]]);
        assert_eq!(bent.smooth(30.0), 4);
        let [first, second, third] = normals(&bent)[..] else { panic!() };
        assert_eq!([first[0], first[1]], [second[0], second[2]]);
        assert!(first[2].unwrap().distance(Vec3::Z) < 1e-6);
        assert_eq!(third, [None; 3]);
    }

    #[test]
    fn large_sides_stay_flat_beside_narrow_ones() {
        // A large square, and a strip that bends away from its edge.
        let positions = vec![
            [0.0; 3],
            [0.0, 9.0, 0.0],
            [-9.0, 9.0, 0.0],
            [-9.0, 0.0, 0.0],
            [0.01, 0.0, -0.004],
            [0.01, 9.0, -0.004],
        ];
        let mut edge = mesh(positions, vec![[0, 1, 2], [0, 2, 3], [0, 4, 5], [0, 5, 1]]);
        assert!(edge.smooth(30.0) > 0);
        let at_edge = normals(&edge)[2][0].unwrap();
        assert!(at_edge.distance(Vec3::Z) < 0.002, "{at_edge}");
    }

    #[test]
    fn what_has_no_normal_harms_nobody() {
        let mut sphere = sphere(8);
        let sound = sphere.triangles.len();
        let far = sphere.positions.len() as u32;
        sphere.positions.extend([[f32::NAN, 0.0, 0.0], [f32::INFINITY, 1.0, 0.0], [f32::MAX; 3], [-0.0, 0.0, 1.0]]);
        let mut alone = sphere.clone();
        alone.smooth(30.0);
        let others =
            [[20, 21, far], [20, far + 1, 21], [20, 20, 21], [20, 21, far + 99], [20, NO_INDEX, 21], [21, 21, 21]];
        sphere.triangles.extend(others);
        sphere.smooth(30.0);
        let all = normals(&sphere);
        assert_eq!((&all[..sound], &all[sound..]), (&normals(&alone)[..], &[[None; 3]; 6][..]));
    }

    #[test]
    fn many_triangles_at_one_point_take_no_longer_than_elsewhere() {
        // All others are looked at by each: half a minute and more.
        let start = std::time::Instant::now();
        for radius in [(|_| 1.0) as fn(u32) -> f32, |i| 1.0 + (i % 2) as f32] {
            let mut spindle = spindle(300_000, radius);
            let made = spindle.smooth(30.0);
            assert!(made > 0 && made <= 3 * spindle.triangles.len(), "{made}");
            let all = normals(&spindle);
            assert!(all.iter().flatten().flatten().all(|normal| (normal.length() - 1.0).abs() < 1e-5));
        }
        assert!(start.elapsed().as_secs() < 15, "{:?}", start.elapsed());
    }

    proptest! {
        #[test]
        fn any_mesh_gets_unit_normals_or_none(
            positions in prop::collection::vec(prop::array::uniform3(prop_oneof![
                (-2..3).prop_map(|x| x as f32), prop::num::f32::ANY, -1.0_f32..1.0, Just(1e-40), Just(3e38), Just(-0.0),
            ]), 0..12),
            triangles in prop::collection::vec(prop::array::uniform3(0..14_u32), 0..40),
            degrees in 0.0_f32..=180.0,
        ) {
            let mut once = mesh(positions, triangles);
            let mut again = once.clone();
            prop_assert_eq!(once.smooth(degrees), again.smooth(degrees));
            prop_assert_eq!((&once.normals, &once.triangle_normals), (&again.normals, &again.triangle_normals));
            prop_assert!(once.triangle_normals.is_empty() || once.triangle_normals.len() == once.triangles.len());
            for corners in normals(&once) {
                let found: Vec<Vec3> = corners.into_iter().flatten().collect();
                prop_assert!(found.is_empty() || found.len() == 3);
                prop_assert!(found.iter().all(|normal| (normal.length() - 1.0).abs() < 1e-5), "{:?}", found);
            }
        }
    }
}
