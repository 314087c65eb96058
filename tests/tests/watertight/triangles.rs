//! No ray that starts inside a closed mesh leaves it unseen. Why: `kernel::triangle`.

use mobula_core::bvh::{Bvh, Serial};
use mobula_core::glam::Vec3;
use mobula_core::leaf::TriangleBlock;
use mobula_core::simd::AnyToken;
use mobula_tests::mesh::Mesh;

use crate::levels;
use crate::shoot::{Count, Random};

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

fn shoot<const N: usize>(
    count: &mut Count,
    token: AnyToken,
    scene: &Scene,
    from: From,
    coherent: bool,
    random: &mut Random,
) {
    let rays = scene.rays::<N>(from, coherent, random);
    count.shoot::<_, N>(token, &scene.bvh, &rays, f32::INFINITY, || format!("{}, {from:?}", scene.name));
}

fn none_is_missed(token: AnyToken) {
    let scenes = Scene::all();
    let mut count = Count::default();
    let mut random = Random(23);
    while count.rays < Count::wanted() {
        for scene in &scenes {
            for from in FROM {
                if from == From::Skin && !scene.has_skin() {
                    continue;
                }
                for coherent in [true, false] {
                    shoot::<64>(&mut count, token, scene, from, coherent, &mut random);
                    shoot::<16>(&mut count, token, scene, from, coherent, &mut random);
                    shoot::<300>(&mut count, token, scene, from, coherent, &mut random);
                    for _ in 0..8 {
                        shoot::<1>(&mut count, token, scene, from, coherent, &mut random);
                    }
                }
            }
        }
    }
    count.check(token);
}

levels::at_every_level!(none_is_missed);
