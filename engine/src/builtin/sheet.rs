//! Meshes from parametric surfaces.

use glam::Vec3;

use crate::geometry::Mesh;
use crate::math::normalize_or;

/// A grid of `columns` x `rows` quads over `at(u, v)`, u and v in 0..=1, with smooth normals. `closed`: the last column
/// joins the first, so that u = 1 is the same as u = 0. Quads without area (at a pole) give one triangle or none.
pub(super) fn sheet(columns: u32, rows: u32, closed: bool, at: impl Fn(f32, f32) -> Vec3) -> Mesh {
    let stride = if closed { columns } else { columns + 1 };
    let mut positions = Vec::new();
    for row in 0..=rows {
        for column in 0..stride {
            positions.push(at(column as f32 / columns as f32, row as f32 / rows as f32));
        }
    }
    let index = |column: u32, row: u32| row * stride + if closed { column % columns } else { column };
    let mut triangles: Vec<[u32; 3]> = Vec::new();
    for row in 0..rows {
        for column in 0..columns {
            let [a, b] = [index(column, row), index(column + 1, row)];
            let [c, d] = [index(column, row + 1), index(column + 1, row + 1)];
            let area = |t: &[u32; 3]| {
                let [a, b, c] = t.map(|i| positions[i as usize]);
                (b - a).cross(c - a).length() > 1e-9
            };
            triangles.extend([[a, b, d], [a, d, c]].into_iter().filter(area));
        }
    }
    let normals = smooth(&positions, &triangles);
    Mesh {
        positions: positions.iter().map(|p| p.to_array()).collect(),
        normals,
        triangle_normals: triangles.clone(),
        triangles,
        ..Mesh::default()
    }
}

/// Normals at the corners: the sum of the triangles around, by area.
fn smooth(positions: &[Vec3], triangles: &[[u32; 3]]) -> Vec<[f32; 3]> {
    let mut sums = vec![Vec3::ZERO; positions.len()];
    for triangle in triangles {
        let [a, b, c] = triangle.map(|i| positions[i as usize]);
        let normal = (b - a).cross(c - a);
        triangle.iter().for_each(|&i| sums[i as usize] += normal);
    }
    sums.iter().map(|n| normalize_or(n.to_array().map(f64::from), Vec3::Y).to_array()).collect()
}
