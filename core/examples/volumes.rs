//! Iso-surfaces of volumes, without the engine: cycles of the time stamp counter a ray, and a sum over what is found, which is the same
//! whatever is only made faster. `cargo run --release -p mobula-core --example volumes -- [SCENE] [LEVEL]`

use glam::Vec3;
use mobula_core::bvh::Serial;
use mobula_core::simd::{AnyToken, clock};
use mobula_core::volume::{Field, GridField, IsoTree, Layout, Ranges, Voxel};
use mobula_core::{AnyHitPacket, RayPacket, glam, traverse};

/// Samples along each side.
const SIDE: usize = 256;
/// Rays of a packet.
const WIDTH: usize = 256;
/// Passes, of which the fastest counts.
const PASSES: usize = 5;

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let level = words.iter().find_map(|word| word.parse().ok());
    let token = level.map_or(Ok(AnyToken::detect()), AnyToken::for_level).expect("a level of this machine");
    let scene = words.iter().find(|word| word.parse::<mobula_core::simd::Level>().is_err()).map_or("", String::as_str);
    println!("{:<10}{:>8}{:>10}{:>10}{:>10}{:>10}", "scene", "level", "primary", "shadow", "sky", "bounce");
    if "clouds".contains(scene) {
        scene_of("clouds", token, 1024, 0.5, noise);
    }
    if "gyroid".contains(scene) {
        scene_of("gyroid", token, 512, 32700.0, |at| (gyroid(at) * 65535.0) as u16);
    }
}

fn scene_of<V: Voxel>(name: &str, token: AnyToken, pixels: usize, value: f32, voxel: impl Fn([f32; 3]) -> V) {
    let at = |i: usize| i as f32 / (SIDE - 1) as f32;
    let voxels: Vec<V> =
        (0..SIDE.pow(3)).map(|i| voxel([at(i % SIDE), at(i / SIDE % SIDE), at(i / SIDE.pow(2))])).collect();
    let layout = Layout::new([SIDE; 3]).expect("a small grid");
    let ranges = Ranges::new(&layout, &voxels, &Serial);
    let field = GridField { voxels: &voxels, layout: &layout, ranges: &ranges };
    let primary = camera(pixels);
    let hits = (0..PASSES).map(|_| closest(&field, token, value, &primary)).min_by_key(|pass| pass.0).expect("a pass");
    // From just before the surfaces.
    let points =
        primary.iter().zip(&hits.1).filter(|(_, t)| t.is_finite()).map(|(ray, t)| ray.0 + ray.1 * (t * 0.9999));
    let light = Vec3::new(0.5, 3.0, 2.5) * (SIDE - 1) as f32;
    let shadow: Vec<_> = points.clone().map(|point| (point, light - point)).collect();
    let mut seed = 0;
    let scattered: Vec<_> = points.map(|point| (point, direction(&mut seed))).collect();
    let (mut cycles, mut sum) = (vec![hits.0 as f64 / primary.len() as f64], checksum(&hits.1));
    for rays in [&shadow, &scattered] {
        let pass = (0..PASSES).map(|_| any(&field, token, value, rays)).min_by_key(|pass| pass.0).expect("a pass");
        cycles.push(pass.0 as f64 / rays.len() as f64);
        sum ^= checksum(&pass.1).rotate_left(7);
    }
    let pass =
        (0..PASSES).map(|_| closest(&field, token, value, &scattered)).min_by_key(|pass| pass.0).expect("a pass");
    cycles.push(pass.0 as f64 / scattered.len() as f64);
    sum ^= checksum(&pass.1).rotate_left(14);
    print!("{name:<10}{:>8}", token.level().to_string());
    cycles.iter().for_each(|cycles| print!("{cycles:>10.1}"));
    println!("   {} hits, sum {sum:016x}", shadow.len());
}

type Rays = Vec<(Vec3, Vec3)>;

fn closest(field: &dyn Field, token: AnyToken, value: f32, rays: &Rays) -> (u64, Vec<f32>) {
    let (values, mut cycles, mut found) = ([value], 0, Vec::new());
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
        cycles += clock::ticks() - start;
        found.extend_from_slice(&packet.t_max[..rays.len()]);
    }
    (cycles, found)
}

fn any(field: &dyn Field, token: AnyToken, value: f32, rays: &Rays) -> (u64, Vec<f32>) {
    let (values, mut cycles, mut found) = ([value], 0, Vec::new());
    let tree = IsoTree::new(field, &values);
    let mut packet = AnyHitPacket::<WIDTH>::default();
    for rays in rays.chunks(WIDTH) {
        packet.reset(0..rays.len());
        rays.iter().enumerate().for_each(|(i, &(origin, direction))| packet.set_ray(i, origin, direction));
        let start = clock::ticks();
        traverse::occlude(&tree, token, &mut packet, None);
        cycles += clock::ticks() - start;
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
