//! No ray that starts inside a closed mesh leaves it unseen: not through an edge, not through a vertex, at any level and
//! width, with common origin, without, and alone. Why: `kernel::triangle`.
//!
//! `MOBULA_WATERTIGHT_RAYS=10000000 cargo test --release -p mobula-tests --test watertight -- --nocapture` shoots as many at
//! each level; by default it is a small share of that.

#[path = "../../simd/tests/common/levels.rs"]
mod levels;

use mobula_core::bvh::{Bvh, Serial};
use mobula_core::glam::Vec3;
use mobula_core::leaf::TriangleBlock;
use mobula_core::simd::AnyToken;
use mobula_core::traverse::Paths;
use mobula_core::{AnyHitPacket, RayPacket};
use mobula_tests::mesh::Mesh;

/// Where the rays of a packet start.
#[derive(Clone, Copy, Debug, PartialEq)]
enum From {
    /// The middle of the mesh: directions are the vertices themselves, so nothing is rounded.
    Middle,
    /// One point inside.
    OnePoint,
    /// A point inside for each ray, near one another.
    Nearby,
    /// Just below the surface.
    Skin,
    /// Outside; the ray meets its target and then the middle.
    Outside,
}

const FROM: [From; 5] = [From::Middle, From::OnePoint, From::Nearby, From::Skin, From::Outside];

struct Random(u64);

impl Random {
    fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1u64 << 24) as f32
    }

    fn below(&mut self, n: usize) -> usize {
        (self.unit() * n as f32) as usize % n
    }

    fn signed(&mut self) -> Vec3 {
        Vec3::new(self.unit(), self.unit(), self.unit()) * 2.0 - 1.0
    }
}

struct Scene {
    name: &'static str,
    mesh: Mesh,
    bvh: Bvh<TriangleBlock>,
    middle: Vec3,
    /// Radius of a ball around the middle from which all of the surface can be seen.
    seeing: Vec3,
}

impl Scene {
    fn new(name: &'static str, mesh: Mesh, scale: Vec3, offset: Vec3) -> Self {
        mesh.assert_closed();
        let mesh = mesh.map(|v| v * scale + offset);
        let bvh = Bvh::triangles(mesh.triangles.len(), 0, &Serial, |i| mesh.corners(i));
        Self { name, mesh, bvh, middle: offset, seeing: scale * 0.05 }
    }

    fn all() -> Vec<Self> {
        let lump = || Mesh::lump(4, 0.01);
        let one = Vec3::ONE;
        vec![
            Self::new("lump of 20480", Mesh::lump(5, 0.002), one, Vec3::ZERO),
            Self::new("crate of 3072", Mesh::crate_of(16), one, Vec3::ZERO),
            Self::new("lump * 1e-6", lump(), one * 1e-6, Vec3::ZERO),
            Self::new("lump * 1e6", lump(), one * 1e6, Vec3::ZERO),
            Self::new("lump + 1e4", lump(), one, Vec3::new(1e4, -1e4, 1e4)),
            Self::new("crate + 1000", Mesh::crate_of(16), one, Vec3::splat(1000.0)),
            Self::new("slivers", lump(), Vec3::new(1.0, 1e-3, 1.0), Vec3::ZERO),
            Self::new("thin slivers", lump(), Vec3::new(1e-6, 1.0, 3e-2), Vec3::ZERO),
            Self::new("thin slivers + 10", lump(), Vec3::new(3.0, 1e-5, 1.0), Vec3::new(10.0, 7.0, -10.0)),
        ]
    }

    /// A vertex, a point of an edge, or a point of a face, of the triangle `i`.
    fn target(&self, i: usize, random: &mut Random) -> Vec3 {
        let [a, b, c] = self.mesh.triangles[i % self.mesh.triangles.len()].map(|v| self.mesh.vertices[v]);
        match random.below(8) {
            0..3 => a,
            3 => (a + b) * 0.5,
            4..7 => b + (c - b) * random.unit(),
            _ => a + ((b - a) * random.unit() + (c - a) * random.unit()) * 0.5,
        }
    }

    /// Is a point a thousandth below the surface inside, and farther from it than single precision errs? Not where it
    /// rounds to a coarser grid, nor where the mesh is thinner than that.
    fn has_skin(&self) -> bool {
        self.middle == Vec3::ZERO && self.seeing.min_element() > 1e-5 * self.seeing.max_element()
    }

    fn inside(&self, random: &mut Random) -> Vec3 {
        self.middle + random.signed() * self.seeing
    }

    /// Packet `round`'s rays: at neighbouring triangles, or all over.
    fn rays<const N: usize>(&self, from: From, coherent: bool, random: &mut Random) -> Vec<(Vec3, Vec3)> {
        let first = random.below(self.mesh.triangles.len());
        let one = self.inside(random);
        let mut rays = Vec::with_capacity(N);
        for i in 0..N {
            let triangle = if coherent { first + i / 8 } else { random.below(self.mesh.triangles.len()) };
            let target = self.target(triangle, random);
            let origin = match from {
                From::Middle => self.middle,
                From::OnePoint => one,
                From::Nearby => one + random.signed() * self.seeing * 0.1,
                From::Skin => self.middle + (target - self.middle) * 0.999,
                From::Outside => self.middle + (target - self.middle) * 3.0,
            };
            let direction = match from {
                From::Outside => self.middle - origin,
                From::Skin if coherent => (target - origin) * 1000.0,
                From::Skin => random.signed(),
                _ if !coherent && random.below(4) == 0 => random.signed(),
                _ => target - origin,
            };
            // Rounding can leave no direction at all.
            rays.push((origin, if direction == Vec3::ZERO { Vec3::X } else { direction }));
        }
        rays
    }
}

#[derive(Debug, Default)]
struct Count {
    rays: u64,
    missed: u64,
    paths: Paths,
    first: Option<String>,
}

impl Count {
    fn shoot<const N: usize>(
        &mut self,
        token: AnyToken,
        scene: &Scene,
        from: From,
        coherent: bool,
        random: &mut Random,
    ) {
        let rays = scene.rays::<N>(from, coherent, random);
        let mut packet = RayPacket::<N>::default();
        packet.reset(0..N);
        for (i, &(origin, direction)) in rays.iter().enumerate() {
            packet.set_ray(i, origin, direction);
        }
        if matches!(from, From::Middle | From::OnePoint) {
            packet.set_common_origin(rays[0].0);
        }
        self.paths += scene.bvh.intersect(token, &mut packet);
        let mut shadow = (N == 64).then(AnyHitPacket::<N>::default);
        if let Some(shadow) = &mut shadow {
            shadow.reset(0..N);
            for (i, &(origin, direction)) in rays.iter().enumerate() {
                shadow.set_ray(i, origin, direction);
            }
            scene.bvh.occlude(token, shadow);
        }
        for (i, ray) in rays.iter().enumerate() {
            self.rays += 1;
            if !packet.was_hit(i) || shadow.as_ref().is_some_and(|shadow| !shadow.occluded(i)) {
                self.missed += 1;
                let found = packet.was_hit(i);
                let name = scene.name;
                self.first.get_or_insert_with(|| format!("{name}, width {N}, {from:?}, closest hit {found}: {ray:?}"));
            }
        }
    }
}

fn none_is_missed(token: AnyToken) {
    let wanted = std::env::var("MOBULA_WATERTIGHT_RAYS").ok().and_then(|n| n.parse().ok()).unwrap_or(60_000u64);
    let scenes = Scene::all();
    let mut count = Count::default();
    let mut random = Random(23);
    while count.rays < wanted {
        for scene in &scenes {
            for from in FROM {
                if from == From::Skin && !scene.has_skin() {
                    continue;
                }
                for coherent in [true, false] {
                    count.shoot::<64>(token, scene, from, coherent, &mut random);
                    count.shoot::<16>(token, scene, from, coherent, &mut random);
                    count.shoot::<300>(token, scene, from, coherent, &mut random);
                    for _ in 0..8 {
                        count.shoot::<1>(token, scene, from, coherent, &mut random);
                    }
                }
            }
        }
    }
    println!("{token:?}: {} rays, {} missed; {:?}", count.rays, count.missed, count.paths);
    assert_eq!(count.missed, 0, "{token:?}: of {} rays; {:?}", count.rays, count.first);
    let Paths { common_origin, general, single } = count.paths;
    assert!(common_origin > 0 && general > 0 && single > 0, "{:?}", count.paths);
}

levels::at_every_level!(none_is_missed);
