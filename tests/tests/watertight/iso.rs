//! No ray gets from one side of an iso-surface to the other unseen. Why: `kernel::iso_cell`.
//!
//! Where the samples at the ends of a grid are all below the iso value, a ray that starts at a sample above it must hit, wherever it
//! goes, and so must one from outside to such a sample, before it is there. Rays between samples, middles of edges and of faces go
//! through faces, edges and vertices of many cells, exactly: their coordinates are whole numbers and halves.

use mobula_core::bvh::Serial;
use mobula_core::glam::Vec3;
use mobula_core::simd::AnyToken;
use mobula_core::volume::{GridField, IsoTree, Layout, Ranges, Voxel};

use crate::levels;
use crate::shoot::{Count, Random};

/// Where rays start, and where they go.
#[derive(Clone, Copy, Debug, PartialEq)]
enum From {
    /// One sample inside.
    Sample,
    /// One point in a cell that is inside.
    Cell,
    /// A sample inside for each ray, near one another or not.
    Samples,
    /// One point outside with whole coordinates or halves, to samples inside.
    Outside,
    /// As that, a point for each ray, anywhere.
    Anywhere,
}

const FROM: [From; 5] = [From::Sample, From::Cell, From::Samples, From::Outside, From::Anywhere];

/// A grid, and what is inside its iso-surface.
struct Scene<V> {
    name: &'static str,
    samples: [usize; 3],
    voxels: Vec<V>,
    layout: Layout,
    ranges: Ranges<V>,
    iso: f32,
    /// Samples above the iso value.
    inside: Vec<usize>,
    /// Low corners of cells with nothing but such samples.
    cells: Vec<usize>,
}

impl<V: Voxel> Scene<V> {
    /// The samples at the ends of the grid are `below`, whatever the field.
    fn new(name: &'static str, samples: [usize; 3], iso: f32, below: V, field: impl Fn(Vec3) -> V) -> Self {
        let [nx, ny, nz] = samples;
        let at = |i: usize| [i % nx, i / nx % ny, i / (nx * ny)];
        let is_end = |at: [usize; 3]| (0..3).any(|axis| at[axis] == 0 || at[axis] + 1 == samples[axis]);
        let value = |i: usize| if is_end(at(i)) { below } else { field(Vec3::from(at(i).map(|x| x as f32))) };
        let voxels: Vec<V> = (0..nx * ny * nz).map(value).collect();
        let layout = Layout::new(samples).unwrap();
        let ranges = Ranges::new(&layout, &voxels, &Serial);
        let is_inside = |i: usize| voxels[i].to_f32() > iso;
        let inside: Vec<usize> = (0..voxels.len()).filter(|&i| is_inside(i)).collect();
        // The last samples are below: there is always a next one.
        let steps: [usize; 8] = std::array::from_fn(|k| (k & 1) + (k >> 1 & 1) * nx + (k >> 2) * nx * ny);
        let cells: Vec<usize> = inside.iter().copied().filter(|i| steps.iter().all(|s| is_inside(i + s))).collect();
        assert!(!inside.is_empty() && !cells.is_empty(), "{name}");
        Self { name, samples, voxels, layout, ranges, iso, inside, cells }
    }

    fn position(&self, i: usize) -> Vec3 {
        let [nx, ny, _] = self.samples;
        Vec3::from([i % nx, i / nx % ny, i / (nx * ny)].map(|x| x as f32))
    }

    fn sample(&self, random: &mut Random) -> Vec3 {
        self.position(self.inside[random.below(self.inside.len())])
    }

    /// A vertex, a middle or a point of an edge, or a middle or a point of a face, of any cell.
    fn feature(&self, random: &mut Random) -> Vec3 {
        let low = Vec3::from(self.samples.map(|count| random.below(count) as f32));
        let axis = random.below(3);
        let mut part = Vec3::ZERO;
        match random.below(8) {
            0..3 => {}
            3 => part[axis] = 0.5,
            4 => part[axis] = random.unit(),
            5 => (part[axis], part[(axis + 1) % 3]) = (0.5, 0.5),
            _ => (part[axis], part[(axis + 1) % 3]) = (random.unit(), random.unit()),
        }
        low + part
    }

    /// A point that is not in the grid, or in one of its ends: with whole coordinates and halves, or moved by up to `loose`.
    fn outside(&self, loose: f32, random: &mut Random) -> Vec3 {
        let size = Vec3::from(self.samples.map(|count| count as f32));
        let round = ((random.signed() * size * 2.0 + size * 0.5) * 2.0).round() * 0.5;
        let mut from = round + random.signed() * loose;
        let axis = random.below(3);
        let [below, above] = [-loose * random.unit(), size[axis] - 1.0 + loose * random.unit()];
        // Also from the planes of the grid's ends, and from far away.
        from[axis] = [below, below - 1.0, below - 7.5, above, above + 100.0][random.below(5)];
        from
    }

    /// The rays of a packet, and by when they must hit. If they are coherent, starts and aims are near one another.
    fn rays<const N: usize>(&self, from: From, coherent: bool, random: &mut Random) -> (Vec<(Vec3, Vec3)>, f32) {
        let cell = self.position(self.cells[random.below(self.cells.len())]);
        let one = match from {
            From::Cell => cell + Vec3::new(random.unit(), random.unit(), random.unit()),
            From::Outside | From::Anywhere => self.outside(0.0, random),
            _ => self.sample(random),
        };
        let first = random.below(self.inside.len());
        let (mut aim, axis) = (self.feature(random), random.below(3));
        let way = aim - self.position(self.inside[first]);
        let mut rays = Vec::with_capacity(N);
        for i in 0..N {
            let (sample, aim) = if coherent {
                let mut step = Vec3::ZERO;
                (step[axis], step[(axis + 1) % 3]) = ((i % 4) as f32 * 0.5, (i / 4 % 4) as f32 * 0.5);
                (self.position(self.inside[(first + i % 8) % self.inside.len()]), aim + step)
            } else {
                aim = self.feature(random);
                (self.sample(random), aim)
            };
            let (origin, mut direction) = match from {
                From::Sample | From::Cell => (one, aim - one),
                From::Samples if coherent => (sample, way),
                From::Samples => (sample, aim - sample),
                From::Outside => (one, sample - one),
                From::Anywhere => {
                    // Farther away from what is inside is outside too.
                    let origin =
                        if coherent { one - (sample - one) * random.unit() } else { self.outside(0.4, random) };
                    (origin, sample - origin)
                }
            };
            if !coherent && matches!(from, From::Sample | From::Cell | From::Samples) && random.below(4) == 0 {
                direction = random.signed();
            }
            rays.push((origin, if direction == Vec3::ZERO { Vec3::X } else { direction }));
        }
        // Where a sample is, what is near it is inside too, but for roundings.
        let until = if matches!(from, From::Outside | From::Anywhere) { 1.0 + 1e-4 } else { f32::INFINITY };
        (rays, until)
    }

    fn shoot(&self, count: &mut Count, token: AnyToken, random: &mut Random) {
        let field = GridField { voxels: &self.voxels, layout: &self.layout, ranges: &self.ranges };
        let isos = [self.iso];
        let tree = IsoTree::new(&field, &isos);
        for from in FROM {
            for coherent in [true, false] {
                self.packet::<64>(count, token, &tree, from, coherent, random);
                self.packet::<16>(count, token, &tree, from, coherent, random);
                self.packet::<300>(count, token, &tree, from, coherent, random);
                for _ in 0..8 {
                    self.packet::<1>(count, token, &tree, from, coherent, random);
                }
            }
        }
    }

    fn packet<const N: usize>(
        &self,
        count: &mut Count,
        token: AnyToken,
        tree: &IsoTree<'_>,
        from: From,
        coherent: bool,
        random: &mut Random,
    ) {
        let (rays, until) = self.rays::<N>(from, coherent, random);
        count.shoot::<_, N>(token, tree, &rays, until, || format!("{}, {from:?}", self.name));
    }
}

/// Numbers that look random, from 0 to 1.
fn noise(at: Vec3) -> f32 {
    let mut random = Random((at.x + 257.0 * at.y + 65_537.0 * at.z) as u64 ^ 0x5bd1_e995);
    random.unit();
    random.unit()
}

fn no_ray_slips_through(token: AnyToken) {
    let ball = |at: Vec3| 9.0 - (at - Vec3::splat(11.5)).length();
    let distance = Scene::new("ball", [24; 3], 0.0, -1.0, ball);
    // Many samples are exactly at the iso value: the surface goes through edges and vertices.
    let steps = Scene::new("ball in steps", [24; 3], 0.0, -1.0, |at| (ball(at) * 2.0).round() / 2.0);
    let tiny = Scene::new("ball * 1e-30", [24; 3], 0.0, -1e-30, |at| ball(at) * 1e-30);
    let huge = Scene::new("ball * 1e30", [24; 3], 0.0, -1e30, |at| ball(at) * 1e30);
    let rough = Scene::new("noise", [20; 3], 127.5, 0_u8, |at| (255.0 * noise(at)) as u8);
    let equal = Scene::new("few values", [20; 3], 1.0, 0_u8, |at| (4.0 * noise(at)) as u8);
    let binary = Scene::new("blocks", [22, 21, 20], 0.5, 0_u8, |at| u8::from(noise((at / 3.0).floor()) > 0.4));
    let long = Scene::new("long", [700, 9, 8], 0.0, -1_i16, |at| (2000.0 * (noise(at) - 0.3)) as i16);
    let gyroid = |at: Vec3| {
        let p = at * 0.45;
        let value = p.x.sin() * p.y.cos() + p.y.sin() * p.z.cos() + p.z.sin() * p.x.cos();
        32_768.0 + 10_000.0 * value
    };
    let waves = Scene::new("gyroid", [48; 3], 32_768.0, 0_u16, |at| gyroid(at) as u16);
    let (mut count, mut random) = (Count::default(), Random(29));
    while count.rays < Count::wanted() {
        for scene in [&distance, &steps, &tiny, &huge] {
            scene.shoot(&mut count, token, &mut random);
        }
        for scene in [&rough, &equal, &binary] {
            scene.shoot(&mut count, token, &mut random);
        }
        long.shoot(&mut count, token, &mut random);
        waves.shoot(&mut count, token, &mut random);
    }
    count.check(token);
}

levels::at_every_level!(no_ray_slips_through);
