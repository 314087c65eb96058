//! Volumes made by arithmetic.

use std::ops::Range;
use std::sync::Arc;

use super::mixed::mixed;
use crate::volume::{Grid, GridPlace, Volume};

/// Samples along each side.
const SIDE: usize = 256;

/// Clouds: four octaves of value noise, in the unit cube, as `f32`.
pub fn clouds() -> Volume {
    let place = GridPlace::with_spacing([1.0 / (SIDE - 1) as f64; 3]);
    volume("clouds", place, sampled(|[x, y, z]| noise(x, y, z)))
}

/// A gyroid with noise on it, in the unit cube, as `u16`.
pub fn gyroid() -> Volume {
    let place = GridPlace::with_spacing([1.0 / (SIDE - 1) as f64; 3]);
    let value = |[x, y, z]: [f32; 3]| {
        // The sine by a parabola, and its correction: no library is the same everywhere.
        let sine = |turns: f32| {
            let t = turns - (turns + 0.5).floor();
            let y = 8.0 * t - 16.0 * t * t.abs();
            0.775 * y + 0.225 * y * y.abs()
        };
        let [a, b, c] = [4.0 * x, 4.0 * y, 4.0 * z];
        let gyroid = sine(a) * sine(b + 0.25) + sine(b) * sine(c + 0.25) + sine(c) * sine(a + 0.25);
        let value = 0.5 + 0.15 * gyroid + 0.12 * (noise(x, y, z) - 0.47);
        (value * 65535.0) as u16
    };
    volume("gyroid", place, sampled(value))
}

fn volume<V>(name: &str, place: GridPlace, voxels: Vec<V>) -> Volume
where
    crate::volume::Voxels: From<Vec<V>>,
{
    let grid = Grid::new([SIDE; 3], voxels.into(), place, [1.0, 0.0]).expect("a sound grid");
    Volume { name: name.to_owned(), steps: vec![Arc::new(grid)] }
}

/// The values of a function of the unit cube at all samples.
fn sampled<V: Send>(value: impl Fn([f32; 3]) -> V + Sync) -> Vec<V> {
    let at = |i: usize| i as f32 / (SIDE - 1) as f32;
    let slice = |z: usize| {
        let value = &value;
        (0..SIDE).flat_map(move |y| (0..SIDE).map(move |x| value([at(x), at(y), at(z)])))
    };
    let part = |slices: Range<usize>| slices.flat_map(slice).collect::<Vec<_>>();
    // Two threads, where there are two; each makes a half.
    std::thread::scope(|scope| {
        let second = std::thread::Builder::new().spawn_scoped(scope, || part(SIDE / 2..SIDE));
        let mut all = part(0..SIDE / 2);
        match second {
            Ok(second) => all.extend(second.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))),
            Err(_) => all.extend(part(SIDE / 2..SIDE)),
        }
        all
    })
}

/// Value noise: amplitudes 1/2, 1/4, ... at frequencies 6, 12, ...
fn noise(x: f32, y: f32, z: f32) -> f32 {
    let (mut sum, mut amplitude, mut frequency) = (0.0, 0.5, 6.0);
    for octave in 0..4 {
        sum += amplitude * smoothed(x * frequency, y * frequency, z * frequency, octave);
        (amplitude, frequency) = (amplitude * 0.5, frequency * 2.0);
    }
    sum
}

fn smoothed(x: f32, y: f32, z: f32, octave: u32) -> f32 {
    let (cell, weight) = ([x, y, z].map(|a| a.floor()), |a: f32| {
        let f = a - a.floor();
        f * f * (3.0 - 2.0 * f)
    });
    let [ix, iy, iz] = cell.map(|a| a as i32);
    let mix = |a: f32, b: f32, f: f32| a + (b - a) * f;
    let row = |dy: i32, dz: i32| {
        mix(lattice(ix, iy + dy, iz + dz, octave), lattice(ix + 1, iy + dy, iz + dz, octave), weight(x))
    };
    mix(mix(row(0, 0), row(1, 0), weight(y)), mix(row(0, 1), row(1, 1), weight(y)), weight(z))
}

/// A random number in `[0, 1)` at a point of a lattice.
fn lattice(x: i32, y: i32, z: i32, octave: u32) -> f32 {
    mixed(
        (x as u32).wrapping_mul(0x8da6_b343)
            ^ (y as u32).wrapping_mul(0xd816_3841)
            ^ (z as u32).wrapping_mul(0xcb1a_b31f)
            ^ octave.wrapping_mul(0x1656_67b1),
    )
}
