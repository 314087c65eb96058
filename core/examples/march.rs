//! What a step of a ray through a volume costs: `cargo run --release -p mobula-core --example march [LEVEL [CASE]]`.
//!
//! A volume of 256^3 samples of u16, all of it faintly visible so that no ray ends early and nothing is skipped, seen through 512 x 512
//! pixels in packets of 16 x 16. Steps are counted as the length of all ways, in cells, by the length of a step: that bricks are entered
//! and loaded is in the cost of a step. Cycles are those of the time stamp counter.

use std::time::Instant;

use mobula_core::bvh::Serial;
use mobula_core::kernel::classify::{Knot, Transfer};
use mobula_core::simd::{AnyToken, clock};
use mobula_core::volume::{
    Between, GridField, Layout, LightRows, Lighting, March, Marched, Passages, Ranges, Segments,
};

const SIDE: usize = 256;
const PIXELS: usize = 512;
const STEP: f32 = 0.5;

fn main() {
    let wave = |x: usize, by: f32| ((x as f32 * by).sin() + 1.0) * 8000.0;
    let value = |i: usize| (wave(i % SIDE, 0.11) + wave(i / SIDE % SIDE, 0.07) + wave(i / SIDE / SIDE, 0.13)) as u16;
    let voxels: Vec<u16> = (0..SIDE.pow(3)).map(value).collect();
    let layout = Layout::new([SIDE; 3]).expect("a grid of this size");
    let ranges = Ranges::new(&layout, &voxels, &Serial);
    let field = GridField { voxels: &voxels, layout: &layout, ranges: &ranges };
    let knot = |i: usize| Knot {
        value: 6000.0 * i as f32,
        color: [0.1 * i as f32, 0.5, 1.0 - 0.1 * i as f32],
        extinction: 1e-4 * (1 + i % 3) as f32,
    };
    let transfer = Transfer::new(&(0..9).map(knot).collect::<Vec<_>>());

    let (wanted, case) = (std::env::args().nth(1), std::env::args().nth(2));
    for token in
        AnyToken::available().filter(|token| wanted.as_ref().is_none_or(|name| *name == token.level().to_string()))
    {
        for (name, eye, lit) in
            [("near", 1.2, false), ("near, lit", 1.2, true), ("far", 4.0, false), ("far, lit", 4.0, true)]
                .into_iter()
                .filter(|(name, ..)| case.as_ref().is_none_or(|case| case == name))
        {
            let (mut best, mut sum) = ((f64::INFINITY, u64::MAX), 0.0);
            let mut cells = 0.0;
            for _ in 0..3 {
                let (start, ticks) = (Instant::now(), clock::ticks());
                (sum, cells) = frame(token, &field, &transfer, eye, lit);
                let found = (start.elapsed().as_secs_f64(), clock::ticks() - ticks);
                best = if found.0 < best.0 { found } else { best };
            }
            let steps = cells / f64::from(STEP);
            println!(
                "{:7} {name:10} {:6.1} cycles a step, {:6.1} Msteps/s, {:5.0} steps a ray, sum {sum:.3}",
                token.level(),
                best.1 as f64 / steps,
                steps / best.0 * 1e-6,
                steps / (PIXELS * PIXELS) as f64,
            );
        }
    }
}

/// Marches all rays of a frame. Returns the sum of what they see, and the length of their ways in cells.
fn frame(token: AnyToken, field: &GridField<'_, u16>, transfer: &Transfer, distance: f32, lit: bool) -> (f64, f64) {
    let to_cells = [[255.0, 0.0, 0.0, 127.5], [0.0, 255.0, 0.0, 127.5], [0.0, 0.0, 255.0, 127.5]];
    let eye = [0.3 * distance, 0.4 * distance, 0.87 * distance];
    let (mut passages, mut out) = (Box::<Passages>::default(), Box::<Marched>::default());
    let mut lighting = Lighting {
        ambient: [[0.2; 3], [0.1; 3]],
        up: [0.0, 255.0, 0.0],
        metric: [65025.0, 65025.0, 65025.0, 0.0, 0.0, 0.0],
        flat: 1e4,
        lights: vec![LightRows::default()],
    };
    for end in 0..2 {
        lighting.lights[0].towards[end][1] = mobula_core::Column::splat(255.0);
        lighting.lights[0].radiance[end] = [mobula_core::Column::splat(1.0); 3];
    }
    lighting.lights[0].squares = [mobula_core::Column::splat(1.0); 3];
    let (mut sum, mut cells) = (0.0, 0.0);
    for tile in 0..(PIXELS / 16) * (PIXELS / 16) {
        let mut directions = [[0.0; 256]; 3];
        for i in 0..256 {
            let (group, at) = (i / 16, i % 16);
            let x = tile % (PIXELS / 16) * 16 + group % 4 * 4 + at % 4;
            let y = tile / (PIXELS / 16) * 16 + group / 4 * 4 + at / 4;
            // Towards a point of the middle plane of the volume.
            let (u, v) = (x as f32 / PIXELS as f32 - 0.5, y as f32 / PIXELS as f32 - 0.5);
            let point = [0.94 * u, 0.9 * v, -0.33 * u - 0.41 * v];
            let way = [0, 1, 2].map(|axis| point[axis] - eye[axis]);
            let length = way.iter().map(|x| x * x).sum::<f32>().sqrt();
            for axis in 0..3 {
                directions[axis][i] = way[axis] / length;
            }
        }
        let segments = Segments {
            origins: [&[eye[0]; 256], &[eye[1]; 256], &[eye[2]; 256]],
            directions: [&directions[0], &directions[1], &directions[2]],
            t0: &[0.0; 256],
            t1: &[f32::INFINITY; 256],
        };
        if passages.enter(&segments, &to_cells, field.layout) {
            let lighting = lit.then_some(&lighting);
            let march = March { field, transfer, between: Between::Linear, step: STEP, lighting };
            token.run(march.task(&passages, &mut out));
            for i in 0..256 {
                cells += f64::from((passages.t1[i] - passages.t0[i]).max(0.0)) * 255.0;
                sum += f64::from(out.radiance[1][i] + out.transmittance[i]);
            }
        }
    }
    (sum / (PIXELS * PIXELS) as f64, cells)
}
