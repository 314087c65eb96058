//! Light through volumes: against the closed form where there is one, against small steps where there is none, and the same bits on
//! every path.

use mobula_core::bvh::Serial;
use mobula_core::kernel::classify::{Knot, Transfer};
use mobula_core::simd::AnyToken;
use mobula_core::volume::{
    Between, GridField, Layout, LightRows, Lighting, March, Marched, Passages, Ranges, Segments, Voxel, WIDTH,
};

const IDENTITY: [[f64; 4]; 3] = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];

struct Grid<V> {
    voxels: Vec<V>,
    layout: Layout,
    ranges: Ranges<V>,
}

impl<V: Voxel> Grid<V> {
    fn new([nx, ny, nz]: [usize; 3], value: impl Fn([f32; 3]) -> V) -> Self {
        let at = |i: usize| value([i % nx, i / nx % ny, i / (nx * ny)].map(|x| x as f32));
        let voxels: Vec<V> = (0..nx * ny * nz).map(at).collect();
        let layout = Layout::new([nx, ny, nz]).unwrap();
        let ranges = Ranges::new(&layout, &voxels, &Serial);
        Self { voxels, layout, ranges }
    }

    fn field(&self) -> GridField<'_, V> {
        GridField { voxels: &self.voxels, layout: &self.layout, ranges: &self.ranges }
    }
}

/// Rays as rows, each from a point to another: t goes from 0 to 1.
#[derive(Default)]
struct Rays {
    origins: [Vec<f32>; 3],
    directions: [Vec<f32>; 3],
    t0: Vec<f32>,
    t1: Vec<f32>,
}

impl Rays {
    fn push(&mut self, from: [f32; 3], to: [f32; 3]) {
        for axis in 0..3 {
            self.origins[axis].push(from[axis]);
            self.directions[axis].push(to[axis] - from[axis]);
        }
        self.t0.push(0.0);
        self.t1.push(1.0);
    }

    fn segments(&self) -> Segments<'_> {
        Segments {
            origins: [&self.origins[0], &self.origins[1], &self.origins[2]],
            directions: [&self.directions[0], &self.directions[1], &self.directions[2]],
            t0: &self.t0,
            t1: &self.t1,
        }
    }

    /// Radiance and transmittance of each.
    fn march(&self, token: AnyToken, march: March<'_>, to_cells: &[[f64; 4]; 3]) -> Vec<[f32; 4]> {
        let (mut passages, mut out) = (Box::<Passages>::default(), Box::<Marched>::default());
        passages.enter(&self.segments(), to_cells, march.field.layout());
        token.run(march.task(&passages, &mut out));
        let [r, g, b] = &out.radiance;
        (0..self.t0.len()).map(|i| [r[i], g[i], b[i], out.transmittance[i]]).collect()
    }
}

/// Numbers that look random, from 0 to 1.
fn noise(i: u32) -> f32 {
    let x = i.wrapping_mul(0x9e37_79b9) ^ 0x5bd1_e995;
    let x = (x ^ x >> 15).wrapping_mul(0x85eb_ca6b);
    let x = (x ^ x >> 13).wrapping_mul(0xc2b2_ae35);
    ((x ^ x >> 16) >> 8) as f32 / (1 << 24) as f32
}

/// Rays through and past a grid, in all directions.
fn scattered(count: u32, size: [f32; 3], seed: u32) -> Rays {
    let mut rays = Rays::default();
    for i in 0..count {
        let point = |k: u32, low: f32, high: f32| {
            [0, 1, 2].map(|axis| size[axis as usize] * (low + (high - low) * noise(seed + 6 * i + 3 * k + axis)))
        };
        rays.push(point(0, -0.5, 1.5), point(1, 0.0, 1.0));
    }
    rays
}

fn knot(value: f32, color: [f32; 3], extinction: f32) -> Knot {
    Knot { value, color, extinction }
}

fn march<'a>(field: &'a dyn mobula_core::volume::Field, transfer: &'a Transfer, step: f32) -> March<'a> {
    March { field, transfer, between: Between::Linear, step, lighting: None }
}

fn close(got: f32, expected: f64, bound: f64) -> bool {
    (f64::from(got) - expected).abs() <= bound
}

#[test]
fn a_constant_volume_is_as_the_law_of_beer_says_whatever_the_step_and_the_spacing() {
    let grid = Grid::new([20, 13, 9], |_| 7_u8);
    let transfer = Transfer::new(&[knot(0.0, [0.0; 3], 0.0), knot(7.0, [0.9, 0.5, 0.1], 0.3)]);
    // Cells of 0.5 x 1 x 2.
    let to_cells = [[2.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.5, 0.0]];
    let size = [9.5, 12.0, 16.0];
    let rays = scattered(200, size, 1);
    for token in AnyToken::available() {
        for step in [0.1, 0.5, 1.0, 7.0] {
            let found = rays.march(token, march(&grid.field(), &transfer, step), &to_cells);
            let mut met = 0;
            for (i, found) in found.iter().enumerate() {
                let (mut near, mut far, mut square) = (0.0_f64, 1.0_f64, 0.0);
                for axis in 0..3 {
                    let (o, d) = (f64::from(rays.origins[axis][i]), f64::from(rays.directions[axis][i]));
                    let (a, b) = (-o / d, (f64::from(size[axis]) - o) / d);
                    (near, far, square) = (near.max(a.min(b)), far.min(a.max(b)), square + d * d);
                }
                let through = (-0.3 * (far - near).max(0.0) * square.sqrt()).exp();
                met += u32::from(near < far);
                // What is left of the light below 1 / 1024 is not followed further.
                assert!(close(found[3], through, 1e-3), "ray {i}: {} for {through}", found[3]);
                for (channel, color) in [0.9, 0.5, 0.1].into_iter().enumerate() {
                    assert!(close(found[channel], color * (1.0 - through), 1e-3), "ray {i}: {found:?}, {through}");
                }
            }
            assert!(met > 80, "{met}");
        }
    }
}

#[test]
fn a_linear_volume_under_a_steep_transfer_function_is_integrated_exactly() {
    // Values rise by 10 a cell; all that is seen is a peak that is three quarters of a cell wide, and a jump.
    let grid = Grid::new([40, 9, 9], |[x, _, _]| 10.0 * x);
    let knots = [
        knot(150.0, [1.0, 0.0, 0.0], 0.0),
        knot(153.75, [1.0, 0.5, 0.0], 0.8),
        knot(157.5, [1.0, 1.0, 0.0], 0.0),
        knot(230.0, [0.0, 0.0, 1.0], 0.0),
        knot(230.0, [0.0, 0.0, 1.0], 0.05),
    ];
    let transfer = Transfer::new(&knots);
    let mut rays = Rays::default();
    for i in 0..32 {
        let (y, z) = (1.0 + 0.2 * i as f32, 7.0 - 0.2 * i as f32);
        rays.push([-1.0, y, z], [45.0, y, z]);
        rays.push([45.0, y, z], [-1.0, y, z]);
    }
    // Behind the peak; the jump is seen from cell 23 to cell 39.
    let (peak, tail) = (0.8 * 0.375, 0.05 * 16.0);
    for token in AnyToken::available() {
        for step in [0.3, 0.5, 1.0, 4.0] {
            for (i, found) in rays.march(token, march(&grid.field(), &transfer, step), &IDENTITY).iter().enumerate() {
                let expected = f64::exp(-peak - tail);
                assert!(close(found[3], expected, 2e-5), "step {step}, ray {i}: {} for {expected}", found[3]);
                let blue = (1.0 - f64::exp(-tail)) * if i % 2 == 0 { f64::exp(-peak) } else { 1.0 };
                assert!(close(found[2], blue, 2e-4), "step {step}, ray {i}: blue {} for {blue}", found[2]);
                // The peak takes from itself evenly over a step: exact for short ones.
                let red = (1.0 - f64::exp(-peak)) * if i % 2 == 0 { 1.0 } else { f64::exp(-tail) };
                assert!(close(found[0], red, 2e-5), "step {step}, ray {i}: red {} for {red}", found[0]);
            }
        }
    }
}

/// A grid of waves and noise, some of it empty.
fn waves() -> Grid<i16> {
    Grid::new([61, 40, 33], |[x, y, z]| {
        let waves = (0.31 * x).sin() + (0.27 * y).cos() + (0.4 * z + 0.1 * x).sin();
        (400.0 * waves + 200.0 * noise((x + 64.0 * y + 4096.0 * z) as u32)) as i16
    })
}

fn several_knots(count: usize) -> Transfer {
    let knot = |i: usize| {
        let value = -300.0 + 1500.0 * i as f32 / count as f32;
        let color = [noise(3 * i as u32), noise(3 * i as u32 + 1), noise(3 * i as u32 + 2)];
        knot(value, color, if i == 0 { 0.0 } else { 0.4 * noise(i as u32 + 77) })
    };
    Transfer::new(&(0..count).map(knot).collect::<Vec<_>>())
}

/// A light at a point of the grid's space, and one from far away.
fn lighting(rays: &Rays, layout: &Layout) -> Lighting {
    let mut passages = Box::<Passages>::default();
    passages.enter(&rays.segments(), &IDENTITY, layout);
    let mut rows = LightRows::default();
    for i in 0..rays.t0.len() {
        let mut ways = [[0.0; 3]; 2];
        for (end, t) in [passages.t0[i], passages.t1[i]].into_iter().enumerate() {
            ways[end] = [0, 1, 2].map(|axis| 100.0 - (rays.origins[axis][i] + t * rays.directions[axis][i]));
            for axis in 0..3 {
                rows.towards[end][axis][i] = ways[end][axis];
                rows.radiance[end][axis][i] = 0.8;
            }
        }
        let dot = |a: [f32; 3], b: [f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let products = [dot(ways[0], ways[0]), dot(ways[0], ways[1]), dot(ways[1], ways[1])];
        for (column, product) in rows.squares.iter_mut().zip(products) {
            column[i] = product;
        }
    }
    Lighting {
        ambient: [[0.2; 3], [0.05; 3]],
        up: [0.0, 0.0, 1.0],
        metric: [1.0, 1.0, 1.0, 0.0, 0.0, 0.0],
        flat: 5.0,
        lights: vec![rows],
    }
}

#[test]
fn what_comes_out_for_a_ray_is_the_same_at_each_level_of_a_family_and_in_any_company() {
    let grid = waves();
    let field = grid.field();
    let rays = scattered(WIDTH as u32, [60.0, 39.0, 32.0], 5);
    let lights = lighting(&rays, &grid.layout);
    for transfer in [several_knots(5), several_knots(15), several_knots(16), several_knots(200)] {
        for (between, lit) in [(Between::Linear, false), (Between::Linear, true), (Between::Nearest, false)] {
            let lighting = lit.then_some(&lights);
            let mut families: [Option<Vec<[u32; 4]>>; 2] = [None, None];
            for token in AnyToken::available() {
                let march = March { field: &field, transfer: &transfer, between, step: 0.7, lighting };
                let found = rays.march(token, march, &IDENTITY);
                let bits: Vec<_> = found.iter().map(|light| light.map(f32::to_bits)).collect();
                assert!(found.iter().flatten().all(|x| x.is_finite()));
                assert!(found.iter().filter(|light| light[3] < 0.9).count() > 100, "most rays meet something");
                let family = families[usize::from(token.fused())].get_or_insert(bits.clone());
                assert_eq!(*family, bits, "{}", token.level());
                if lit {
                    continue;
                }
                // Alone, and as the last of three.
                for i in (0..WIDTH).step_by(17) {
                    let mut few = Rays::default();
                    for k in [(i + 101) % WIDTH, (i + 50) % WIDTH, i] {
                        let end = |axis: usize| rays.origins[axis][k] + rays.directions[axis][k];
                        few.push([0, 1, 2].map(|axis| rays.origins[axis][k]), [0, 1, 2].map(end));
                        for axis in 0..3 {
                            few.directions[axis].pop();
                            few.directions[axis].push(rays.directions[axis][k]);
                        }
                    }
                    assert_eq!(few.march(token, march, &IDENTITY)[2].map(f32::to_bits), bits[i]);
                }
            }
            // The families differ by rounding.
            if let ([Some(a), Some(b)], Between::Linear) = (&families, between) {
                for (a, b) in a.iter().flatten().zip(b.iter().flatten()) {
                    let (a, b) = (f32::from_bits(*a), f32::from_bits(*b));
                    assert!((a - b).abs() < 2e-3, "{a} and {b}");
                }
            }
        }
    }
}

#[test]
fn shorter_steps_come_to_the_same() {
    let grid = waves();
    let field = grid.field();
    let rays = scattered(WIDTH as u32, [60.0, 39.0, 32.0], 9);
    let transfer = several_knots(7);
    let token = AnyToken::detect();
    let fine = rays.march(token, march(&field, &transfer, 1.0 / 32.0), &IDENTITY);
    for (step, bound) in [(1.0, 0.05), (0.5, 0.015), (0.25, 0.005)] {
        let coarse = rays.march(token, march(&field, &transfer, step), &IDENTITY);
        let worst = coarse.iter().flatten().zip(fine.iter().flatten()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(worst < bound, "step {step}: {worst}");
    }
}

/// Where a step takes nearly all light, what is at its front is what is seen.
#[test]
fn what_is_in_front_hides_what_is_behind_within_a_step() {
    let grid = Grid::new([40, 9, 9], |[x, _, _]| 10.0 * x);
    // From clear to opaque within a tenth of a cell, from red to blue within a cell.
    let transfer = Transfer::new(&[
        knot(150.0, [1.0, 0.0, 0.0], 0.0),
        knot(151.0, [0.9, 0.0, 0.1], 20.0),
        knot(160.0, [0.0, 0.0, 1.0], 20.0),
    ]);
    let mut rays = Rays::default();
    for i in 0..64 {
        let y = 1.0 + 0.1 * i as f32;
        rays.push([-1.0, y, 4.0], [45.0, 7.0 - 0.05 * i as f32, 4.0]);
    }
    for token in AnyToken::available() {
        let field = grid.field();
        let fine = rays.march(token, march(&field, &transfer, 1.0 / 32.0), &IDENTITY);
        let coarse = rays.march(token, march(&field, &transfer, 0.5), &IDENTITY);
        for (coarse, fine) in coarse.iter().flatten().zip(fine.iter().flatten()) {
            assert!((coarse - fine).abs() < 0.08, "{coarse} for {fine}");
        }
    }
}

/// Against a walk in double precision from each plane halfway between samples to the next.
#[test]
fn borders_of_labels_are_exact() {
    let size = [21, 14, 11];
    let label = |p: [usize; 3]| (noise((p[0] + 64 * p[1] + 4096 * p[2]) as u32) * 3.0) as u8;
    let grid = Grid::new(size, |p| label(p.map(|x| x as usize)));
    let looks = [([0.0, 0.0, 0.0], 0.0), ([1.0, 0.2, 0.1], 0.2), ([0.1, 0.3, 1.0], 0.9)];
    let knots = looks.iter().enumerate().flat_map(|(label, &(color, extinction))| {
        [knot(label as f32 - 0.5, color, extinction), knot(label as f32 + 0.5, color, extinction)]
    });
    let transfer = Transfer::new(&knots.collect::<Vec<_>>());
    let mut rays = scattered(200, [20.0, 13.0, 10.0], 31);
    // Along axes, and along planes.
    for i in 0..20 {
        let at = i as f32 * 0.25;
        rays.push([-1.0, at, 3.3], [25.0, at, 3.3]);
        rays.push([at, 3.3, 14.0], [at, 3.3, -1.0]);
    }
    let expected = |i: usize| {
        let ray = |axis: usize| (f64::from(rays.origins[axis][i]), f64::from(rays.directions[axis][i]));
        let (mut near, mut far) = (0.0_f64, 1.0_f64);
        let mut ends = Vec::new();
        for axis in 0..3 {
            let (o, d) = ray(axis);
            let last = (size[axis] - 1) as f64;
            if d == 0.0 {
                continue;
            }
            (near, far) = (near.max((-o / d).min((last - o) / d)), far.min((-o / d).max((last - o) / d)));
            ends.extend((0..size[axis]).map(|k| (k as f64 + 0.5 - o) / d));
        }
        ends.retain(|t| near < *t && *t < far);
        ends.extend([near, far]);
        ends.sort_by(f64::total_cmp);
        let length = (0..3).map(|axis| ray(axis).1.powi(2)).sum::<f64>().sqrt();
        let mut light = [0.0, 0.0, 0.0, 1.0];
        for pair in ends.windows(2).filter(|_| near < far) {
            let middle = [0, 1, 2].map(|axis| ray(axis).0 + ray(axis).1 * (pair[0] + pair[1]) / 2.0);
            let (color, extinction) = looks[usize::from(label(middle.map(|x| (x + 0.5).floor() as usize)))];
            let through = (-f64::from(extinction) * (pair[1] - pair[0]) * length).exp();
            for channel in 0..3 {
                light[channel] += light[3] * (1.0 - through) * f64::from(color[channel]);
            }
            light[3] *= through;
        }
        light
    };
    for token in AnyToken::available() {
        let field = grid.field();
        let march = March { between: Between::Nearest, ..march(&field, &transfer, 0.5) };
        for (i, found) in rays.march(token, march, &IDENTITY).into_iter().enumerate() {
            for (found, expected) in found.into_iter().zip(expected(i)) {
                assert!(close(found, expected, 1.1e-3), "ray {i}: {found} for {expected}");
            }
        }
    }
}

#[test]
fn what_cannot_be_seen_is_passed_by() {
    // A bright ball in nothing.
    let grid = Grid::new([65, 65, 65], |p| if p.iter().all(|x| (28.0..36.0).contains(x)) { 200_u8 } else { 3 });
    let transfer = Transfer::new(&[knot(100.0, [1.0; 3], 0.0), knot(200.0, [1.0; 3], 2.0)]);
    assert!(
        !transfer.is_visible(3.0, 99.0) && transfer.is_visible(3.0, 101.0) && !transfer.is_visible(f32::NAN, f32::NAN)
    );
    struct Counted<'a>(GridField<'a, u8>, std::sync::atomic::AtomicUsize);
    impl mobula_core::volume::Field for Counted<'_> {
        fn layout(&self) -> &Layout {
            self.0.layout()
        }
        fn ranges(&self, level: usize, at: [usize; 3]) -> [[f32; 8]; 2] {
            self.0.ranges(level, at)
        }
        fn prefetch(&self, at: [usize; 3]) {
            self.0.prefetch(at);
        }
        fn load(&self, at: [usize; 3], rows: u32, brick: &mut mobula_core::volume::Brick) {
            self.0.load(at, rows, brick);
        }
        fn samples(&self, at: [usize; 3], gradients: bool, out: &mut mobula_core::volume::BrickSamples) {
            self.1.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            self.0.samples(at, gradients, out);
        }
    }
    let counted = Counted(grid.field(), 0.into());
    let mut rays = Rays::default();
    for i in 0..WIDTH {
        let (x, y) = ((i % 16) as f32 * 4.0 + 2.0, (i / 16) as f32 * 4.0 + 2.0);
        rays.push([x, y, -5.0], [x + 0.1, y + 0.1, 70.0]);
    }
    let found = rays.march(AnyToken::detect(), march(&counted, &transfer, 0.5), &IDENTITY);
    assert_eq!(found[0], [0.0, 0.0, 0.0, 1.0]);
    assert!(found.iter().any(|light| light[3] < 1e-3 && light[0] > 0.99));
    let loaded = counted.1.into_inner();
    assert!((1..=2 * 4 * 4).contains(&loaded), "{loaded} bricks of 2048 were looked at");
}

#[test]
fn labels_are_not_interpolated_and_bad_numbers_are_nowhere() {
    // Label 1 on one side, 3 on the other: between them there is no 2.
    let grid = Grid::new([16, 8, 8], |[x, _, _]| if x < 7.5 { 1_u8 } else { 3 });
    let label = |value: f32, color: [f32; 3], extinction: f32| {
        [
            knot(value - 0.5, color, 0.0),
            knot(value - 0.5, color, extinction),
            knot(value + 0.5, color, extinction),
            knot(value + 0.5, color, 0.0),
        ]
    };
    let knots =
        [label(1.0, [1.0, 0.0, 0.0], 0.01), label(2.0, [0.0, 1.0, 0.0], 5.0), label(3.0, [0.0, 0.0, 1.0], 0.02)];
    let transfer = Transfer::new(&knots.concat());
    let mut rays = Rays::default();
    rays.push([-1.0, 3.3, 3.3], [20.0, 3.3, 3.3]);
    for token in AnyToken::available() {
        let field = grid.field();
        let march = March { between: Between::Nearest, ..march(&field, &transfer, 0.05) };
        let [r, g, b, through] = rays.march(token, march, &IDENTITY)[0];
        let (one, three) = (7.5 * 0.01, 7.5 * 0.02);
        assert_eq!(g, 0.0);
        assert!(close(through, f64::exp(-one - three), 1e-3), "{through}");
        assert!(close(r, 1.0 - f64::exp(-one), 1e-3) && close(b, f64::exp(-one) * (1.0 - f64::exp(-three)), 1e-3));
    }
    // A grid with holes.
    let grid = Grid::new([16, 8, 8], |[x, _, _]| [1.0, f32::NAN, f32::INFINITY][(x as usize / 6).min(2)]);
    let transfer = Transfer::new(&[knot(0.0, [1.0; 3], 0.1)]);
    for token in AnyToken::available() {
        for between in [Between::Linear, Between::Nearest] {
            let field = grid.field();
            let found = rays.march(token, March { between, ..march(&field, &transfer, 0.05) }, &IDENTITY)[0];
            let cells = if between == Between::Linear { 5.0 } else { 5.5 };
            assert!(close(found[3], f64::exp(-0.1 * cells), 5e-3), "{found:?}");
        }
    }
    // Rays that are none.
    let mut rays = Rays::default();
    rays.push([f32::NAN, 1.0, 1.0], [2.0, 2.0, 2.0]);
    rays.push([1.0, 1.0, 1.0], [f32::INFINITY, 2.0, 2.0]);
    rays.push([1.0, 1.0, 1.0], [1.0, 1.0, 1.0]);
    rays.push([f32::MAX, 1.0, 1.0], [-f32::MAX, 1.0, 1.0]);
    for light in rays.march(AnyToken::detect(), march(&grid.field(), &transfer, 0.5), &IDENTITY) {
        assert_eq!(light, [0.0, 0.0, 0.0, 1.0]);
    }
}
