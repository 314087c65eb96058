//! What is known of the surface of spheres at hits. `sphere` gives the centre and the radius of each primitive.

use glam::Vec3;

use crate::math::{normalize, normalize_or};
use crate::packet::{Hits, set_vec3};

/// Outwards; up where the centre was hit.
#[inline(always)]
fn normal(center: Vec3, position: Vec3) -> Vec3 {
    let r = position - center;
    let length_squared = r.dot(r);
    if length_squared > 1e-24 && length_squared < 1e30 {
        normalize(r)
    } else {
        normalize_or(r.to_array().map(f64::from), Vec3::Y)
    }
}

/// Unit normals, outwards, and the radii.
#[inline(always)]
pub(super) fn normals(
    hits: &Hits<'_>,
    mut out: [&mut [f32]; 3],
    radii: &mut [f32],
    sphere: impl Fn(usize) -> Option<(Vec3, f32)>,
) {
    for (i, &k) in hits.primitives.iter().enumerate() {
        let (center, radius) = sphere(k as usize).unwrap_or_default();
        set_vec3(&mut out, i, normal(center, hits.position(i)));
        radii[i] = radius;
    }
}

/// Longitude and latitude, 0..1, around y.
#[inline(always)]
pub(super) fn texture_coordinates(
    hits: &Hits<'_>,
    mut out: [&mut [f32]; 3],
    sphere: impl Fn(usize) -> Option<(Vec3, f32)>,
) {
    for (i, &k) in hits.primitives.iter().enumerate() {
        let (center, _) = sphere(k as usize).unwrap_or_default();
        let n = normal(center, hits.position(i));
        let longitude = libm::atan2f(-n.z, n.x) * (0.5 * core::f32::consts::FRAC_1_PI) + 0.5;
        let latitude = libm::asinf(n.y.clamp(-1.0, 1.0)) * core::f32::consts::FRAC_1_PI + 0.5;
        set_vec3(&mut out, i, Vec3::new(longitude, latitude, 0.0));
    }
}

/// Eastwards, which is to the right as seen from outside, and northwards around y.
#[inline(always)]
pub(super) fn derivatives(
    hits: &Hits<'_>,
    [mut out_u, mut out_v]: [[&mut [f32]; 3]; 2],
    sphere: impl Fn(usize) -> Option<(Vec3, f32)>,
) {
    for (i, &k) in hits.primitives.iter().enumerate() {
        let (center, _) = sphere(k as usize).unwrap_or_default();
        let r = hits.position(i) - center;
        let around = core::f32::consts::TAU;
        let flat = (r.x * r.x + r.z * r.z).sqrt();
        let north =
            if flat > 0.0 { Vec3::new(-r.x * r.y / flat, flat, -r.z * r.y / flat) } else { Vec3::new(-r.y, 0.0, 0.0) };
        set_vec3(&mut out_u, i, Vec3::new(r.z, 0.0, -r.x) * around);
        set_vec3(&mut out_v, i, north * (0.5 * around));
    }
}
