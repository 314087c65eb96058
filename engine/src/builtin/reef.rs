//! What the ray swims over: a disc of sand, mounds of coral, a mirror ball, bubbles.

use glam::Vec3;
use libm::{cosf, sinf};

use super::sheet::sheet;
use crate::geometry::{Mesh, Spheres};
use crate::math::{hash, unit};

const PI: f32 = std::f32::consts::PI;
/// Radius of the disc.
const RADIUS: f32 = 4.0;
/// The golden angle: neighbours on its spiral never line up.
const GOLDEN: f32 = 2.399_963_2;
/// A mound of coral: its place, and its colours at the foot and at the top.
struct Mound {
    x: f32,
    z: f32,
    radius: f32,
    low: [f32; 3],
    high: [f32; 3],
}

const MOUNDS: [Mound; 6] = [
    Mound { x: -1.9, z: 1.15, radius: 0.85, low: [0.80, 0.10, 0.16], high: [0.98, 0.52, 0.18] },
    Mound { x: 1.75, z: -0.65, radius: 0.95, low: [0.02, 0.30, 0.42], high: [0.30, 0.80, 0.62] },
    Mound { x: -0.5, z: -2.35, radius: 0.75, low: [0.50, 0.10, 0.55], high: [0.95, 0.40, 0.62] },
    Mound { x: 2.45, z: 1.35, radius: 0.48, low: [0.90, 0.45, 0.05], high: [0.98, 0.82, 0.25] },
    Mound { x: -2.75, z: -0.85, radius: 0.55, low: [0.10, 0.18, 0.60], high: [0.35, 0.62, 0.95] },
    Mound { x: 0.2, z: 2.55, radius: 0.40, low: [0.75, 0.08, 0.35], high: [0.98, 0.55, 0.62] },
];

/// Height of the sand.
fn height(x: f32, z: f32) -> f32 {
    let r = (x * x + z * z).sqrt() / RADIUS;
    let warp = 0.45 * sinf(1.3 * x + 0.6 * z) + 0.3 * sinf(0.7 * x - 1.9 * z);
    let ripples = 0.022 * sinf(13.0 * (z + 0.25 * x) + 2.6 * warp);
    let dunes = 0.09 * sinf(0.9 * x + 0.4) * cosf(1.1 * z - 0.3);
    (ripples + dunes) * (1.0 - r * r * r).max(0.0)
}

/// The disc of sand and its rim of rock.
pub(super) fn ground(sand: u32, rock: u32) -> [Mesh; 2] {
    let top = sheet(192, 56, true, |u, v| {
        let (angle, r) = (u * 2.0 * PI, RADIUS * (1.0 - v));
        let (x, z) = (r * cosf(angle), -r * sinf(angle));
        Vec3::new(x, height(x, z), z)
    });
    let rim = sheet(192, 4, true, |u, v| {
        let angle = u * 2.0 * PI;
        let r = RADIUS * (1.0 - 0.06 * v * v);
        Vec3::new(r * cosf(angle), -0.34 * v, -r * sinf(angle))
    });
    let named = |mesh, name: &str, material| Mesh { name: name.to_owned(), material, ..mesh };
    [named(top, "sand", sand), named(rim, "rim", rock)]
}

/// Mounds of little spheres, laid out like the seeds of a sunflower.
pub(super) fn corals(material: u32) -> Spheres {
    let mut spheres = Spheres { name: "coral".to_owned(), material, ..Spheres::default() };
    for (mound, &Mound { x, z, radius, low, high }) in MOUNDS.iter().enumerate() {
        let (low, high) = (Vec3::from(low), Vec3::from(high));
        let count = (420.0 * radius) as u32 + 60;
        for k in 0..count {
            let v = (k as f32 + 0.5) / count as f32;
            let y = 1.0 - v;
            let flat = (1.0 - y * y).max(0.0).sqrt();
            let angle = k as f32 * GOLDEN + mound as f32;
            let h = hash(k ^ hash(mound as u32));
            let bump = 1.0 + 0.05 * sinf(5.0 * angle.rem_euclid(2.0 * PI)) * flat;
            let center = Vec3::new(x, height(x, z) - 0.06 * radius, z)
                + Vec3::new(flat * cosf(angle), 0.92 * y, flat * sinf(angle)) * (radius * bump);
            spheres.centers.push(center.to_array());
            spheres.radii.push(radius * (1.15 / (count as f32).sqrt()) * (1.25 + 0.4 * unit(h)));
            let mix = (y + 0.25 * (unit(hash(h)) - 0.5)).clamp(0.0, 1.0);
            spheres.colors.push((low + (high - low) * mix).to_array());
        }
    }
    spheres
}

/// A mirror ball on the sand.
pub(super) fn ball(material: u32) -> Spheres {
    let (x, z, radius) = (0.75, 1.45, 0.52);
    let center = [x, height(x, z) + radius * 0.97, z];
    Spheres { name: "ball".to_owned(), centers: vec![center], radii: vec![radius], material, ..Spheres::default() }
}

/// Bubbles that rise in two columns.
pub(super) fn bubbles(material: u32) -> Spheres {
    let mut spheres = Spheres { name: "bubbles".to_owned(), material, ..Spheres::default() };
    for k in 0..26_u32 {
        let h = [0, 1, 2].map(|salt| unit(hash(3 * k + salt + 1000)));
        let (x, z) = if k % 2 == 0 { (2.55, 0.4) } else { (-2.35, -1.9) };
        let y = 0.5 + 3.2 * (k as f32 + h[0]) / 26.0;
        let wobble = 0.10 + 0.07 * y;
        spheres.centers.push([x + wobble * (2.0 * h[1] - 1.0), y, z + wobble * (2.0 * h[2] - 1.0)]);
        spheres.radii.push((0.03 + 0.05 * h[0]) * (0.7 + 0.25 * y));
    }
    spheres
}
