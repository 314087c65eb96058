//! How boundaries reflect: Fresnel's equations, and rough surfaces as microfacets after Trowbridge and Reitz (GGX).
//!
//! Sources: Walter et al., "Microfacet Models for Refraction through Rough Surfaces", EGSR 2007; Heitz, "Understanding the
//! Masking-Shadowing Function in Microfacet-Based BRDFs", JCGT 2014, for the height-correlated form of Smith's function; Heitz, "Sampling
//! the GGX Distribution of Visible Normals", JCGT 2018. Roughness is that of artists; its square is alpha. All directions have unit
//! length and point away from the surface; cosines are those of the angles with its normal.

use glam::Vec3;

use crate::math::normalize;

/// What a perfectly smooth boundary reflects of unpolarised light: Fresnel's equations. `cosine` is that of the incident ray, and `eta` the
/// index of refraction on the other side over that on this one. The cosine behind the boundary comes with it; 0 where all is reflected.
#[inline(always)]
pub(super) fn fresnel(cosine: f32, eta: f32) -> (f32, f32) {
    let sine2 = (1.0 - cosine * cosine).max(0.0) / (eta * eta);
    if sine2 >= 1.0 {
        return (1.0, 0.0);
    }
    let behind = (1.0 - sine2).sqrt();
    let across = (cosine - eta * behind) / (cosine + eta * behind);
    let along = (eta * cosine - behind) / (eta * cosine + behind);
    (0.5 * (across * across + along * along), behind)
}

/// What such a boundary reflects at normal incidence.
pub(super) fn normal_reflectance(eta: f32) -> f32 {
    let r = (eta - 1.0) / (eta + 1.0);
    r * r
}

/// How near reflectance is to 1 at this angle (Schlick 1994): from 0 at normal incidence to 1.
#[inline(always)]
pub(super) fn schlick(cosine: f32) -> f32 {
    let x = (1.0 - cosine).clamp(0.0, 1.0);
    let x2 = x * x;
    x2 * x2 * x
}

/// `pi D V cos`: what a surface whose facets reflect all light sends of a light's radiance along `view`; and the cosine at the facets that
/// do it. `normal` is on the side of the view; lights behind the surface give 0.
#[inline(always)]
pub(super) fn reflected(normal: Vec3, view: Vec3, light: Vec3, alpha: f32) -> (f32, f32) {
    let (to_view, to_light) = (normal.dot(view).max(LEAST_COSINE), normal.dot(light));
    if to_light <= 0.0 {
        return (0.0, 1.0);
    }
    let half = normalize(view + light);
    let across = normal.cross(half);
    let a2 = alpha * alpha;
    // cos^2 (a2 - 1) + 1, without the difference of numbers that are nearly the same.
    let sine2 = across.dot(across);
    let t = sine2 + (1.0 - sine2) * a2;
    let distribution = a2 / (t * t);
    let root = |cosine: f32| (cosine * cosine * (1.0 - a2) + a2).sqrt();
    let visibility = 0.5 / (to_light * root(to_view) + to_view * root(to_light));
    (distribution * visibility * to_light, view.dot(half).clamp(0.0, 1.0))
}

/// Surfaces are not seen at less than this: the limit of what is divided by it is the same.
pub(super) const LEAST_COSINE: f32 = 1e-4;

/// A normal of a facet that is seen from `view`, as often as it is seen: for a point of the unit disk. In coordinates in which the normal
/// of the surface is z.
#[inline(always)]
pub(super) fn visible_normal(view: Vec3, alpha: f32, [x, y]: [f32; 2]) -> Vec3 {
    let stretched = normalize(Vec3::new(alpha * view.x, alpha * view.y, view.z));
    let flat2 = stretched.x * stretched.x + stretched.y * stretched.y;
    let first = if flat2 > 1e-12 { Vec3::new(-stretched.y, stretched.x, 0.0) * (1.0 / flat2.sqrt()) } else { Vec3::X };
    let second = stretched.cross(first);
    let s = 0.5 * (1.0 + stretched.z);
    let y = (1.0 - s) * (1.0 - x * x).max(0.0).sqrt() + s * y;
    let z = (1.0 - x * x - y * y).max(0.0).sqrt();
    let n = first * x + second * y + stretched * z;
    normalize(Vec3::new(alpha * n.x, alpha * n.y, n.z.max(1e-6)))
}

/// Smith's lambda: how much of the microfacets hides the rest.
#[inline(always)]
fn lambda(cosine: f32, alpha: f32) -> f32 {
    let tangent2 = (1.0 - cosine * cosine).max(0.0) / (cosine * cosine);
    0.5 * ((1.0 + alpha * alpha * tangent2).sqrt() - 1.0)
}

/// The part of the light along `light` that is not hidden from the light, of that which is seen: the weight of a direction that was reflected
/// at a [visible normal](visible_normal). Both cosines are positive.
#[inline(always)]
pub(super) fn unhidden(to_view: f32, to_light: f32, alpha: f32) -> f32 {
    let seen = 1.0 + lambda(to_view, alpha);
    seen / (seen + lambda(to_light, alpha))
}

/// Two unit vectors that are perpendicular to a normal and to each other (Duff et al., "Building an Orthonormal Basis, Revisited", JCGT
/// 2017).
#[inline(always)]
pub(super) fn tangents(n: Vec3) -> [Vec3; 2] {
    let sign = if n.z < 0.0 { -1.0 } else { 1.0 };
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    [Vec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x), Vec3::new(b, sign + n.y * n.y * a, -n.y)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fresnel_at_known_angles() {
        assert!((fresnel(1.0, 1.5).0 - 0.04).abs() < 1e-6 && (normal_reflectance(1.5) - 0.04).abs() < 1e-6);
        // At Brewster's angle all that is reflected is polarised: half of the square of cos(2 b).
        let brewster = 1.5_f32.atan();
        let (found, behind) = fresnel(brewster.cos(), 1.5);
        assert!((found - 0.5 * (2.0 * brewster).cos().powi(2)).abs() < 1e-5, "{found}");
        assert!((behind - brewster.sin()).abs() < 1e-5, "the refracted ray is perpendicular to the reflected one");
        assert_eq!(fresnel(0.0, 1.5).0, 1.0);
        assert_eq!(fresnel(0.7, 1.0 / 1.5), (1.0, 0.0), "total internal reflection");
        assert!(fresnel(0.3, 1.0).0 < 1e-9);
    }

    #[test]
    fn sampled_and_evaluated_reflections_are_the_same() {
        const STEPS: u32 = 256;
        for (cosine, alpha) in [(1.0_f32, 0.3_f32), (0.5, 0.3), (0.1, 0.8), (0.7, 0.15)] {
            let view = Vec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine);
            // The part of the light that is reflected, and the mean direction along x: once over all lights, once over facets.
            let (mut over_lights, mut over_facets) = ([0.0_f64; 2], [0.0_f64; 2]);
            for i in 0..STEPS {
                for k in 0..STEPS {
                    let place = (i as f32 + 0.5) / STEPS as f32;
                    let turn = std::f32::consts::TAU * (k as f32 + 0.5) / STEPS as f32;
                    let (sine, upward) = (std::f32::consts::FRAC_PI_2 * place).sin_cos();
                    let light = Vec3::new(sine * turn.cos(), sine * turn.sin(), upward);
                    let weight = reflected(Vec3::Z, view, light, alpha).0 * sine;
                    let area = std::f64::consts::PI / f64::from(STEPS * STEPS);
                    over_lights[0] += f64::from(weight) * area;
                    over_lights[1] += f64::from(weight * light.x) * area;

                    let radius = place.sqrt();
                    let facet = visible_normal(view, alpha, [radius * turn.cos(), radius * turn.sin()]);
                    let light = facet * (2.0 * facet.dot(view)) - view;
                    if light.z > 0.0 {
                        let weight = f64::from(unhidden(cosine, light.z.min(1.0), alpha)) / f64::from(STEPS * STEPS);
                        over_facets[0] += weight;
                        over_facets[1] += weight * f64::from(light.x);
                    }
                }
            }
            for (a, b) in over_lights.into_iter().zip(over_facets) {
                assert!((a - b).abs() < 3e-3, "{over_lights:?} {over_facets:?} at {cosine}, {alpha}");
            }
        }
    }

    #[test]
    fn tangents_are_perpendicular() {
        for n in [Vec3::Z, Vec3::NEG_Z, Vec3::new(0.6, -0.8, 0.0), Vec3::new(-0.48, 0.6, -0.64)] {
            let [a, b] = tangents(n);
            assert!(a.dot(b).abs() < 1e-6 && a.dot(n).abs() < 1e-6 && (a.cross(b) - n).length() < 1e-5);
        }
    }
}
