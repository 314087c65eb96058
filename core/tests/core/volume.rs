//! Iso-surfaces of grids: the tree against testing all bricks, packets against single rays, the true surface, and that no ray slips
//! through between cells.

use glam::Vec3;
use mobula_core::bvh::Serial;
use mobula_core::simd::AnyToken;
use mobula_core::sink::{OPAQUE, Opacity};
use mobula_core::volume::{GridField, IsoTree, Layout, Ranges, Voxel};
use mobula_core::{AnyHitPacket, NO_HIT, RayPacket, glam, traverse};

pub(crate) struct Grid<V> {
    voxels: Vec<V>,
    layout: Layout,
    ranges: Ranges<V>,
}

impl<V: Voxel> Grid<V> {
    pub(crate) fn new(samples: [usize; 3], value: impl Fn([f32; 3]) -> V) -> Self {
        let [nx, ny, nz] = samples;
        let at = |i: usize| value([i % nx, i / nx % ny, i / (nx * ny)].map(|x| x as f32));
        let voxels: Vec<V> = (0..nx * ny * nz).map(at).collect();
        let layout = Layout::new(samples).unwrap();
        let ranges = Ranges::new(&layout, &voxels, &Serial);
        Self { voxels, layout, ranges }
    }

    pub(crate) fn field(&self) -> GridField<'_, V> {
        GridField { voxels: &self.voxels, layout: &self.layout, ranges: &self.ranges }
    }
}

/// Numbers that look random, from -1 to 1.
fn noise(i: u32) -> f32 {
    let x = i.wrapping_mul(0x9e37_79b9) ^ 0x5bd1_e995;
    let x = (x ^ x >> 15).wrapping_mul(0x85eb_ca6b);
    let x = (x ^ x >> 13).wrapping_mul(0xc2b2_ae35);
    ((x ^ x >> 16) >> 8) as f32 / (1 << 23) as f32 - 1.0
}

fn point(seed: u32, low: f32, high: f32) -> Vec3 {
    let x = |k: u32| low + (high - low) * (0.5 + 0.5 * noise(seed * 3 + k));
    Vec3::new(x(0), x(1), x(2))
}

/// Rays that have nothing in common, and rays from one origin.
fn rays(count: usize, size: f32, seed: u32) -> [Vec<(Vec3, Vec3)>; 2] {
    let scattered = (0..count as u32).map(|i| {
        let from = point(seed + 2 * i, -0.5 * size, 1.5 * size);
        (from, point(seed + 2 * i + 1, 0.0, size) - from)
    });
    let eye = point(seed + 9999, 1.5 * size, 2.5 * size);
    let fan = (0..count).map(|i| {
        let (x, y) = ((i % 16) as f32 / 16.0, (i / 16) as f32 / 16.0);
        (eye, Vec3::new(0.2 * size + 0.6 * size * x, 0.2 * size + 0.6 * size * y, 0.4 * size) - eye)
    });
    [scattered.collect(), fan.collect()]
}

pub(crate) fn packet<const N: usize>(rays: &[(Vec3, Vec3)]) -> RayPacket<N> {
    let mut packet = RayPacket::<N>::default();
    packet.reset(0..rays.len());
    rays.iter().enumerate().for_each(|(i, &(origin, direction))| packet.set_ray(i, origin, direction));
    if rays.iter().all(|ray| ray.0 == rays[0].0) {
        packet.set_common_origin(rays[0].0);
    }
    packet
}

fn hits<const N: usize>(packet: &RayPacket<N>, count: usize) -> Vec<(u32, u32)> {
    (0..count).map(|i| (packet.t_max[i].to_bits(), packet.hits.primitive[i])).collect()
}

fn check_paths<V: Voxel>(grid: &Grid<V>, values: &[f32], size: f32, seed: u32) -> usize {
    let field = grid.field();
    let tree = IsoTree::new(&field, values);
    let mut found = 0;
    for rays in rays(256, size, seed) {
        let mut families = [None, None];
        for token in AnyToken::available() {
            let mut wide = packet::<256>(&rays);
            traverse::intersect(&tree, token, &mut wide);
            let mut all = packet::<256>(&rays);
            traverse::intersect_all(&tree, token, &mut all);
            let wide = hits(&wide, 256);
            assert_eq!(wide, hits(&all, 256), "{}: the tree hides something", token.level());
            for (i, ray) in rays.iter().enumerate() {
                let mut one = packet::<1>(&[*ray]);
                traverse::intersect(&tree, token, &mut one);
                assert_eq!(hits(&one, 1), wide[i..=i], "{}: ray {i}", token.level());
            }
            for (part, expected) in rays.chunks(16).zip(wide.chunks(16)) {
                let mut few = packet::<16>(part);
                traverse::intersect(&tree, token, &mut few);
                assert_eq!(hits(&few, 16), expected, "{}", token.level());
            }
            let mut any = AnyHitPacket::<256>::default();
            any.reset(0..256);
            rays.iter().enumerate().for_each(|(i, &(origin, direction))| any.set_ray(i, origin, direction));
            traverse::occlude(&tree, token, &mut any, None);
            for (i, hit) in wide.iter().enumerate() {
                assert_eq!(any.t_max[i] < 0.0, hit.1 != NO_HIT, "{}: ray {i}", token.level());
            }
            found = wide.iter().filter(|hit| hit.1 != NO_HIT).count();
            let family = &mut families[usize::from(token.level() >= mobula_core::simd::Level::Avx2)];
            assert_eq!(family.get_or_insert_with(|| wide.clone()), &wide, "{}", token.level());
        }
    }
    found
}

#[test]
fn every_path_finds_the_same_in_noise() {
    let grid = |samples: [usize; 3]| Grid::new(samples, |[x, y, z]| noise((x + 37.0 * y + 1009.0 * z) as u32));
    for (samples, seed) in [([20, 19, 18], 1), ([9, 5, 5], 2), ([2, 2, 2], 3), ([35, 3, 2], 4)] {
        check_paths(&grid(samples), &[0.3], samples[0] as f32, seed);
    }
    assert!(check_paths(&grid([20, 19, 18]), &[0.9, -0.8, 0.7], 20.0, 5) > 100);
}

#[test]
fn every_type_of_samples_is_read() {
    fn hits_of<V: Voxel>(value: impl Fn(f32) -> V) -> usize {
        let inside = |[x, y, z]: [f32; 3]| 12.0 - Vec3::new(x - 9.0, y - 9.0, z - 9.0).length() * 1.5;
        check_paths(&Grid::new([19, 19, 19], |at| value(inside(at).clamp(0.0, 100.0))), &[2.5], 19.0, 7)
    }
    let counts = [
        hits_of(|x| x as u8),
        hits_of(|x| x as i8),
        hits_of(|x| x as u16),
        hits_of(|x| x as i16),
        hits_of(|x| x as u32),
        hits_of(|x| x as i32),
        hits_of(|x| x.floor()),
        hits_of(|x| f64::from(x.floor())),
    ];
    assert!(counts[0] > 50 && counts.iter().all(|&count| count == counts[0]), "{counts:?}");
}

#[test]
fn what_is_not_finite_has_no_surface() {
    let value = |[x, y, z]: [f32; 3]| match (x + 5.0 * y + 25.0 * z) as u32 % 37 {
        0 => f32::NAN,
        1 => f32::INFINITY,
        2 => f32::NEG_INFINITY,
        i => noise(i),
    };
    check_paths(&Grid::new([17, 16, 15], value), &[0.1, f32::NAN, f32::INFINITY], 17.0, 11);
}

#[test]
fn hits_are_on_the_true_surface() {
    // Distances from a point: interpolated, the ball is off by less than 1/8 of the second derivative.
    let center = Vec3::splat(15.5);
    let grid = Grid::new([32, 32, 32], |at| 10.0 - (Vec3::from(at) - center).length());
    let (field, mut seen) = (grid.field(), 0);
    for rays in rays(256, 32.0, 3) {
        let mut packet = packet::<256>(&rays);
        traverse::intersect(&IsoTree::new(&field, &[0.0]), AnyToken::detect(), &mut packet);
        for (i, (origin, direction)) in rays.iter().enumerate() {
            let (b, c) = ((*origin - center).dot(*direction), (*origin - center).length_squared() - 100.0);
            let root = b * b - direction.length_squared() * c;
            if packet.was_hit(i) {
                let position = *origin + *direction * packet.t_max[i];
                assert!(((position - center).length() - 10.0).abs() < 0.05, "ray {i}");
                seen += 1;
            } else if c > 0.0 {
                assert!(root < 0.05 * 4000.0 * direction.length_squared() || b > 0.0, "ray {i} misses the ball");
            }
        }
    }
    assert!(seen > 200, "{seen}");
}

/// From outside to a sample inside, through as many faces, edges and vertices of cells as can be.
#[test]
fn no_ray_slips_through_between_cells() {
    let size = 24;
    let inside = |at: [f32; 3]| {
        let blob = 9.0 - (Vec3::from(at) - Vec3::splat(11.5)).length();
        // Many samples are exactly at the iso value, so that the surface goes through edges and vertices.
        (blob * 2.0).round() / 2.0
    };
    let grid = Grid::new([size; 3], inside);
    let field = grid.field();
    let targets: Vec<Vec3> = (0..size.pow(3))
        .map(|i| Vec3::new((i % size) as f32, (i / size % size) as f32, (i / size.pow(2)) as f32))
        .filter(|target| inside(target.to_array()) >= 0.0)
        .collect();
    for token in AnyToken::available() {
        let tree = IsoTree::new(&field, &[0.0]);
        let mut missed = 0;
        for seed in 0..60_u32 {
            // Origins at samples, at middles of faces and edges, and anywhere.
            let far = (point(seed, -1.0, 1.0).normalize() * 30.0).round() + Vec3::splat(12.0);
            let origin = match seed % 3 {
                0 => far,
                1 => far + Vec3::new(0.5, 0.0, 0.25),
                _ => far + point(seed + 77, 0.0, 1.0),
            };
            let aim = |i: usize| {
                let target = targets[(seed as usize * 9973 + i * 31) % targets.len()];
                (origin, target - origin)
            };
            let rays: Vec<_> = (0..256).map(aim).collect();
            let mut packet = packet::<256>(&rays);
            traverse::intersect(&tree, token, &mut packet);
            missed += (0..256).filter(|&i| packet.t_max[i] > 1.0 + 1e-5).count();
        }
        assert_eq!(missed, 0, "{}", token.level());
    }
}

/// Half of the light through each surface.
struct Half;

impl Opacity for Half {
    fn depth(&self, _ray: usize, _primitive: u32, _t: f32) -> u32 {
        1 << 24
    }
}

#[test]
fn light_goes_through_every_crossing_once() {
    // Sheets across x at every other sample: a ray along x crosses two in each pair of cells.
    let grid = Grid::new([33, 9, 9], |[x, _, _]| if (x as u32).is_multiple_of(2) { 0_u8 } else { 10 });
    let field = grid.field();
    for token in AnyToken::available() {
        let tree = IsoTree::new(&field, &[5.0]);
        let mut packet = AnyHitPacket::<64>::default();
        packet.reset(0..64);
        for i in 0..64 {
            let from = Vec3::new(-3.0, 1.0 + 0.1 * (i % 8) as f32, 1.0 + 0.25 * (i / 8) as f32);
            packet.set_ray(i, from, Vec3::X);
            packet.set_interval(i, 0.0, 3.0 + 2.0 * (i % 5) as f32);
        }
        traverse::occlude(&tree, token, &mut packet, Some(&Half));
        for i in 0..64 {
            let expected = ((2 * (i % 5) as u32) << 24).min(OPAQUE);
            assert_eq!(packet.depth()[i], expected, "{}: ray {i}", token.level());
        }
    }
}
