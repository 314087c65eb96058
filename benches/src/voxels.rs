//! Meshes as voxels: how much of each voxel is inside, by scan lines, a slice at a time.
//!
//! A slice is cut at several heights. A triangle that a plane cuts leaves a segment of a line there; a row of the slice meets that at a
//! crossing, at which the winding number changes. Inside is where that is not zero, whichever way the triangles are turned. A point that is
//! on a plane or on a row counts as below, and neighbours compute the ends of their segments from the same edge in the same order:
//! a closed mesh has rows whose crossings come out even. Rows where they do not, at holes of a mesh, get a voxel's thickness
//! around each crossing instead.
//!
//! Triangles of which another is the back are sheets: they have nothing inside, and get three quarters of a voxel on both sides.

use std::collections::HashSet;
use std::io;

use mobula::math::{hash, unit};

use crate::scenes::Triangles;

/// The value of what is outside.
pub const OUTSIDE: f64 = 8000.0;
/// The value of what is inside.
pub const INSIDE: f64 = 48_000.0;
/// The value of the surface.
pub const SURFACE: f64 = 0.5 * (OUTSIDE + INSIDE);
/// Voxels around the mesh that are outside.
const MARGIN: f64 = 2.0;
/// Features of the noise, in voxels.
const FEATURE: usize = 8;

/// How a mesh is made voxels.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// Voxels along the longest side.
    pub size: usize,
    /// Rows and slices that each voxel is cut at; along a row nothing is sampled.
    pub cuts: usize,
    /// Smooth noise that is added, at most.
    pub noise: f64,
    /// What the noise is made from.
    pub seed: u32,
}

/// Where voxels are: sample (i, j, k) is at `origin + spacing (i, j, k)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Voxels along each axis.
    pub dims: [usize; 3],
    /// The middle of the first.
    pub origin: [f64; 3],
    /// The size of each.
    pub spacing: f64,
}

/// What was found on the way.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Report {
    /// Rows with crossings.
    pub rows: u64,
    /// Rows of these at holes.
    pub odd: u64,
    /// How many voxels are inside, parts of voxels too.
    pub inside: f64,
}

/// Where the voxels of a mesh are; `None` if it has no extent.
pub fn place(mesh: &Triangles, size: usize) -> Option<Place> {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for corner in mesh.indices.iter().flatten() {
        for (axis, &x) in mesh.positions[*corner as usize].iter().enumerate() {
            low[axis] = low[axis].min(f64::from(x));
            high[axis] = high[axis].max(f64::from(x));
        }
    }
    let side = [0, 1, 2].map(|axis| high[axis] - low[axis]);
    let longest = side.into_iter().fold(0.0, f64::max);
    let spacing = longest / (size as f64 - 2.0 * MARGIN);
    if !(spacing.is_finite() && spacing > 0.0) {
        return None;
    }
    let dims = side.map(|side| ((side / spacing + 2.0 * MARGIN).ceil() as usize).min(size));
    let origin = [0, 1, 2].map(|axis| 0.5 * (low[axis] + high[axis]) - 0.5 * (dims[axis] - 1) as f64 * spacing);
    Some(Place { dims, origin, spacing })
}

/// Makes voxels, and gives each slice of them to `slice`.
///
/// # Errors
/// Those of `slice`.
pub fn voxelise(
    mesh: &Triangles,
    place: &Place,
    settings: &Settings,
    mut slice: impl FnMut(&[u16]) -> io::Result<()>,
) -> io::Result<Report> {
    let [nx, ny, nz] = place.dims;
    let cuts = settings.cuts.max(1);
    let (solid, sheets) = triangles(mesh, place);
    let mut sweep = Sweep { triangles: solid, next: 0, active: Vec::new() };
    let mut sheets = Sweep { triangles: sheets, next: 0, active: Vec::new() };
    let mut report = Report::default();
    let mut covered = vec![0.0f32; nx * ny];
    let mut voxels = vec![0u16; nx * ny];
    let mut crossings = Vec::new();
    for k in 0..nz {
        covered.fill(0.0);
        for cut in 0..cuts {
            crossings.clear();
            sweep.cut(k as f64 - 0.5 + (cut as f64 + 0.5) / cuts as f64, ny, cuts, &mut crossings);
            crossings.sort_unstable_by(|a: &Crossing, b| a.row.cmp(&b.row).then(a.x.total_cmp(&b.x)));
            for row in crossings.chunk_by(|a, b| a.row == b.row) {
                let at = row[0].row as usize / cuts * nx;
                report.rows += 1;
                report.odd += u64::from(fill(row, &mut covered[at..at + nx], 1.0 / (cuts * cuts) as f32));
            }
        }
        sheets.splat(k as f64, [nx, ny], &mut covered);
        for (i, (voxel, &part)) in voxels.iter_mut().zip(&covered).enumerate() {
            report.inside += f64::from(part);
            let noise = settings.noise * noise([i % nx, i / nx, k], settings.seed);
            let value = OUTSIDE + (INSIDE - OUTSIDE) * f64::from(part.min(1.0)) + noise;
            *voxel = value.round().clamp(0.0, 65_535.0) as u16;
        }
        slice(&voxels)?;
    }
    Ok(report)
}

/// Where a row meets the mesh, and how the winding number changes there.
#[derive(Clone, Copy, Debug)]
struct Crossing {
    row: u32,
    x: f64,
    change: i32,
}

/// A triangle in units of voxels.
type Triangle = [[f64; 3]; 3];

/// The triangles with something inside, and one of each pair that is a sheet; both by their least z.
fn triangles(mesh: &Triangles, place: &Place) -> (Vec<Triangle>, Vec<Triangle>) {
    let voxel = |corner: [f32; 3]| [0, 1, 2].map(|axis| (f64::from(corner[axis]) - place.origin[axis]) / place.spacing);
    // From the least corner on: the same for all that are turned the same way.
    let key = |corners: [[f32; 3]; 3], turned: bool| {
        let mut bits = corners.map(|corner| corner.map(|x| (x + 0.0).to_bits()));
        if turned {
            bits.swap(1, 2);
        }
        let least = (0..3).min_by_key(|&k| bits[k]).unwrap_or(0);
        bits.rotate_left(least);
        bits
    };
    let is_finite = |corners: &[[f32; 3]; 3]| corners.as_flattened().iter().all(|x| x.is_finite());
    let all: Vec<_> = (0..mesh.indices.len()).map(|i| mesh.corners(i)).filter(is_finite).collect();
    let fronts: HashSet<_> = all.iter().map(|&corners| key(corners, false)).collect();
    let (mut solid, mut sheets) = (Vec::new(), Vec::new());
    for &corners in &all {
        let (front, back) = (key(corners, false), key(corners, true));
        if !fronts.contains(&back) {
            solid.push(corners.map(voxel));
        } else if front < back {
            sheets.push(corners.map(voxel));
        }
    }
    for some in [&mut solid, &mut sheets] {
        some.sort_by(|a, b| lowest(a).total_cmp(&lowest(b)));
    }
    (solid, sheets)
}

/// Triangles by their least z, those that are met now among them.
struct Sweep {
    triangles: Vec<Triangle>,
    next: usize,
    active: Vec<usize>,
}

impl Sweep {
    /// Those from one z to another; both must be at least what they were before.
    fn advance(&mut self, from: f64, to: f64) {
        let Self { triangles, next, active } = self;
        while triangles.get(*next).is_some_and(|triangle| lowest(triangle) <= to) {
            active.push(*next);
            *next += 1;
        }
        active.retain(|&i| triangles[i].iter().any(|corner| corner[2] > from));
    }

    /// Covers the voxels of a slice that are near triangles, by their distance.
    fn splat(&mut self, z: f64, [nx, ny]: [usize; 2], covered: &mut [f32]) {
        const REACH: f64 = 1.25;
        self.advance(z - REACH, z + REACH);
        for triangle in self.active.iter().map(|&i| &self.triangles[i]) {
            let range = |axis: usize, count: usize| {
                let ends = triangle.iter().map(|corner| corner[axis]);
                let (low, high) = ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
                ((low - REACH).ceil().max(0.0) as usize)..((high + REACH + 1.0).max(0.0) as usize).min(count)
            };
            for y in range(1, ny) {
                for x in range(0, nx) {
                    let part = (REACH - distance([x as f64, y as f64, z], triangle)).clamp(0.0, 1.0) as f32;
                    let covered = &mut covered[y * nx + x];
                    *covered = covered.max(part);
                }
            }
        }
    }

    /// The crossings of `cuts` rows a voxel with the plane at z, which must be above the one before.
    fn cut(&mut self, z: f64, ny: usize, cuts: usize, crossings: &mut Vec<Crossing>) {
        self.advance(z, z);
        for corners in self.active.iter().map(|&i| &self.triangles[i]) {
            let (mut up, mut down) = (None, None);
            for (a, b) in [(0, 1), (1, 2), (2, 0)] {
                match (corners[a][2] > z, corners[b][2] > z) {
                    (false, true) => up = Some(on_edge(corners[a], corners[b], z)),
                    (true, false) => down = Some(on_edge(corners[b], corners[a], z)),
                    _ => {}
                }
            }
            let (Some(from), Some(to)) = (up, down) else { continue };
            let (low, high, change) = if from[1] < to[1] { (from, to, 1) } else { (to, from, -1) };
            // Row r is at y = (r + 1/2) / cuts - 1/2.
            let row_after = |y: f64| ((y + 0.5) * cuts as f64 - 0.5).ceil().clamp(0.0, (ny * cuts) as f64) as u32;
            for row in row_after(low[1]).saturating_sub(1)..(row_after(high[1]) + 1).min((ny * cuts) as u32) {
                let y = (f64::from(row) + 0.5) / cuts as f64 - 0.5;
                if low[1] <= y && y < high[1] {
                    let x = low[0] + (high[0] - low[0]) * ((y - low[1]) / (high[1] - low[1]));
                    crossings.push(Crossing { row, x, change });
                }
            }
        }
    }
}

fn lowest(triangle: &Triangle) -> f64 {
    triangle.iter().fold(f64::INFINITY, |low, corner| low.min(corner[2]))
}

/// Where an edge meets a plane: x and y.
fn on_edge(below: [f64; 3], above: [f64; 3], z: f64) -> [f64; 2] {
    let part = (z - below[2]) / (above[2] - below[2]);
    [0, 1].map(|axis| below[axis] + (above[axis] - below[axis]) * part)
}

/// How far a point is from a triangle: from its plane if it is above it, else from the nearest edge.
fn distance(point: [f64; 3], triangle: &Triangle) -> f64 {
    let sub = |a: [f64; 3], b: [f64; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let cross =
        |a: [f64; 3], b: [f64; 3]| [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let normal = cross(sub(triangle[1], triangle[0]), sub(triangle[2], triangle[0]));
    let (mut above, mut nearest) = (dot(normal, normal) > 0.0, f64::INFINITY);
    for k in 0..3 {
        let (edge, from) = (sub(triangle[(k + 1) % 3], triangle[k]), sub(point, triangle[k]));
        above &= dot(cross(normal, edge), from) >= 0.0;
        let part = (dot(edge, from) / dot(edge, edge).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        let off = sub(from, edge.map(|x| part * x));
        nearest = nearest.min(dot(off, off).sqrt());
    }
    if above { dot(normal, sub(point, triangle[0])).abs() / dot(normal, normal).sqrt() } else { nearest }
}

/// Adds what a row covers of voxels; says whether its crossings are odd.
fn fill(row: &[Crossing], covered: &mut [f32], weight: f32) -> bool {
    let odd = row.iter().map(|crossing| crossing.change).sum::<i32>() != 0;
    if odd {
        let mut end = f64::NEG_INFINITY;
        for crossing in row {
            span(covered, (crossing.x - 0.5).max(end), crossing.x + 0.5, weight);
            end = crossing.x + 0.5;
        }
        return true;
    }
    let (mut winding, mut start) = (0, 0.0);
    for crossing in row {
        if winding == 0 {
            start = crossing.x;
        }
        winding += crossing.change;
        if winding == 0 {
            span(covered, start, crossing.x, weight);
        }
    }
    false
}

/// Adds what is covered from one x to another; voxel i is from i - 1/2 to i + 1/2.
fn span(covered: &mut [f32], from: f64, to: f64, weight: f32) {
    let ends = [from, to].map(|x| (x + 0.5).clamp(0.0, covered.len() as f64));
    let [first, last] = ends.map(|x| (x as usize).min(covered.len() - 1));
    for (i, part) in covered[first..=last].iter_mut().enumerate() {
        let low = (first + i) as f64;
        *part += weight * ((ends[1].min(low + 1.0) - ends[0].max(low)).max(0.0)) as f32;
    }
}

/// Smooth noise from -1 to 1: random numbers at every eighth voxel, interpolated.
fn noise(at: [usize; 3], seed: u32) -> f64 {
    let cell = at.map(|x| (x / FEATURE) as u32);
    let part = at.map(|x| {
        let part = (x % FEATURE) as f64 / FEATURE as f64;
        part * part * (3.0 - 2.0 * part)
    });
    let mut sum = 0.0;
    for corner in 0..8 {
        let [x, y, z] = [0, 1, 2].map(|axis| cell[axis] + (corner >> axis & 1));
        let weight = |axis: usize| if corner >> axis & 1 == 1 { part[axis] } else { 1.0 - part[axis] };
        let value = f64::from(unit(hash(x ^ hash(y ^ hash(z ^ hash(seed)))))) * 2.0 - 1.0;
        sum += weight(0) * weight(1) * weight(2) * value;
    }
    sum
}

#[cfg(test)]
mod tests {
    use mobula_core::RayPacket;
    use mobula_core::bvh::{Bvh, Serial};
    use mobula_core::glam::Vec3;
    use mobula_core::leaf::TriangleBlock;
    use mobula_core::simd::AnyToken;
    use mobula_core::traverse;
    use mobula_core::volume::{GridField, IsoTree, Layout, Ranges};

    use super::*;

    /// An octahedron whose faces are divided, on a sphere of radius 2 around a point.
    fn ball() -> Triangles {
        let mut faces = Vec::new();
        for signs in 0..8 {
            let axis = |k: usize| {
                let mut corner = Vec3::ZERO;
                corner[k] = if signs >> k & 1 == 1 { -1.0 } else { 1.0 };
                corner
            };
            // Each reflection turns it over.
            let turned = u32::count_ones(signs) % 2 == 1;
            let [a, b, c] = [axis(0), axis(1), axis(2)];
            faces.push(if turned { [a, c, b] } else { [a, b, c] });
        }
        for _ in 0..5 {
            let divide = |[a, b, c]: [Vec3; 3]| {
                let [ab, bc, ca] = [(a + b).normalize(), (b + c).normalize(), (c + a).normalize()];
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            };
            faces = faces.into_iter().flat_map(divide).collect();
        }
        let mut ball = Triangles::default();
        for (i, face) in faces.iter().enumerate() {
            ball.positions.extend(face.map(|corner| (corner * 2.0 + Vec3::new(0.3, -5.0, 11.0)).to_array()));
            ball.indices.push([0, 1, 2].map(|k| (3 * i + k) as u32));
        }
        ball
    }

    const SETTINGS: Settings = Settings { size: 48, cuts: 4, noise: 0.0, seed: 1 };

    fn voxels(mesh: &Triangles, settings: Settings) -> (Place, Vec<u16>, Report) {
        let place = place(mesh, settings.size).unwrap();
        let mut voxels = Vec::new();
        let report = voxelise(mesh, &place, &settings, |slice| {
            voxels.extend_from_slice(slice);
            Ok(())
        });
        (place, voxels, report.unwrap())
    }

    fn volume(mesh: &Triangles) -> f64 {
        let corners = |i| mesh.corners(i).map(|corner| Vec3::from(corner).as_dvec3());
        (0..mesh.indices.len()).map(corners).map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum()
    }

    #[test]
    fn what_is_inside_adds_up() {
        let ball = ball();
        let (place, found, report) = voxels(&ball, SETTINGS);
        assert_eq!((place.dims, report.odd), ([48; 3], 0));
        let inside = report.inside * place.spacing.powi(3);
        assert!((inside / volume(&ball) - 1.0).abs() < 2e-3, "{inside} for {}", volume(&ball));
        // Whichever way triangles are turned, and twice the same.
        let mut turned = ball.clone();
        turned.indices.iter_mut().for_each(|corners| corners.swap(0, 1));
        assert_eq!(voxels(&turned, SETTINGS).1, found);
        let mut twice = ball.clone();
        twice.indices.extend(ball.indices);
        assert_eq!(voxels(&twice, SETTINGS).1, found);
    }

    #[test]
    fn the_surface_is_where_the_mesh_is() {
        let mesh = ball();
        let (place, voxels, _) = voxels(&mesh, Settings { noise: 200.0, ..SETTINGS });
        let layout = Layout::new(place.dims).unwrap();
        let ranges = Ranges::new(&layout, &voxels, &Serial);
        let field = GridField { voxels: &voxels, layout: &layout, ranges: &ranges };
        let iso = [SURFACE as f32];
        let tree = IsoTree::new(&field, &iso);
        let index = |p: [f32; 3]| [0, 1, 2].map(|k| ((f64::from(p[k]) - place.origin[k]) / place.spacing) as f32);
        let bvh: Bvh<TriangleBlock> = Bvh::triangles(mesh.indices.len(), 0, &Serial, |i| mesh.corners(i).map(index));
        let token = AnyToken::detect();
        let mut random = 1;
        let mut number = || {
            random = hash(random);
            unit(random)
        };
        let mut sum = 0.0;
        for _ in 0..40 {
            let mut packets = [RayPacket::<64>::default(), RayPacket::<64>::default()];
            packets.iter_mut().for_each(|packet| packet.reset(0..64));
            for i in 0..64 {
                let [from, to] = [200.0, 30.0]
                    .map(|size| Vec3::splat(23.5) + size * (Vec3::new(number(), number(), number()) - 0.5));
                // From outside, to a point that may be inside, never grazing.
                let from = Vec3::splat(23.5) + (from - 23.5).normalize() * 60.0;
                let to = Vec3::splat(23.5) + (to - 23.5).normalize_or_zero() * 12.0;
                packets.iter_mut().for_each(|packet| packet.set_ray(i, from, (to - from).normalize()));
            }
            traverse::intersect(&tree, token, &mut packets[0]);
            bvh.intersect(token, &mut packets[1]);
            for i in 0..64 {
                let off = packets[0].t_max[i] - packets[1].t_max[i];
                assert!(off.abs() < 0.3, "ray {i} is off by {off} voxels");
                sum += off;
            }
        }
        assert!((sum / 2560.0).abs() < 0.03, "off by {} in the mean", sum / 2560.0);
    }

    #[test]
    fn sheets_have_a_thickness() {
        let corners = [[0.0, 0.0, 0.0], [20.0, 0.0, 0.0], [20.0, 20.0, 0.0], [0.0, 20.0, 0.0]];
        let mut sheet = Triangles { positions: corners.to_vec(), indices: vec![[0, 1, 2], [0, 2, 3]] };
        sheet.indices.extend([[1, 0, 2], [0, 3, 2]]);
        // Something that gives the grid its size.
        sheet.positions.extend([[0.0, 0.0, 40.0], [1.0, 0.0, 40.0], [0.0, 1.0, 40.0], [0.0, 0.0, 39.0]]);
        sheet.indices.extend([[4, 5, 6], [4, 6, 7], [4, 7, 5], [7, 6, 5]]);
        let (place, found, report) = voxels(&sheet, SETTINGS);
        assert_eq!(report.odd, 0);
        let [nx, ny, nz] = place.dims;
        let column: f64 =
            (0..nz).map(|z| (f64::from(found[(z * ny + ny / 2) * nx + nx / 2]) - OUTSIDE) / (INSIDE - OUTSIDE)).sum();
        assert!((1.49..1.51).contains(&column), "{column} voxels");
        assert_eq!(distance([5.0, 5.0, 3.0], &[[0.0; 3], [20.0, 0.0, 0.0], [0.0, 20.0, 0.0]]), 3.0);
        assert_eq!(distance([-3.0, -4.0, 0.0], &[[0.0; 3], [20.0, 0.0, 0.0], [0.0, 20.0, 0.0]]), 5.0);
        assert_eq!(distance([5.0, -4.0, 3.0], &[[0.0; 3], [20.0, 0.0, 0.0], [0.0, 20.0, 0.0]]), 5.0);
    }

    #[test]
    fn holes_spoil_only_their_rows() {
        let mut mesh = ball();
        mesh.indices.swap_remove(100);
        let (place, found, report) = voxels(&mesh, SETTINGS);
        assert!(report.odd > 0 && report.odd * 100 < report.rows, "{report:?}");
        let inside = report.inside * place.spacing.powi(3);
        assert!((inside / volume(&ball()) - 1.0).abs() < 0.02, "{inside}");
        assert!(found.iter().all(|&voxel| voxel <= INSIDE as u16));
    }

    #[test]
    fn noise_is_smooth_and_seeded() {
        let row = |seed| (0..200).map(|x| noise([x, 3, 5], seed)).collect::<Vec<_>>();
        let values = row(1);
        assert!(values.windows(2).all(|pair| (pair[0] - pair[1]).abs() < 0.5));
        assert!(values.iter().all(|value| value.abs() <= 1.0) && values.iter().any(|value| value.abs() > 0.3));
        assert!(row(1) == values && row(2) != values);
    }

    #[test]
    fn nothing_has_no_place() {
        assert_eq!(place(&Triangles::default(), 48), None);
        let point = Triangles { positions: vec![[1.0; 3]], indices: vec![[0; 3]] };
        assert_eq!(place(&point, 48), None);
    }
}
