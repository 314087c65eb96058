//! A triangle from its corners: normal, barycentric coordinates.
//!
//! Everything is computed for one ray at a time from that ray alone, in f32, unfused: the same at every packet width and
//! level.

use glam::Vec3;

use crate::math::{normalize, normalize_or};

/// Unit normal of a triangle that has an area.
#[inline(always)]
pub(super) fn normal(corners: [Vec3; 3]) -> Vec3 {
    let [a, b, c] = corners;
    let n = (b - a).cross(c - a);
    let length_squared = n.dot(n);
    // Far from where squares lose bits to under- or overflow.
    if length_squared > 1e-24 && length_squared < 1e30 { normalize(n) } else { tiny_normal(corners) }
}

#[cold]
fn tiny_normal(corners: [Vec3; 3]) -> Vec3 {
    normalize_or(normal_f64(corners), Vec3::Y)
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
