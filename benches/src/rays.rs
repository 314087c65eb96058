//! Rays as every peer gets them, and results as every peer gives them: structures of arrays in tile order.

use mobula::sampler::morton;

use crate::scenes::View;

/// Pixels a side of the tiles that order the rays; inside a tile pixels follow the Morton curve, so that 16, 64 and 256
/// rays in a row are squares.
const TILE: u32 = 16;

/// What rays are for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// From the eye, closest hit.
    Primary,
    /// From surfaces to the point light, any hit.
    ShadowPoint,
    /// From the point light to surfaces, any hit: as [`ShadowPoint`](Self::ShadowPoint), turned round.
    ShadowFromLight,
    /// From surfaces to the sun, any hit.
    ShadowDirectional,
    /// From surfaces, cosine-distributed, short, any hit.
    Occlusion,
    /// From surfaces, cosine-distributed, closest hit.
    Diffuse,
}

impl Kind {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::Primary,
        Self::ShadowPoint,
        Self::ShadowFromLight,
        Self::ShadowDirectional,
        Self::Occlusion,
        Self::Diffuse,
    ];

    /// As `--rays` spells it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Primary => "primary",
            Self::ShadowPoint => "shadow-point",
            Self::ShadowFromLight => "shadow-from-light",
            Self::ShadowDirectional => "shadow-directional",
            Self::Occlusion => "ao",
            Self::Diffuse => "diffuse",
        }
    }

    /// Mobula's speed over Embree's that is aimed at; nothing for rays that could be sent better.
    pub const fn target(self) -> Option<f64> {
        match self {
            Self::Primary | Self::ShadowFromLight => Some(2.0),
            Self::ShadowPoint => None,
            Self::ShadowDirectional => Some(1.5),
            Self::Occlusion | Self::Diffuse => Some(1.0),
        }
    }

    /// Is only asked whether there is a hit?
    pub const fn any_hit(self) -> bool {
        !matches!(self, Self::Primary | Self::Diffuse)
    }
}

/// Rays; the interval of each is `(0, t_max]`, directions have length 1.
#[derive(Clone, Debug, Default)]
pub struct RaySet {
    /// Origins by axis.
    pub origin: [Vec<f32>; 3],
    /// Directions by axis.
    pub direction: [Vec<f32>; 3],
    /// Far ends.
    pub t_max: Vec<f32>,
    /// Do all start at one point?
    pub common_origin: bool,
}

impl RaySet {
    /// Number of rays.
    pub fn len(&self) -> usize {
        self.t_max.len()
    }

    /// Is there none?
    pub fn is_empty(&self) -> bool {
        self.t_max.is_empty()
    }

    /// The same rays in sets of `count`.
    pub fn parts(&self, count: usize) -> Vec<RaySet> {
        let part = |array: &Vec<f32>, start: usize| array[start..(start + count).min(array.len())].to_vec();
        (0..self.len())
            .step_by(count)
            .map(|start| RaySet {
                origin: [0, 1, 2].map(|axis| part(&self.origin[axis], start)),
                direction: [0, 1, 2].map(|axis| part(&self.direction[axis], start)),
                t_max: part(&self.t_max, start),
                common_origin: self.common_origin,
            })
            .collect()
    }

    /// Reads all of it, so that it is in the cache.
    pub fn touch(&self) {
        let arrays = self.origin.iter().chain(&self.direction).chain([&self.t_max]);
        std::hint::black_box(arrays.map(|array| array.iter().sum::<f32>()).sum::<f32>());
    }

    /// Adds a ray.
    pub fn push(&mut self, origin: [f32; 3], direction: [f32; 3], t_max: f32) {
        for axis in 0..3 {
            self.origin[axis].push(origin[axis]);
            self.direction[axis].push(direction[axis]);
        }
        self.t_max.push(t_max);
    }

    /// Origin and direction of ray `i`.
    pub fn ray(&self, i: usize) -> ([f32; 3], [f32; 3]) {
        ([0, 1, 2].map(|axis| self.origin[axis][i]), [0, 1, 2].map(|axis| self.direction[axis][i]))
    }

    /// The rays through the middles of all pixels.
    pub fn primary(view: &View) -> Self {
        let forward = normalize(sub(view.at, view.eye));
        let right = normalize(cross(forward, view.up));
        let up = cross(right, forward);
        let mut rays = Self { common_origin: true, ..Self::default() };
        for [x, y] in pixels(view.pixels) {
            let sx = (2.0 * (x as f32 + 0.5) / view.pixels as f32 - 1.0) * view.tangent;
            let sy = (1.0 - 2.0 * (y as f32 + 0.5) / view.pixels as f32) * view.tangent;
            let direction = [0, 1, 2].map(|i| forward[i] + sx * right[i] + sy * up[i]);
            rays.push(view.eye, normalize(direction), f32::INFINITY);
        }
        rays
    }
}

/// All pixels in tile order.
fn pixels(side: u32) -> impl Iterator<Item = [u32; 2]> {
    let tiles = side / TILE;
    (0..tiles * tiles).flat_map(move |tile| {
        (0..TILE * TILE).map(move |code| {
            let [x, y] = morton::decode(code);
            [tile % tiles * TILE + x, tile / tiles * TILE + y]
        })
    })
}

/// What was found: for any-hit rays `t` is `-inf` where something is in the way, and `primitive` is not used.
#[derive(Clone, Debug, Default)]
pub struct Found {
    /// Distances; `t_max` where nothing was hit.
    pub t: Vec<f32>,
    /// Triangles; [`NOTHING`] where none was hit.
    pub primitive: Vec<u32>,
    /// Where on the triangles, if it is asked for: how much of the second corner and of the third.
    pub uv: Option<[Vec<f32>; 2]>,
}

/// "No triangle".
pub const NOTHING: u32 = u32::MAX;

impl Found {
    /// Room for `count` results.
    pub fn new(count: usize) -> Self {
        Self { t: vec![0.0; count], primitive: vec![NOTHING; count], uv: None }
    }

    /// Did ray `i` find anything?
    #[inline(always)]
    pub fn hit(&self, i: usize, any_hit: bool) -> bool {
        if any_hit { self.t[i] == f32::NEG_INFINITY } else { self.primitive[i] != NOTHING }
    }

    /// How many rays found something.
    pub fn hits(&self, any_hit: bool) -> usize {
        (0..self.t.len()).filter(|&i| self.hit(i, any_hit)).count()
    }

    /// Sum of the distances of closest hits.
    pub fn distances(&self) -> f64 {
        (0..self.t.len()).filter(|&i| self.hit(i, false)).map(|i| f64::from(self.t[i])).sum()
    }
}

pub(crate) fn sub(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(crate) fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(crate) fn normalize(a: [f32; 3]) -> [f32; 3] {
    let length = dot(a, a).sqrt();
    a.map(|x| x / length)
}
