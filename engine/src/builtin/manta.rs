//! The ray: a body with wings, two head fins, a tail.

use std::sync::Arc;

use glam::{Mat3, Vec3};
use libm::{cosf, sinf};

use super::sheet::sheet;
use crate::scene::{Mesh, Object};

const PI: f32 = std::f32::consts::PI;

/// The ray, dark above and pale below, banking over the reef.
pub(super) fn manta(back: u32, belly: u32) -> Object {
    let mut body = sheet(72, 120, true, |around, across| place(wing(across * 2.0 - 1.0, around)));
    body.name = "manta".to_owned();
    // Around the section, the first half is the upper side.
    let columns = 72;
    body.materials = Vec::new();
    for triangle in &body.triangles {
        let column = triangle.iter().map(|i| i % columns).min().unwrap_or(0);
        let row = triangle[0] / columns;
        let across = (row as f32 + 0.5) / 120.0 * 2.0 - 1.0;
        let chord = section((column as f32 + 0.5) / columns as f32).0;
        // Pale shoulder patches, as the real ones have them.
        let s = across.abs();
        let patch = s > 0.10 && s < 0.42 && (chord - (0.20 + 0.35 * s)).abs() < 0.075 - 0.10 * (s - 0.2).abs();
        body.materials.push(if column < columns / 2 && !patch { back } else { belly });
    }
    let mut parts = vec![Object::Mesh(Arc::new(body))];
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
    Object::Group(parts)
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
    let tip = (1.0 - s * s * s * s).max(0.0);
    let middle = 0.5 * (front + rear);
    let chord = (front - rear) * tip.sqrt().max(0.02);
    let z = middle + chord * (0.5 - along);
    // Thick in the body, thin in the wings; thickest a third behind the front.
    let profile = (along * (1.0 - along)).max(0.0).sqrt() * (1.35 - 0.9 * along);
    let thickness = 0.035 + 0.20 / (1.0 + 14.0 * s * s);
    let half = thickness * profile * tip.sqrt().max(0.02) * if height < 0.0 { 0.7 } else { 1.0 };
    let bend = 0.42 * s * s - 0.16 * s * s * s * s + 0.05 * s * (along - 0.5);
    Vec3::new(1.55 * across, bend + half * sign(height), z)
}

/// -1, 0 or 1, smooth enough at the edges because the thickness vanishes there.
fn sign(height: f32) -> f32 {
    if height.abs() < 1e-6 { 0.0 } else { height.signum() }
}

/// A closed tube around a curve: `at(v)` gives its middle, radius, and height as a fraction of its width.
fn tube(material: u32, columns: u32, rows: u32, at: impl Fn(f32) -> (Vec3, f32, f32)) -> Object {
    let mesh = sheet(columns, rows, true, |u, v| {
        let (center, radius, flat) = at(v);
        let ahead = (at((v + 1e-3).min(1.0)).0 - at((v - 1e-3).max(0.0)).0).normalize();
        let right = ahead.cross(Vec3::Y).normalize();
        let up = right.cross(ahead);
        let angle = u * 2.0 * PI;
        place(center + (right * cosf(angle) + up * (flat * sinf(angle))) * radius)
    });
    Object::Mesh(Arc::new(Mesh { name: "manta".to_owned(), material, ..mesh }))
}

/// From the ray's own axes into the scene: larger, banking, heading to the front left.
fn place(p: Vec3) -> Vec3 {
    let rotation = Mat3::from_cols(
        Vec3::new(0.878, -0.208, 0.431),
        Vec3::new(0.226, 0.974, 0.010),
        Vec3::new(-0.422, 0.088, 0.902),
    );
    Vec3::new(-0.15, 2.05, -0.1) + rotation * (p * 1.45)
}
