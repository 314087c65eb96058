//! A triangle from its corners: normal, barycentric coordinates.
//!
//! Everything is computed for one ray at a time from that ray alone, in f32, unfused: the same at every packet width and
//! level.

use glam::{Vec3, Vec3Swizzles};
use mobula_core::simd::{F32Lanes, MaskLanes, Task, Token};

use crate::lanes::{add, cross, dot, greatest, load3, scale, store3, sub};
use crate::math::{normalize, normalize_or};
use crate::packet::{Hits, set_vec3};

/// The squares of lengths that are far from where squares lose bits to under- or overflow.
const SHORTEST: f32 = 1e-24;
const LONGEST: f32 = 1e30;

/// Unit normal of a triangle that has an area.
#[inline(always)]
pub(super) fn normal(corners: [Vec3; 3]) -> Vec3 {
    let [a, b, c] = corners;
    let n = (b - a).cross(c - a);
    let length_squared = n.dot(n);
    if length_squared > SHORTEST && length_squared < LONGEST { normalize(n) } else { tiny_normal(corners) }
}

#[cold]
fn tiny_normal(corners: [Vec3; 3]) -> Vec3 {
    normalize_or(normal_f64(corners), Vec3::Y)
}

/// Finds for each of some primitives the unit normal of its triangle, as [`normal`] does, and the greatest coordinate of its longest edge;
/// up and 0 where it has no corners.
pub(super) struct Planes<'a, F> {
    pub(super) primitives: &'a [u32],
    pub(super) corners: F,
    pub(super) normals: [&'a mut [f32]; 3],
    pub(super) extents: &'a mut [f32],
}

/// Triangles that are gathered at once: a multiple of the lanes of every level.
const GATHERED: usize = 16;

/// Three vectors of each of some triangles: by corner, axis and triangle.
type Gathered = [[[f32; GATHERED]; 3]; 3];

/// Gathers what `of` says of each of up to [`GATHERED`] triangles, nothing of none.
#[inline(always)]
fn gather(out: &mut Gathered, triangles: &[u32], of: impl Fn(u32) -> Option<[Vec3; 3]>) {
    // Rays near the eye often meet one triangle.
    if triangles.iter().fold(true, |all, &k| all & (k == triangles[0])) {
        let all = of(triangles[0]).unwrap_or_default();
        for corner in 0..3 {
            (0..3).for_each(|axis| out[corner][axis] = [all[corner][axis]; GATHERED]);
        }
        return;
    }
    for (i, &k) in triangles.iter().enumerate() {
        let triangle = of(k).unwrap_or_default();
        for corner in 0..3 {
            (0..3).for_each(|axis| out[corner][axis][i] = triangle[corner][axis]);
        }
    }
}

impl<F: Fn(u32) -> Option<[Vec3; 3]>> Task for Planes<'_, F> {
    type Output = ();

    #[inline(always)]
    fn run<T: Token>(self, token: T) {
        let Self { primitives, corners, mut normals, extents } = self;
        let one = token.splat(1.0);
        let mut gathered = Gathered::default();
        for (start, some) in (0..).step_by(GATHERED).zip(primitives.chunks(GATHERED)) {
            gather(&mut gathered, some, &corners);
            for at in (0..some.len()).step_by(T::LANES) {
                let a = load3(token, &gathered[0], at);
                let b = load3(token, &gathered[1], at);
                let c = load3(token, &gathered[2], at);
                let (u, v) = (sub(b, a), sub(c, a));
                greatest(u).max(greatest(v)).max(greatest(sub(c, b))).store(extents, start + at);
                let n = cross(u, v);
                let square = dot(n, n);
                store3(scale(n, one / square.sqrt()), &mut normals, start + at);
                let usable = square.gt(token.splat(SHORTEST)) & square.lt(token.splat(LONGEST));
                let mut tiny = token.first(some.len() - at).and_not(usable).bits();
                while tiny != 0 {
                    let i = at + tiny.trailing_zeros() as usize;
                    set_vec3(&mut normals, start + i, corners(some[i]).map_or(Vec3::Y, normal));
                    tiny &= tiny - 1;
                }
            }
        }
    }
}

/// Finds for each of some hits the unit normal that the normals of its triangle's corners give there. Where these are missing, or their mean
/// is next to nothing, that of the triangle.
pub(super) struct Interpolated<'a, C, N> {
    pub(super) hits: &'a Hits<'a>,
    pub(super) corners: C,
    pub(super) corner_normals: N,
    pub(super) out: [&'a mut [f32]; 3],
}

/// The squares of lengths of means that have a direction.
const NOTHING: f32 = 1e-12;
const TOO_LONG: f32 = 1e12;

impl<C: Fn(u32) -> Option<[Vec3; 3]>, N: Fn(u32) -> Option<[Vec3; 3]>> Task for Interpolated<'_, C, N> {
    type Output = ();

    #[inline(always)]
    fn run<T: Token>(self, token: T) {
        let Self { hits, corners, corner_normals, mut out } = self;
        let (zero, one) = (token.splat(0.0), token.splat(1.0));
        let (mut positions, mut normals) = (Gathered::default(), Gathered::default());
        for (start, some) in (0..).step_by(GATHERED).zip(hits.primitives.chunks(GATHERED)) {
            gather(&mut positions, some, &corners);
            // No normals are none of any length.
            gather(&mut normals, some, &corner_normals);
            for at in (0..some.len()).step_by(T::LANES) {
                let origin = load3(token, &hits.origins, start + at);
                let direction = load3(token, &hits.directions, start + at);
                let a = sub(load3(token, &positions[0], at), origin);
                let b = sub(load3(token, &positions[1], at), origin);
                let c = sub(load3(token, &positions[2], at), origin);
                // As [`barycentric`] has them.
                let u = volume(direction, b, c);
                let v = volume(direction, c, a);
                let sum = u + v + volume(direction, a, b);
                let by = one / sum;
                let u = (u * by).max(zero).min(one);
                let v = (v * by).max(zero).min(one).min(one - u);
                let n = add(
                    add(scale(load3(token, &normals[0], at), u), scale(load3(token, &normals[1], at), v)),
                    scale(load3(token, &normals[2], at), one - u - v),
                );
                let square = dot(n, n);
                let usable = by.abs().lt(token.splat(f32::INFINITY))
                    & sum.abs().lt(token.splat(f32::INFINITY))
                    & square.gt(token.splat(NOTHING))
                    & square.lt(token.splat(TOO_LONG));
                store3(scale(n, one / square.sqrt()), &mut out, start + at);
                let mut rest = token.first(some.len() - at).and_not(usable).bits();
                while rest != 0 {
                    let i = at + rest.trailing_zeros() as usize;
                    let triangle = corners(some[i]).map(|corners| (corners, corner_normals(some[i])));
                    set_vec3(&mut out, start + i, triangle.map_or(Vec3::Y, |its| one_normal(its, hits.ray(start + i))));
                    rest &= rest - 1;
                }
            }
        }
    }
}

/// The volume that a direction and an edge span, twice, with its sign.
#[inline(always)]
fn volume<F: F32Lanes>(direction: [F; 3], p: [F; 3], q: [F; 3]) -> F {
    dot(direction, cross(sub(q, p), add(q, p)))
}

/// The normal at one hit of a triangle, of which the usual way does not know it.
#[cold]
fn one_normal((corners, normals): ([Vec3; 3], Option<[Vec3; 3]>), ray: (Vec3, Vec3)) -> Vec3 {
    let Some([a, b, c]) = normals else { return normal(corners) };
    let [u, v, w] = barycentric(corners, ray);
    let n = a * u + b * v + c * w;
    let square = n.dot(n);
    if square > NOTHING && square < TOO_LONG { normalize(n) } else { normal(corners) }
}

/// Barycentric coordinates of where a ray hits a triangle, each in 0..=1, of sum 1 up to rounding. As ratios of the
/// volumes that the ray and each edge span (Pluecker coordinates): as the edges are taken about their middles, no
/// precision is lost where the triangle is small and far away.
#[inline(always)]
pub(super) fn barycentric([a, b, c]: [Vec3; 3], (origin, direction): (Vec3, Vec3)) -> [f32; 3] {
    let (a, b, c) = (a - origin, b - origin, c - origin);
    let volume = |p: Vec3, q: Vec3| direction.dot((q - p).cross(q + p));
    let (u, v, w) = (volume(b, c), volume(c, a), volume(a, b));
    let sum = u + v + w;
    let scale = 1.0 / sum;
    if sum == 0.0 || !scale.is_finite() {
        return [1.0 / 3.0; 3];
    }
    // A ray on an edge may be on the wrong side of it by rounding.
    let (u, v) = ((u * scale).clamp(0.0, 1.0), (v * scale).clamp(0.0, 1.0));
    let v = v.min(1.0 - u);
    [u, v, 1.0 - u - v]
}

/// The distance from where a ray meets a triangle to its nearest edge, and the radius of its inscribed circle.
pub(super) fn to_edges(corners: [Vec3; 3], ray: (Vec3, Vec3)) -> (f32, f32) {
    let [a, b, c] = corners;
    let [bc, ca, ab] = [c - b, a - c, b - a].map(|edge| edge.length());
    // Twice the area over an edge is the height above it.
    let area2 = (b - a).cross(c - a).length();
    let [u, v, w] = barycentric(corners, ray);
    let above = |part: f32, edge: f32| if edge > 0.0 { part * area2 / edge } else { 0.0 };
    let perimeter = bc + ca + ab;
    let radius = if perimeter > 0.0 { area2 / perimeter } else { 0.0 };
    (above(u, bc).min(above(v, ca)).min(above(w, ab)), radius)
}

/// Has a triangle surely an area, and finite corners? A quick test of all but the thinnest, tiniest and largest, of which
/// [`normal_f64`] must tell.
#[inline(always)]
pub(super) fn surely_has_area([a, b, c]: [Vec3; 3]) -> bool {
    let (u, v) = (b - a, c - a);
    let (p, q) = (u.yzx() * v.zxy(), u.zxy() * v.yzx());
    // Four roundings of 2^-24 each, and what underflows. What is not finite leaves some axis of the normal so, too.
    let (normal, error) = (p - q, (p.abs() + q.abs()) * (1.0 / (1 << 20) as f32) + 1e-30);
    normal.is_finite() && normal.abs().cmpgt(error).any()
}

/// Normal of a triangle, of twice its area. In f64 neither differences nor products of f32 overflow or underflow.
pub(super) fn normal_f64([a, b, c]: [Vec3; 3]) -> [f64; 3] {
    let edge = |p: Vec3| [0, 1, 2].map(|i| f64::from(p[i]) - f64::from(a[i]));
    let (u, v) = (edge(b), edge(c));
    [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn what_surely_has_an_area_has_one(
            corners in prop::array::uniform3(prop::array::uniform3(prop_oneof![
                prop::num::f32::ANY,
                -1.0_f32..1.0,
                (-4..4).prop_map(|x| x as f32),
                (-4..4).prop_map(|x| x as f32 * 0.1),
                Just(1e18_f32),
            ])),
            along in prop_oneof![Just(None), (-2.0_f32..2.0).prop_map(Some)],
        ) {
            let [a, b, c] = corners.map(Vec3::from);
            // Some on a line, but for rounding.
            let corners = [a, b, along.map_or(c, |along| a + (b - a) * along)];
            if surely_has_area(corners) {
                prop_assert!(corners.iter().all(|corner| corner.is_finite()) && normal_f64(corners) != [0.0; 3]);
            }
        }

        #[test]
        fn all_levels_interpolate_normals_as_for_one_ray(
            rows in prop::collection::vec(
                (
                    prop::array::uniform3(prop::array::uniform3(-1.0_f32..1.0)),
                    prop::option::of(prop::array::uniform3(prop::array::uniform3(prop_oneof![
                        -1.0_f32..1.0, Just(0.0), Just(1e20), Just(f32::NAN),
                    ]))),
                    prop::array::uniform2(prop::array::uniform3(prop_oneof![-2.0_f32..2.0, Just(0.0), Just(f32::INFINITY)])),
                ),
                1..40,
            ),
        ) {
            let column = |of: usize, axis: usize| rows.iter().map(|row| row.2[of][axis]).collect::<Vec<f32>>();
            let rays: [[Vec<f32>; 3]; 2] = [0, 1].map(|of| [0, 1, 2].map(|axis| column(of, axis)));
            let [origins, directions] = rays.each_ref().map(|ray| ray.each_ref().map(|column| &column[..]));
            let primitives: Vec<u32> = (0..rows.len() as u32).collect();
            let t = vec![1.0; rows.len()];
            let of = |k: u32| rows.get(k as usize);
            for token in mobula_core::simd::AnyToken::available() {
                let hits = Hits { token, origins, directions, t: &t, primitives: &primitives };
                let mut out: [Vec<f32>; 3] = std::array::from_fn(|_| vec![9.0; rows.len()]);
                let [x, y, z] = &mut out;
                token.run(Interpolated {
                    hits: &hits,
                    corners: |k| of(k).map(|row| row.0.map(Vec3::from)),
                    corner_normals: |k| of(k).and_then(|row| row.1.map(|normals| normals.map(Vec3::from))),
                    out: [x, y, z],
                });
                for (i, row) in rows.iter().enumerate() {
                    let its = (row.0.map(Vec3::from), row.1.map(|normals| normals.map(Vec3::from)));
                    let expected = one_normal(its, hits.ray(i)).to_array();
                    let found = [0, 1, 2].map(|axis| out[axis][i]);
                    // Not their bits: a zero may have either sign.
                    prop_assert_eq!(found, expected, "{}, row {}", token.level(), i);
                }
            }
        }

        #[test]
        fn barycentric_coordinates_find_the_point_again(
            corners in prop::array::uniform3(prop::array::uniform3(-1.0_f32..1.0)),
            weights in prop::array::uniform3(0.0_f32..1.0),
            far in 0.5_f32..100.0,
        ) {
            let corners = corners.map(Vec3::from);
            let [a, b, c] = corners;
            let area = (b - a).cross(c - a).length();
            prop_assume!(area > 0.1 && weights.iter().sum::<f32>() > 0.1);
            let sum: f32 = weights.iter().sum();
            let point = (a * weights[0] + b * weights[1] + c * weights[2]) / sum;
            let n = normal(corners);
            let origin = point + (n + Vec3::new(0.1, 0.2, -0.1)) * far;
            let [u, v, w] = barycentric(corners, (origin, (point - origin).normalize()));
            prop_assert!([u, v, w].iter().all(|x| (0.0..=1.0).contains(x)));
            prop_assert!((a * u + b * v + c * w - point).length() < 1e-5 * (1.0 + far) / area);
        }

        #[test]
        fn normals_have_length_1_at_any_size(
            corners in prop::array::uniform3(prop::array::uniform3(-1.0_f32..1.0)),
            scale in prop_oneof![Just(1e-30_f32), Just(1e-12), Just(1.0), Just(1e12), Just(1e30)],
        ) {
            let n = normal(corners.map(|c| Vec3::from(c) * scale));
            prop_assert!((n.length() - 1.0).abs() < 1e-5);
        }
    }
}
