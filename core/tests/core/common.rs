//! Random numbers, scenes and rays that the tests share.

use mobula_core::glam::Vec3;

pub(crate) type Triangle = [[f32; 3]; 3];

/// A small deterministic generator (PCG-like), so that a failure can be repeated.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1u64 << 24) as f32
    }

    pub(crate) fn below(&mut self, n: usize) -> usize {
        (self.unit() * n as f32) as usize % n
    }

    pub(crate) fn point(&mut self, size: f32) -> Vec3 {
        Vec3::new(self.unit() - 0.5, self.unit() - 0.5, self.unit() - 0.5) * size
    }

    pub(crate) fn pick<T: Copy>(&mut self, from: &[T]) -> T {
        from[self.below(from.len())]
    }
}

fn snap(v: Vec3, steps: f32) -> Vec3 {
    (v * steps).round() / steps
}

/// Triangles in a cube of edge 2 around 0, which `scale` and `offset` then move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Shape {
    /// Of any size and direction.
    Scattered,
    /// Corners on a coarse grid: shared edges, shared planes, flat boxes.
    Snapped,
    /// Two corners a few ulp apart.
    Needles,
    /// Three corners almost on one line.
    Slivers,
    /// Overlapping triangles of one plane, some of them twice.
    Coplanar,
    /// Sizes 1, 1/2, 1/4, ..., each inside the one before.
    Nested,
    /// As large as a few ulp of their coordinates.
    Dust,
}

pub(crate) const SHAPES: [Shape; 7] =
    [Shape::Scattered, Shape::Snapped, Shape::Needles, Shape::Slivers, Shape::Coplanar, Shape::Nested, Shape::Dust];

impl Shape {
    pub(crate) fn triangles(self, count: usize, scale: f32, offset: Vec3, random: &mut Random) -> Vec<Triangle> {
        let plane = [random.point(2.0), random.point(2.0), random.point(2.0)];
        let mut all: Vec<Triangle> = Vec::new();
        for i in 0..count {
            let a = random.point(2.0);
            let (b, c) = (a + random.point(0.7), a + random.point(0.7));
            let ulps = |random: &mut Random| random.point(8.0) * f32::EPSILON;
            let corners = match self {
                Self::Scattered => [a, b, c],
                Self::Snapped => [a, b, c].map(|p| snap(p, 4.0)),
                Self::Needles => [a, a + ulps(random), c],
                Self::Slivers => [a, c, a + (c - a) * random.unit() + ulps(random)],
                Self::Coplanar => {
                    if i % 5 == 4 {
                        let again = all[random.below(i)];
                        all.push(again);
                        continue;
                    }
                    [0, 1, 2].map(|_| {
                        let (u, v) = (random.unit(), random.unit());
                        plane[0] + (plane[1] - plane[0]) * u + (plane[2] - plane[0]) * v
                    })
                }
                Self::Nested => {
                    let size = 0.5f32.powi((i % 61) as i32);
                    let p = [Vec3::ZERO, b - a, c - a].map(|p| p * size);
                    if i % 2 == 0 { p } else { p.map(|p| p + Vec3::splat(size)) }
                }
                Self::Dust => [a, a + ulps(random), a + ulps(random)],
            };
            all.push(corners.map(|p| (p * scale + offset).to_array()));
        }
        all
    }
}

/// How the rays of a packet are made. All are aimed at the cube of [`Shape`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Aim {
    /// An 8 x 8 tile of a pinhole camera in front.
    Camera,
    /// A tile of parallel rays.
    Parallel,
    /// Anything from anywhere.
    Random,
    /// Along the axes, from a grid; the other components are zeros of both signs.
    Axes,
    /// From outside, at corners, edges, and insides of the scene's triangles.
    AtFeatures,
    /// The same from one point.
    AtFeaturesFromOne,
    /// From a point of a triangle.
    FromSurfaces,
    /// Along edges, from before, on, or at the end of them.
    AlongEdges,
    /// Nearly in a triangle's plane.
    Grazing,
}

pub(crate) const AIMS: [Aim; 9] = [
    Aim::Camera,
    Aim::Parallel,
    Aim::Random,
    Aim::Axes,
    Aim::AtFeatures,
    Aim::AtFeaturesFromOne,
    Aim::FromSurfaces,
    Aim::AlongEdges,
    Aim::Grazing,
];

impl Aim {
    pub(crate) fn common_origin(self) -> bool {
        matches!(self, Self::Camera | Self::AtFeaturesFromOne)
    }

    /// Ray `i` of packet `round`.
    pub(crate) fn ray(
        self,
        i: usize,
        round: usize,
        triangles: &[Triangle],
        scale: f32,
        offset: Vec3,
        random: &mut Random,
    ) -> (Vec3, Vec3) {
        let tile = Vec3::new((i % 8) as f32, (i / 8 % 8) as f32, 0.0);
        let of_any = |random: &mut Random| triangles[random.below(triangles.len())].map(Vec3::from);
        let place = |p: Vec3| p * scale + offset;
        let feature = |random: &mut Random| {
            let [a, b, c] = of_any(random);
            match random.below(4) {
                0 => a,
                1 => a + (b - a) * random.unit(),
                2 => b + (c - b) * 0.5,
                _ => {
                    let (u, v) = (random.unit(), random.unit());
                    a + ((b - a) * (1.0 - v) + (c - a) * v) * u
                }
            }
        };
        match self {
            Self::Camera => {
                (place(Vec3::new(0.1, 0.2, 3.0)), Vec3::new(-0.3, -0.35, -1.0) + tile * 0.08 + round as f32 * 0.01)
            }
            Self::Parallel => (place(Vec3::new(-0.5, -0.5, 4.0) + tile * 0.13), Vec3::new(0.05, 0.03, -1.0)),
            Self::Random => (place(random.point(2.0)), random.point(2.0)),
            Self::Axes => {
                let mut direction = Vec3::ZERO.map(|_| random.pick(&[0.0, -0.0]));
                direction[i % 3] = random.pick(&[1.0, -1.0, 0.3]);
                if random.below(3) == 0 {
                    direction[(i + 1) % 3] = random.pick(&[1.0, -1.0]);
                }
                (place(snap(random.point(2.0), 8.0)), direction)
            }
            Self::AtFeatures => {
                let origin = place(random.point(6.0));
                (origin, feature(random) - origin)
            }
            Self::AtFeaturesFromOne => {
                let origin = place(Vec3::new(-2.1, 1.7, -2.9));
                (origin, feature(random) - origin)
            }
            Self::FromSurfaces => (feature(random), random.point(2.0)),
            Self::AlongEdges => {
                let [a, b, _] = of_any(random);
                (a + (b - a) * random.pick(&[-1.0, -0.5, 0.0, 0.5, 1.0]), b - a)
            }
            Self::Grazing => {
                let [a, b, c] = of_any(random);
                let target = a + (b - a) * random.unit() * 0.5 + (c - a) * random.unit() * 0.5;
                let within = (b - a) * (random.unit() - 0.5) + (c - a) * (random.unit() - 0.5);
                let off = (b - a).cross(c - a).normalize_or_zero() * within.length();
                let direction = within + off * random.pick(&[0.0, 1e-6, 1e-4, 1e-2]);
                (target - direction * random.pick(&[0.5, 4.0]), direction)
            }
        }
    }
}
