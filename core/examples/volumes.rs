//! Iso-surfaces of volumes, without the engine: cycles of the time stamp counter a ray, and a sum over what is found, which is the same
//! whatever is only made faster. `cargo run --release -p mobula-core --example volumes -- [SCENE] [LEVEL] [KIND]`

use glam::Vec3;
use mobula_core::bvh::Serial;
use mobula_core::simd::{AnyToken, clock};
use mobula_core::volume::{Field, GridField, IsoTree, Layout, Ranges, Voxel};
use mobula_core::{AnyHitPacket, RayPacket, glam, traverse};

/// Samples along each side.
const SIDE: usize = 256;
/// Rays of a packet.
const WIDTH: usize = 256;
/// What is traced.
const SCENES: [&str; 2] = ["clouds", "gyroid"];
/// Rays of a camera, rays from what these hit to a light, and rays from there anywhere: any hit, and the closest.
const KINDS: [&str; 4] = ["primary", "shadow", "sky", "bounce"];
/// Passes.
const PASSES: usize = 8;

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let level = words.iter().find_map(|word| word.parse().ok());
    let token = level.map_or(Ok(AnyToken::detect()), AnyToken::for_level).expect("a level of this machine");
    let wanted = |names: &[&str], name: &str| {
        words.iter().any(|word| word == name) || !words.iter().any(|word| names.contains(&word.as_str()))
    };
    let kinds = KINDS.map(|kind| wanted(&KINDS, kind));
    print!("{:<10}{:>8}", "scene", "level");
    KINDS.iter().for_each(|kind| print!("{kind:>10}"));
    println!();
    if wanted(&SCENES, SCENES[0]) {
        scene_of(SCENES[0], token, 1024, 0.5, noise, kinds);
    }
    if wanted(&SCENES, SCENES[1]) {
        scene_of(SCENES[1], token, 512, 32700.0, |at| (gyroid(at) * 65535.0) as u16, kinds);
    }
}

fn scene_of<V: Voxel>(
    name: &str,
    token: AnyToken,
    pixels: usize,
    value: f32,
    voxel: impl Fn([f32; 3]) -> V,
    kinds: [bool; 4],
) {
    let at = |i: usize| i as f32 / (SIDE - 1) as f32;
    let voxels: Vec<V> =
        (0..SIDE.pow(3)).map(|i| voxel([at(i % SIDE), at(i / SIDE % SIDE), at(i / SIDE.pow(2))])).collect();
    let layout = Layout::new([SIDE; 3]).expect("a small grid");
    let ranges = Ranges::new(&layout, &voxels, &Serial);
    let field = GridField { voxels: &voxels, layout: &layout, ranges: &ranges };
    let primary = camera(pixels);
    let (_, distances) = closest(&field, token, value, &primary);
    // From just before the surfaces.
    let hits = primary.iter().zip(&distances).filter(|(_, t)| t.is_finite());
    let points: Vec<Vec3> = hits.map(|(ray, t)| ray.0 + ray.1 * (t * 0.9999)).collect();
    let light = Vec3::new(0.5, 3.0, 2.5) * (SIDE - 1) as f32;
    let shadow: Rays = points.iter().map(|&point| (point, light - point)).collect();
    let mut seed = 0;
    let scattered: Rays = points.iter().map(|&point| (point, direction(&mut seed))).collect();
    print!("{name:<10}{:>8}", token.level().to_string());
    let mut sum = 0;
    for (kind, rays) in [&primary, &shadow, &scattered, &scattered].into_iter().enumerate() {
        let pass = |_| match kind {
            0 | 3 => closest(&field, token, value, rays),
            _ => any(&field, token, value, rays),
        };
        let passes = if kinds[kind] { PASSES } else { 0 };
        // The least that each packet took: what disturbs the machine disturbs a few of them.
        let (mut least, mut found) = (Vec::new(), Vec::new());
        for (cycles, distances) in (0..passes).map(pass) {
            least.resize(cycles.len(), u64::MAX);
            least.iter_mut().zip(cycles).for_each(|(least, cycles)| *least = cycles.min(*least));
            found = distances;
        }
        print!("{:>10.1}", least.iter().sum::<u64>() as f64 / rays.len() as f64);
        sum ^= checksum(&found).rotate_left(7 * kind as u32);
    }
    println!("   {} hits, sum {sum:016x}", shadow.len());
}

type Rays = Vec<(Vec3, Vec3)>;

fn closest(field: &dyn Field, token: AnyToken, value: f32, rays: &Rays) -> (Vec<u64>, Vec<f32>) {
    let (values, mut cycles, mut found) = ([value], Vec::new(), Vec::new());
    let tree = IsoTree::new(field, &values);
    let mut packet = RayPacket::<WIDTH>::default();
    for rays in rays.chunks(WIDTH) {
        packet.reset(0..rays.len());
        rays.iter().enumerate().for_each(|(i, &(origin, direction))| packet.set_ray(i, origin, direction));
        if rays.iter().all(|ray| ray.0 == rays[0].0) {
            packet.set_common_origin(rays[0].0);
        }
        let start = clock::ticks();
        traverse::intersect(&tree, token, &mut packet);
        cycles.push(clock::ticks() - start);
        found.extend_from_slice(&packet.t_max[..rays.len()]);
    }
    (cycles, found)
}

fn any(field: &dyn Field, token: AnyToken, value: f32, rays: &Rays) -> (Vec<u64>, Vec<f32>) {
    let (values, mut cycles, mut found) = ([value], Vec::new(), Vec::new());
    let tree = IsoTree::new(field, &values);
    let mut packet = AnyHitPacket::<WIDTH>::default();
    for rays in rays.chunks(WIDTH) {
        packet.reset(0..rays.len());
        rays.iter().enumerate().for_each(|(i, &(origin, direction))| packet.set_ray(i, origin, direction));
        let start = clock::ticks();
        traverse::occlude(&tree, token, &mut packet, None);
        cycles.push(clock::ticks() - start);
        found.extend_from_slice(&packet.t_max[..rays.len()]);
    }
    (cycles, found)
}

fn checksum(found: &[f32]) -> u64 {
    found.iter().fold(0xcbf2_9ce4_8422_2325, |sum: u64, t| (sum ^ u64::from(t.to_bits())).wrapping_mul(0x100_0000_01b3))
}

/// Rays of a pinhole camera through tiles of 16 x 16 pixels, each in groups of 4 x 4.
fn camera(pixels: usize) -> Rays {
    let (eye, at) = (Vec3::new(1.7, 1.3, 2.4), Vec3::splat(0.5));
    let forward = (at - eye).normalize();
    let right = forward.cross(Vec3::Y).normalize();
    let up = right.cross(forward);
    let tiles = pixels / 16;
    let ray = |i: usize| {
        let (tile, group, pixel) = (i / 256, i / 16 % 16, i % 16);
        let x = tile % tiles * 16 + group % 4 * 4 + pixel % 4;
        let y = tile / tiles * 16 + group / 4 * 4 + pixel / 4;
        let [x, y] = [x, y].map(|x| (2.0 * (x as f32 + 0.5) / pixels as f32 - 1.0) * 0.30);
        (eye * (SIDE - 1) as f32, forward + right * x - up * y)
    };
    (0..pixels * pixels).map(ray).collect()
}

/// A direction anywhere.
fn direction(seed: &mut u32) -> Vec3 {
    loop {
        let [x, y, z] = [0; 3].map(|_| {
            *seed += 1;
            2.0 * lattice(*seed as i32, 1, 2, 3) - 1.0
        });
        let at = Vec3::new(x, y, z);
        if at.length_squared() <= 1.0 {
            return at;
        }
    }
}

/// A gyroid with noise on it.
fn gyroid(at: [f32; 3]) -> f32 {
    let [a, b, c] = at.map(|x| 4.0 * std::f32::consts::TAU * x);
    let gyroid = a.sin() * b.cos() + b.sin() * c.cos() + c.sin() * a.cos();
    0.5 + 0.15 * gyroid + 0.12 * (noise(at) - 0.47)
}

/// Value noise: amplitudes 1/2, 1/4, ... at frequencies 6, 12, ...
fn noise(at: [f32; 3]) -> f32 {
    (0..4).map(|octave| smoothed(at.map(|x| x * 6.0 * (1 << octave) as f32), octave) * 0.5 / (1 << octave) as f32).sum()
}

fn smoothed(at: [f32; 3], octave: i32) -> f32 {
    let low = at.map(|x| x.floor() as i32);
    let weights = at.map(|x| {
        let f = x - x.floor();
        f * f * (3.0 - 2.0 * f)
    });
    (0..8_i32)
        .map(|corner| {
            let [x, y, z] = [0, 1, 2].map(|axis| corner >> axis & 1);
            let weight = |axis: usize, far: i32| if far == 1 { weights[axis] } else { 1.0 - weights[axis] };
            lattice(low[0] + x, low[1] + y, low[2] + z, octave) * weight(0, x) * weight(1, y) * weight(2, z)
        })
        .sum()
}

/// A random number in `[0, 1)` at a point of a lattice.
fn lattice(x: i32, y: i32, z: i32, octave: i32) -> f32 {
    let factors = [0x8da6_b343, 0xd816_3841, 0xcb1a_b31f, 0x1656_67b1];
    let mut h = [x, y, z, octave].iter().zip(factors).fold(0, |h: u32, (&x, by)| h ^ (x as u32).wrapping_mul(by));
    h = (h ^ h >> 13).wrapping_mul(0x9e37_79b1);
    h = (h ^ h >> 15).wrapping_mul(0x85eb_ca6b);
    ((h ^ h >> 13) >> 8) as f32 / (1 << 24) as f32
}
