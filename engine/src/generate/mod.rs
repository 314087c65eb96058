//! Scenes made by arithmetic: terrains, a hall, a cube of spheres, volumes, for measuring and testing.
//!
//! Only `+ - * /` and square roots, never fused, so that every machine makes the same scene bit for bit.

mod mixed;
pub mod volumes;

use glam::Vec3;

use mixed::mixed;

use crate::geometry::{Mesh, MeshGroup, Spheres};
use crate::light::Point;
use crate::material::{Lambertian, Phong};
use crate::scene::SceneDescription;
use crate::view::{Up, View};
use crate::volume::Volume;

/// What the name of a generated scene starts with.
pub const PREFIX: &str = "gen:";

/// Names of the generated scenes, with a line about each.
pub const SCENES: [(&str, &str); 8] = [
    ("gen:terr20k", "a terrain of 20,000 triangles"),
    ("gen:terr245k", "a terrain of 245,000 triangles"),
    ("gen:terr1m", "a terrain with 1,000 balls, 1,036,288 triangles"),
    ("gen:terr10m", "a terrain with 10,000 balls, 10,240,000 triangles"),
    ("gen:atrium", "a hall with galleries and columns, 114,704 triangles"),
    ("gen:csafe", "2,800,000 spheres in a cube"),
    ("gen:clouds", "a volume of 256 x 256 x 256 floats"),
    ("gen:gyroid", "a volume of 256 x 256 x 256 16-bit numbers"),
];

/// Makes the scene of one of the names in [`SCENES`]; `None` for other names.
pub fn generate(name: &str) -> Option<SceneDescription> {
    let mut scene = match name.strip_prefix(PREFIX)? {
        "terr20k" => terrain_scene(100, 0),
        "terr245k" => terrain_scene(350, 0),
        "terr1m" => terrain_scene(512, 1000),
        "terr10m" => terrain_scene(1600, 10_000),
        "atrium" => atrium_scene(),
        "csafe" => csafe_scene(),
        "clouds" => volume_scene(volumes::clouds()),
        "gyroid" => volume_scene(volumes::gyroid()),
        _ => return None,
    };
    scene.name = name.to_owned();
    Some(scene)
}

/// Asks for the memory that a scene takes while it is made, and gives it back. False if the system has none.
pub fn has_memory(name: &str) -> bool {
    /// Bytes of a primitive, in lists that have room for twice as many while they grow.
    const EACH: usize = 80;
    let primitives = match name.strip_prefix(PREFIX) {
        Some("terr1m") => 1_036_288,
        Some("terr10m") => 10_240_000,
        Some("csafe") => 2_800_000,
        Some("clouds" | "gyroid") => 2_000_000,
        _ => 250_000,
    };
    Vec::<u8>::new().try_reserve_exact(primitives * EACH).is_ok()
}

/// A view whose vertical field of view has the tangent `th` at its half.
fn view(eye: [f32; 3], at: [f32; 3], th: f32) -> View {
    View { eye: eye.into(), at: at.into(), up: Vec3::Y, fov: 2.0 * th.atan().to_degrees() }
}

fn point_light(position: [f32; 3]) -> Point {
    Point { position: position.into(), color: Vec3::ONE, falloff: false }
}

fn terrain_scene(grid: u32, balls: u32) -> SceneDescription {
    let mut scene = SceneDescription::default();
    let ground = scene.add_material("ground", Lambertian::new(Vec3::new(0.42, 0.38, 0.28)));
    let mut mesh = terrain(grid, balls);
    mesh.material = ground;
    if let Some(first) = mesh.groups.get(1).map(|group| group.first as usize) {
        let ball = Phong {
            diffuse: Vec3::new(0.65, 0.16, 0.10),
            specular: Vec3::splat(0.3),
            shininess: 60.0,
            ..Phong::default()
        };
        let ball = scene.add_material("balls", ball);
        mesh.materials = vec![ground; first];
        mesh.materials.resize(mesh.triangles.len(), ball);
    }
    scene.add(mesh);
    scene.add_light(point_light([25.0, 40.0, 80.0]));
    scene.view = Some(view([50.0, 45.0, 5.0], [50.0, 5.0, 45.0], 0.4));
    scene
}

fn atrium_scene() -> SceneDescription {
    let mut scene = SceneDescription::default();
    let mut mesh = atrium();
    let colors = [
        ("walls", Vec3::new(0.70, 0.66, 0.58)),
        ("galleries", Vec3::new(0.50, 0.36, 0.24)),
        ("columns", Vec3::new(0.78, 0.76, 0.72)),
        ("balls", Vec3::new(0.25, 0.40, 0.55)),
    ];
    for (group, (name, diffuse)) in mesh.groups.iter().zip(colors) {
        let material = scene.add_material(name, Lambertian::new(diffuse));
        mesh.materials.resize((group.first + group.count) as usize, material);
    }
    scene.add(mesh);
    scene.add_light(point_light([30.0, 12.0, 12.0]));
    scene.view = Some(view([4.0, 5.0, 12.0], [40.0, 5.5, 12.5], 0.7));
    scene
}

fn csafe_scene() -> SceneDescription {
    let mut scene = SceneDescription::default();
    let grain = scene.add_material("grain", Lambertian::new(Vec3::new(0.75, 0.55, 0.30)));
    let mut spheres = csafe(2_800_000);
    spheres.material = grain;
    scene.add(spheres);
    scene.add_light(point_light([0.5, 3.0, 2.5]));
    scene.view = Some(view([1.7, 1.3, 2.4], [0.5, 0.5, 0.5], 0.30));
    scene
}

fn volume_scene(volume: Volume) -> SceneDescription {
    let mut scene = SceneDescription::default();
    scene.volumes.push(volume);
    scene.up = Some(Up::Y);
    scene.add_light(point_light([0.5, 3.0, 2.5]));
    scene.view = Some(view([1.7, 1.3, 2.4], [0.5, 0.5, 0.5], 0.30));
    scene
}

/// Random numbers in `[0, 1)` from PCG32 (XSH-RR), its state set directly.
#[derive(Clone, Debug)]
pub struct Pcg32(pub u64);

impl Pcg32 {
    /// The next 32 bits.
    pub fn bits(&mut self) -> u32 {
        let state = self.0;
        self.0 = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((((state >> 18) ^ state) >> 27) as u32).rotate_right((state >> 59) as u32)
    }

    /// The next number in `[0, 1)`, a multiple of 2^-24.
    pub fn unit(&mut self) -> f32 {
        (self.bits() >> 8) as f32 * (1.0 / 16_777_216.0)
    }
}

/// A random number in `[0, 1)` at a point of a lattice.
fn lattice(x: i32, z: i32, octave: u32) -> f32 {
    mixed(
        (x as u32).wrapping_mul(0x8da6_b343) ^ (z as u32).wrapping_mul(0xd816_3841) ^ octave.wrapping_mul(0xcb1a_b31f),
    )
}

fn noise(x: f32, z: f32, octave: u32) -> f32 {
    let (floor_x, floor_z) = (x.floor(), z.floor());
    let smooth = |f: f32| f * f * (3.0 - 2.0 * f);
    let (sx, sz) = (smooth(x - floor_x), smooth(z - floor_z));
    let (ix, iz) = (floor_x as i32, floor_z as i32);
    let row = |iz: i32| {
        let (a, b) = (lattice(ix, iz, octave), lattice(ix + 1, iz, octave));
        a + (b - a) * sx
    };
    let (a, b) = (row(iz), row(iz + 1));
    a + (b - a) * sz
}

/// Height of the terrain.
fn height(x: f32, z: f32) -> f32 {
    let (mut sum, mut amplitude, mut frequency) = (0.0, 14.0, 0.06);
    for octave in 0..7 {
        sum += amplitude * noise(x * frequency, z * frequency, octave);
        amplitude *= 0.5;
        frequency *= 2.0;
    }
    sum
}

/// A terrain of `2 grid^2` triangles over `[0, 100]^2`, with `balls` tessellated spheres of 512 triangles on and above it.
///
/// # Panics
/// If its vertices do not fit 32-bit indices.
pub fn terrain(grid: u32, balls: u32) -> Mesh {
    let mut mesh = Mesh { name: "terrain".into(), ..Mesh::default() };
    let step = 100.0 / grid as f32;
    for j in 0..=grid {
        for i in 0..=grid {
            let (x, z) = (i as f32 * step, j as f32 * step);
            mesh.positions.push([x, height(x, z), z]);
        }
    }
    let at = |i: u32, j: u32| j * (grid + 1) + i;
    for j in 0..grid {
        for i in 0..grid {
            let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i, j + 1), at(i + 1, j + 1));
            mesh.triangles.push([a, c, b]);
            mesh.triangles.push([b, c, d]);
        }
    }
    close_group(&mut mesh, "ground");
    let mut random = Pcg32(42);
    for _ in 0..balls {
        let x = 2.0 + 96.0 * random.unit();
        let z = 2.0 + 96.0 * random.unit();
        let u = random.unit();
        let radius = 0.15 + 0.6 * u * u;
        let y = height(x, z) + radius * (0.5 + 3.0 * random.unit());
        ball(&mut mesh, Vec3::new(x, y, z), radius, 8);
    }
    if balls > 0 {
        close_group(&mut mesh, "balls");
    }
    mesh
}

/// A hall of 60 x 14 x 24 with galleries, two storeys of columns, and balls on the floor.
pub fn atrium() -> Mesh {
    let mut mesh = Mesh { name: "atrium".into(), ..Mesh::default() };
    let (x, y, z) = (Vec3::X, Vec3::Y, Vec3::Z);
    // Everything faces inwards.
    tiles(&mut mesh, Vec3::ZERO, z * 24.0, x * 60.0, [12, 30]);
    tiles(&mut mesh, y * 14.0, x * 60.0, z * 24.0, [15, 6]);
    tiles(&mut mesh, Vec3::ZERO, x * 60.0, y * 14.0, [15, 4]);
    tiles(&mut mesh, z * 24.0, y * 14.0, x * 60.0, [4, 15]);
    tiles(&mut mesh, Vec3::ZERO, y * 14.0, z * 24.0, [4, 4]);
    tiles(&mut mesh, x * 60.0, z * 24.0, y * 14.0, [4, 4]);
    close_group(&mut mesh, "walls");
    for (near, far, rail) in [(0.0, 5.0, 4.9), (19.0, 24.0, 19.1)] {
        block(&mut mesh, Vec3::new(0.0, 6.8, near), Vec3::new(60.0, 7.2, far));
        tiles(&mut mesh, Vec3::new(0.0, 7.2, rail), x * 60.0, y, [1, 1]);
    }
    close_group(&mut mesh, "galleries");
    for (bottom, top) in [(0.0, 6.8), (7.2, 14.0)] {
        for z in [4.3, 19.7] {
            for i in 0..14 {
                let x = 60.0 * (i as f32 + 0.5) / 14.0;
                column(&mut mesh, Vec3::new(x, bottom, z), top - bottom);
            }
        }
    }
    close_group(&mut mesh, "columns");
    let mut random = Pcg32(7);
    for _ in 0..60 {
        let radius = 0.3 + 0.5 * random.unit();
        let x = 2.0 + 56.0 * random.unit();
        let z = 6.0 + 12.0 * random.unit();
        ball(&mut mesh, Vec3::new(x, radius, z), radius, 12);
    }
    close_group(&mut mesh, "balls");
    mesh
}

/// `count` small spheres in the unit cube.
pub fn csafe(count: usize) -> Spheres {
    let mut spheres = Spheres { name: "csafe".into(), ..Spheres::default() };
    spheres.centers.reserve_exact(count);
    spheres.radii.reserve_exact(count);
    let mut random = Pcg32(2005);
    for _ in 0..count {
        spheres.centers.push([random.unit(), random.unit(), random.unit()]);
        spheres.radii.push(0.002 + 0.002 * random.unit());
    }
    spheres
}

/// Names the triangles since the last group.
fn close_group(mesh: &mut Mesh, name: &str) {
    let first = mesh.groups.last().map_or(0, |group| group.first + group.count);
    mesh.groups.push(MeshGroup { name: name.into(), first, count: mesh.triangles.len() as u32 - first });
}

/// Adds a vertex and returns its index.
fn vertex(mesh: &mut Mesh, position: Vec3) -> u32 {
    mesh.positions.push(position.into());
    u32::try_from(mesh.positions.len() - 1).expect("fewer than 2^32 vertices")
}

/// A parallelogram of `m x n` quads, facing `u x v`.
fn tiles(mesh: &mut Mesh, origin: Vec3, u: Vec3, v: Vec3, [m, n]: [u32; 2]) {
    let first = mesh.positions.len() as u32;
    for j in 0..=n {
        for i in 0..=m {
            vertex(mesh, origin + u * (i as f32 / m as f32) + v * (j as f32 / n as f32));
        }
    }
    let at = |i: u32, j: u32| first + j * (m + 1) + i;
    for j in 0..n {
        for i in 0..m {
            let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i, j + 1), at(i + 1, j + 1));
            mesh.triangles.push([a, b, d]);
            mesh.triangles.push([a, d, c]);
        }
    }
}

/// A box of 12 triangles, facing outwards.
fn block(mesh: &mut Mesh, low: Vec3, high: Vec3) {
    let size = high - low;
    let (x, y, z) = (Vec3::X * size.x, Vec3::Y * size.y, Vec3::Z * size.z);
    for (u, v) in [(x, y), (y, z), (z, x)] {
        tiles(mesh, low, v, u, [1, 1]);
        tiles(mesh, high, -u, -v, [1, 1]);
    }
}

/// A round column of 64 sides and 6 segments on a square base, under a square capital.
fn column(mesh: &mut Mesh, foot: Vec3, height: f32) {
    const SIDES: u32 = 64;
    const SEGMENTS: u32 = 6;
    const PLATE: f32 = 0.3;
    let corner = Vec3::new(0.5, 0.0, 0.5);
    let top = foot + Vec3::Y * height;
    block(mesh, foot - corner, foot + corner + Vec3::Y * PLATE);
    block(mesh, top - corner - Vec3::Y * PLATE, top + corner);
    let circle = circle(SIDES as usize);
    let first = mesh.positions.len() as u32;
    for segment in 0..=SEGMENTS {
        let y = PLATE + (height - 2.0 * PLATE) * (segment as f32 / SEGMENTS as f32);
        for (cos, sin) in &circle {
            vertex(mesh, foot + Vec3::new(0.4 * cos, y, 0.4 * sin));
        }
    }
    for segment in 0..SEGMENTS {
        for side in 0..SIDES {
            let next = (side + 1) % SIDES;
            let (low, high) = (first + segment * SIDES, first + (segment + 1) * SIDES);
            let (a, b, c, d) = (low + side, low + next, high + side, high + next);
            mesh.triangles.push([a, c, b]);
            mesh.triangles.push([b, c, d]);
        }
    }
}

/// `sides` points on the unit circle, a power of two from 4, by halving angles: library sines differ between machines.
fn circle(sides: usize) -> Vec<(f32, f32)> {
    let mut points = vec![(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)];
    while points.len() < sides {
        let n = points.len();
        points = (0..n)
            .flat_map(|i| {
                let ((ax, ay), (bx, by)) = (points[i], points[(i + 1) % n]);
                let (x, y): (f32, f32) = (ax + bx, ay + by);
                let length = (x * x + y * y).sqrt();
                [(ax, ay), (x / length, y / length)]
            })
            .collect();
    }
    points
}

/// A sphere: an octahedron whose 8 faces are cut into `n x n` triangles each, its vertices not shared between faces.
fn ball(mesh: &mut Mesh, center: Vec3, radius: f32, n: u32) {
    for face in 0..8 {
        let sign = |bit: u32| if face & bit == 0 { 1.0 } else { -1.0 };
        let (a, b, c) = (Vec3::X * sign(1), Vec3::Y * sign(2), Vec3::Z * sign(4));
        // An odd number of mirrored axes turns the face inside out.
        let (b, c) = if sign(1) * sign(2) * sign(4) > 0.0 { (b, c) } else { (c, b) };
        let first = mesh.positions.len() as u32;
        for j in 0..=n {
            for i in 0..=n - j {
                let (u, v) = (i as f32 / n as f32, j as f32 / n as f32);
                let p = a + (b - a) * u + (c - a) * v;
                let length = (p.x * p.x + p.y * p.y + p.z * p.z).sqrt();
                vertex(mesh, center + p / length * radius);
            }
        }
        // Row j starts after j rows of n + 1, n, ... vertices.
        let at = |i: u32, j: u32| first + j * (n + 1) - j * j.saturating_sub(1) / 2 + i;
        for j in 0..n {
            for i in 0..n - j {
                mesh.triangles.push([at(i, j), at(i + 1, j), at(i, j + 1)]);
                if i + 1 < n - j {
                    mesh.triangles.push([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// FNV-1a over the bits of all numbers.
    fn checksum(words: impl IntoIterator<Item = u32>) -> u64 {
        words
            .into_iter()
            .fold(0xcbf2_9ce4_8422_2325, |hash, word| (hash ^ u64::from(word)).wrapping_mul(0x0000_0100_0000_01b3))
    }

    fn mesh_checksum(mesh: &Mesh) -> u64 {
        let positions = mesh.positions.as_flattened().iter().map(|x| x.to_bits());
        checksum(positions.chain(mesh.triangles.as_flattened().iter().copied()))
    }

    #[test]
    fn counts() {
        assert_eq!(terrain(100, 0).triangles.len(), 20_000);
        assert_eq!(terrain(350, 0).triangles.len(), 245_000);
        assert_eq!(terrain(512, 1000).triangles.len(), 1_036_288);
        assert_eq!(terrain(1600, 10_000).triangles.len(), 10_240_000);
        assert_eq!(atrium().triangles.len(), 114_704);
        assert_eq!(csafe(1000).centers.len(), 1000);
        assert!(generate("gen:nothing").is_none() && generate("terr20k").is_none());
        for (name, _) in &SCENES[..2] {
            assert_eq!(generate(name).unwrap().name, *name);
        }
    }

    #[test]
    fn the_same_bits_everywhere() {
        assert_eq!(mesh_checksum(&terrain(100, 20)), TERRAIN);
        assert_eq!(mesh_checksum(&atrium()), ATRIUM);
        let spheres = csafe(10_000);
        let words = spheres.centers.as_flattened().iter().chain(&spheres.radii).map(|x| x.to_bits());
        assert_eq!(checksum(words), CSAFE);
    }
    const TERRAIN: u64 = 15168654087984924565;
    const ATRIUM: u64 = 12520199581463632775;
    const CSAFE: u64 = 14705843901391922337;

    #[test]
    fn the_random_numbers_are_pcg32() {
        // Computed with arbitrary precision.
        let mut random = Pcg32(42);
        assert_eq!([random.bits(), random.bits(), random.bits()], [0, 1_971_522_493, 242_089_394]);
    }

    #[test]
    fn balls_face_outwards_and_are_closed() {
        let mut mesh = Mesh::default();
        ball(&mut mesh, Vec3::new(3.0, 4.0, 5.0), 2.0, 8);
        assert_eq!(mesh.triangles.len(), 512);
        let mut volume = 0.0;
        for i in 0..512 {
            let [a, b, c] = mesh.corners(i).unwrap().map(|p| p - Vec3::new(3.0, 4.0, 5.0));
            let six = a.cross(b).dot(c);
            assert!(six > 0.0, "triangle {i}");
            volume += six / 6.0;
        }
        let sphere = 4.0 / 3.0 * std::f32::consts::PI * 8.0;
        assert!((0.95..1.0).contains(&(volume / sphere)), "{volume} of {sphere}");
        // Edges between faces meet exactly, though their vertices are not shared.
        let mut edges = std::collections::HashMap::new();
        for triangle in &mesh.triangles {
            for k in 0..3 {
                let [a, b] = [triangle[k], triangle[(k + 1) % 3]].map(|i| mesh.positions[i as usize].map(f32::to_bits));
                *edges.entry((a, b)).or_insert(0) += 1;
                *edges.entry((b, a)).or_insert(0) -= 1;
            }
        }
        assert!(edges.values().all(|&count| count == 0));
    }
}
