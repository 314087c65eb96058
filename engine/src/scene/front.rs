//! From where surfaces of volumes are seen best: grids do not say what is in front, a head may look away.

use glam::Vec3;
use mobula_core::simd::{AnyToken, Scalar};

use crate::geometry::{Geometries, IsoSurfaces};
use crate::packet::{Packet, Surface};
use crate::view::{Up, View};

/// Rays along a side of each picture that is looked at.
const SIDE: usize = 64;
/// What must be seen more of than from the usual side.
const MUCH: f32 = 1.15;

/// By how many quarter turns around the axis that points up the eye should be turned from its usual place: to where most relief is seen, if
/// there is nothing but iso-surfaces, and it is much more. A smooth back, or a plate before all else, has little.
///
/// Computed by scalar kernels: the same on all machines.
pub(super) fn quarter_turns(geometry: &Geometries, bulk: (Vec3, Vec3), up: Up) -> u8 {
    let surfaces = geometry.list().iter().all(|one| one.downcast_ref::<IsoSurfaces>().is_some());
    let size = (bulk.1 - bulk.0).length();
    if !surfaces || geometry.list().is_empty() || !(size.is_finite() && size > 0.0) {
        return 0;
    }
    let reliefs = [0, 1, 2, 3].map(|turns| relief(geometry, bulk, View::usual_direction(up, turns), up));
    let best = (1..4).max_by(|&a, &b| reliefs[a].total_cmp(&reliefs[b])).unwrap_or(0);
    if reliefs[best] > MUCH * reliefs[0] { best as u8 } else { 0 }
}

/// How much normals of neighbouring hits differ, on average, in a picture of parallel rays.
fn relief(geometry: &Geometries, (low, high): (Vec3, Vec3), backward: Vec3, up: Up) -> f32 {
    let token = AnyToken::Scalar(Scalar::new());
    let (middle, radius) = (low * 0.5 + high * 0.5, (high * 0.5 - low * 0.5).length());
    let right = up.vector().cross(backward).normalize_or(Vec3::X);
    let above = backward.cross(right);
    let mut packet = Packet::new(SIDE);
    let mut before = [None; SIDE];
    let (mut sum, mut pairs) = (0.0, 0_u32);
    for y in 0..SIDE {
        packet.reset(SIDE);
        let place = |i: usize| (i as f32 + 0.5) / SIDE as f32 * 2.0 - 1.0;
        for x in 0..SIDE {
            let origin = middle + (backward * 2.0 + right * place(x) + above * place(y)) * radius;
            let rays = packet.rays_mut();
            rays.origins_mut().into_iter().zip(origin.to_array()).for_each(|(column, value)| column[x] = value);
            rays.directions_mut().into_iter().zip((-backward).to_array()).for_each(|(column, value)| column[x] = value);
        }
        geometry.intersect(token, &mut packet, u32::MAX);
        let mut row = [None; SIDE];
        for run in 0..packet.runs().len() {
            let (first, hit) = (packet.runs()[run].rays.start, packet.runs()[run].hit);
            let Some((number, _)) = hit else { continue };
            let surface: &dyn Surface = geometry.get(number);
            let mut hits = packet.sub_packet(run, Some(surface));
            let normals = hits.normals();
            for i in 0..normals[0].len() {
                row[first + i] = Some(Vec3::new(normals[0][i], normals[1][i], normals[2][i]));
            }
        }
        let across = (1..SIDE).map(|x| (row[x - 1], row[x]));
        let down = (0..SIDE).map(|x| (before[x], row[x]));
        for (a, b) in across.chain(down) {
            if let (Some(a), Some(b)) = (a, b) {
                let (a, b): (Vec3, Vec3) = (a, b);
                sum += (a - b).length().min(1.0);
                pairs += 1;
            }
        }
        before = row;
    }
    if pairs > 0 { sum / pairs as f32 } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::accel::AccelerationKind;
    use crate::geometry::{Field, Mesh, Series};
    use crate::volume::{Grid, GridPlace};

    /// A smooth ball with bumps on the side where x and y are small.
    fn bumpy() -> IsoSurfaces {
        let samples: Vec<u8> = (0..48 * 48 * 48)
            .map(|i: i32| {
                let [x, y, z] = [i % 48 - 24, i / 48 % 48 - 24, i / 2304 - 24].map(|x| x as f32);
                let bumps = if x + y < 0.0 { 2.0 * ((x * 1.3).sin() + (y * 1.1).sin() + (z * 1.2).sin()) } else { 0.0 };
                (128.0 + 8.0 * (18.0 + bumps - (x * x + y * y + z * z).sqrt())).clamp(0.0, 255.0) as u8
            })
            .collect();
        let grid = Grid::new([48; 3], samples.into(), GridPlace::with_spacing([1.0; 3]), [1.0, 0.0]).unwrap();
        let series = Series::new(vec![Arc::new(Field::new(Arc::new(grid)).unwrap())]);
        IsoSurfaces { series, values: vec![128.0], cuts: Vec::new(), ..IsoSurfaces::example(0) }
    }

    fn turns(list: Vec<Arc<dyn crate::geometry::Geometry>>, up: Up) -> u8 {
        let geometry = Geometries::build(list, &AccelerationKind::Bvh.into()).unwrap();
        let bulk = geometry.bounds();
        quarter_turns(&geometry, bulk, up)
    }

    #[test]
    fn the_side_with_relief_is_seen() {
        let found = turns(vec![Arc::new(bumpy())], Up::Z);
        let eye = View::usual_direction(Up::Z, found);
        assert!(eye.x < 0.0 && eye.y < 0.0, "{found}: {eye}");
        let mesh = Mesh {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            triangles: vec![[0, 1, 2]],
            ..Mesh::default()
        };
        assert_eq!(turns(vec![Arc::new(bumpy()), Arc::new(mesh)], Up::Z), 0, "not of meshes");
        assert_eq!(turns(vec![], Up::Y), 0);
    }
}
