//! The ray: a body with wings, two head fins, a tail.

use glam::Vec3;
use libm::{cosf, sinf};

use super::sheet::sheet;
use crate::geometry::Mesh;

const PI: f32 = std::f32::consts::PI;
/// Quads around the section of a wing, and from tip to tip.
const COLUMNS: u32 = 72;
const ROWS: u32 = 120;

/// The ray, dark above and pale below, banking over the reef.
pub(super) fn manta(back: u32, belly: u32) -> Vec<Mesh> {
    let mut body = sheet(COLUMNS, ROWS, true, |around, across| place(wing(across * 2.0 - 1.0, around)));
    body.name = "manta".to_owned();
    // Around the section, the first half is the upper side. The pale shoulder patches end at lines of the grid, so that
    // their edges are smooth.
    body.materials = (body.triangles.iter())
        .map(|triangle| {
            let column = triangle.iter().map(|i| i % COLUMNS).min().unwrap_or(0);
            let upper = column < COLUMNS / 2;
            let from_middle = (triangle[0] / COLUMNS).abs_diff(ROWS / 2);
            let patch = (5..30).contains(&from_middle) && (14..17).contains(&column);
            if upper && !patch { back } else { belly }
        })
        .collect();
    let mut parts = vec![body];
    for side in [-1.0, 1.0] {
        parts.push(tube(back, 24, 24, move |v| {
            let swing = sinf(v * PI * 0.6);
            let center = Vec3::new(side * (0.20 - 0.05 * v + 0.05 * swing), 0.02 - 0.07 * v * v, 0.62 + 0.34 * v);
            (center, 0.055 * (1.0 - v * v * v) + 0.004, 0.55)
        }));
        // Eyes would need a name of their own; a bump does.
        parts.push(tube(back, 16, 8, move |v| {
            let x = side * (0.25 + 0.05 * v);
            (Vec3::new(x, 0.03, 0.60), 0.035 * (1.0 - v * v).max(0.0).sqrt() + 0.001, 1.0)
        }));
    }
    parts.push(tube(back, 16, 64, |v| {
        let center = Vec3::new(0.10 * sinf(3.0 * v), 0.02 + 0.10 * v * v, -0.60 - 1.9 * v);
        (center, 0.035 * (1.0 - v) + 0.004, 1.0)
    }));
    parts
}

/// Where the section of a wing is at `around` (0..1): position along the chord, 0 in front, and height, -1..1.
fn section(around: f32) -> (f32, f32) {
    let angle = around * 2.0 * PI;
    let along = 0.5 * (1.0 + cosf(angle));
    (1.0 - along, sinf(angle))
}

/// A point of the body: `across` from wing tip (-1) to wing tip (1), `around` the section. Forward is z, up is y.
fn wing(across: f32, around: f32) -> Vec3 {
    let s = across.abs();
    let (along, height) = section(around);
    // Leading edge: a blunt head, then swept wings. Trailing edge: concave.
    let head = 0.10 / (1.0 + 60.0 * s * s);
    let front = 0.56 + head - 0.10 * s - 0.72 * s * s * s;
    let rear = -0.62 + 0.46 * sinf(s * PI * 0.5) - 0.28 * s * s * s * s;
    let tip = (1.0 - s * s * s).max(0.0);
    let middle = 0.5 * (front + rear);
    let chord = (front - rear) * (tip * (1.7 - 0.7 * tip)).max(0.004);
    let z = middle + chord * (0.5 - along);
    // Thick in the body, thin in the wings; thickest a third behind the front.
    let profile = (along * (1.0 - along)).max(0.0).sqrt() * (1.35 - 0.9 * along);
    let thickness = 0.035 + 0.20 / (1.0 + 14.0 * s * s);
    let half = thickness * profile * tip.sqrt().max(0.01) * if height < 0.0 { 0.7 } else { 1.0 };
    let bend = 0.42 * s * s - 0.16 * s * s * s * s + 0.05 * s * tip * (along - 0.5);
    Vec3::new(1.55 * across, bend + half * sign(height), z)
}

/// -1, 0 or 1, smooth enough at the edges because the thickness vanishes there.
fn sign(height: f32) -> f32 {
    if height.abs() < 1e-6 { 0.0 } else { height.signum() }
}

/// A closed tube around a curve: `at(v)` gives its middle, radius, and height as a fraction of its width.
fn tube(material: u32, columns: u32, rows: u32, at: impl Fn(f32) -> (Vec3, f32, f32)) -> Mesh {
    let mesh = sheet(columns, rows, true, |u, v| {
        let (center, radius, flat) = at(v);
        let ahead = (at((v + 1e-3).min(1.0)).0 - at((v - 1e-3).max(0.0)).0).normalize();
        let right = ahead.cross(Vec3::Y).normalize();
        let up = right.cross(ahead);
        let angle = u * 2.0 * PI;
        place(center + (right * cosf(angle) + up * (flat * sinf(angle))) * radius)
    });
    Mesh { name: "manta".to_owned(), material, ..mesh }
}

/// From the ray's own axes into the scene: larger, heading to the front left, banking towards the viewer.
fn place(p: Vec3) -> Vec3 {
    let (yaw, pitch, roll) = (-0.80_f32, -0.10_f32, -0.30_f32);
    let p = turn(p, Vec3::X, Vec3::Y, roll);
    let p = turn(p, Vec3::Y, Vec3::Z, pitch);
    let p = turn(p, Vec3::Z, Vec3::X, yaw);
    Vec3::new(-0.25, 2.15, 0.0) + p * 1.65
}

/// Turns `p` in the plane from axis `a` to axis `b`.
fn turn(p: Vec3, a: Vec3, b: Vec3, angle: f32) -> Vec3 {
    let (sin, cos) = (sinf(angle), cosf(angle));
    let (x, y) = (p.dot(a), p.dot(b));
    p + a * (x * cos - y * sin - x) + b * (x * sin + y * cos - y)
}
