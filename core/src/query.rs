//! Ray queries without packets: meshes in, rays in, hits out.
//!
//! ```
//! use mobula_core::query::{Hit, Mesh, Ray};
//!
//! let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
//! let scene = Mesh::new(&positions, &[[0, 1, 2], [0, 2, 3]]).build()?;
//! let rays = [Ray::new([0.75, 0.25, 2.0], [0.0, 0.0, -1.0]), Ray::new([5.0, 5.0, 2.0], [0.0, 0.0, -1.0])];
//! let mut hits = [Hit::NONE; 2];
//! scene.intersect(&rays, &mut hits);
//! assert!(hits[0].is_hit() && !hits[1].is_hit());
//! assert_eq!((hits[0].t, hits[0].geometry, hits[0].primitive), (2.0, 0, 0));
//! # Ok::<(), mobula_core::query::BuildError>(())
//! ```
//!
//! Any number of rays may be given at once. They are traced in packets inside: rays that follow one another in the slice and go
//! about the same way, above all from one origin, are traced fastest; rays that have nothing in common are found out and traced
//! as a stream. The hits are the same whatever the order, the number of rays in a call, and the instruction set within one
//! numeric family.

use alloc::vec::Vec;
use core::fmt;

use glam::Vec3;
use mobula_simd::AnyToken;

use crate::bvh::{Bvh, Join, Quality, Serial};
use crate::leaf::TriangleBlock;
use crate::{AnyHitPacket, NO_HIT, RayPacket};

/// Rays in a packet inside.
const WIDTH: usize = 256;
/// So few rays are traced one by one: a packet would be set up for hardly any.
const FEW: usize = 4;

/// A ray: the half-open interval `(t_min, t_max]` of `origin + t * direction`. One that starts on a triangle, as far as its
/// coordinates can tell, meets it at t = 0: with `t_min` 0 it is not hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where it starts.
    pub origin: [f32; 3],
    /// Where it goes. Its length is the unit of `t`; rays with one below 2^-102 (2e-31) or an infinite one hit nothing.
    pub direction: [f32; 3],
    /// Near end of the interval, not in it.
    pub t_min: f32,
    /// Far end of the interval, in it.
    pub t_max: f32,
}

impl Ray {
    /// The ray from `origin` along `direction`, with the interval `(0, inf]`.
    pub const fn new(origin: [f32; 3], direction: [f32; 3]) -> Self {
        Self { origin, direction, t_min: 0.0, t_max: f32::INFINITY }
    }
}

/// What a ray hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance, in lengths of the ray's direction; infinite if nothing was hit.
    pub t: f32,
    /// Weight of the triangle's second corner; the first has `1 - u - v`.
    pub u: f32,
    /// Weight of the triangle's third corner.
    pub v: f32,
    /// Geometric normal, of length 1: towards the side from which the corners are counter-clockwise. Zero if nothing was hit.
    pub normal: [f32; 3],
    /// Place of the mesh in the list that the scene was built from; [`NO_HIT`] if nothing was hit.
    pub geometry: u32,
    /// Place of the triangle in its mesh; [`NO_HIT`] if nothing was hit.
    pub primitive: u32,
}

impl Hit {
    /// Nothing was hit.
    pub const NONE: Self =
        Self { t: f32::INFINITY, u: 0.0, v: 0.0, normal: [0.0; 3], geometry: NO_HIT, primitive: NO_HIT };

    /// Was anything hit?
    #[must_use]
    pub const fn is_hit(&self) -> bool {
        self.primitive != NO_HIT
    }
}

/// Triangles with shared corners.
#[derive(Clone, Copy, Debug)]
pub struct Mesh<'a> {
    positions: &'a [[f32; 3]],
    indices: &'a [[u32; 3]],
}

impl<'a> Mesh<'a> {
    /// Corner positions, and the indices of three of them a triangle.
    pub const fn new(positions: &'a [[f32; 3]], indices: &'a [[u32; 3]]) -> Self {
        Self { positions, indices }
    }

    /// The scene that is this mesh alone.
    ///
    /// # Errors
    /// If an index is out of range, or there are 2^32 - 1 triangles or more.
    pub fn build(self) -> Result<Scene, BuildError> {
        Scene::build(&[self])
    }
}

/// Meshes that no scene can be built of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum BuildError {
    /// A triangle has a corner that its mesh does not have.
    IndexOutOfRange {
        /// Place of the mesh.
        geometry: usize,
        /// Place of the triangle.
        primitive: usize,
        /// The index.
        index: u32,
    },
    /// More triangles or corners than there are ids.
    TooManyTriangles,
}

impl fmt::Display for BuildError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::IndexOutOfRange { geometry, primitive, index } => {
                write!(f, "triangle {primitive} of mesh {geometry} has corner {index}, which the mesh does not have")
            }
            Self::TooManyTriangles => f.write_str("2^32 - 1 triangles or corners, or more: more than there are ids"),
        }
    }
}

impl core::error::Error for BuildError {}

/// Meshes, ready for rays. It holds a copy of them: 12 bytes a corner and 12 a triangle, and about 60 a triangle for the tree.
#[derive(Clone, Debug)]
pub struct Scene {
    token: AnyToken,
    bvh: Bvh<TriangleBlock>,
    positions: Vec<[f32; 3]>,
    /// Into the positions of all meshes.
    triangles: Vec<[u32; 3]>,
    /// Where each mesh's triangles start.
    first: Vec<u32>,
}

// The methods that trace are `inline`, so that the crates that call them compile the traversals, and this one does not.
impl Scene {
    /// Builds over some meshes, whose places are the geometry ids of hits. Triangles with a corner that is not finite, or without
    /// area, are left out: no ray hits them.
    ///
    /// # Errors
    /// If an index is out of range, or there are 2^32 - 1 triangles or corners, or more.
    pub fn build(meshes: &[Mesh<'_>]) -> Result<Self, BuildError> {
        Self::build_with(meshes, AnyToken::detect(), &Serial)
    }

    /// As [`build`](Self::build), with the threads of `join`, and for the level of `token`.
    ///
    /// # Errors
    /// As [`build`](Self::build).
    pub fn build_with(meshes: &[Mesh<'_>], token: AnyToken, join: &impl Join) -> Result<Self, BuildError> {
        let count = |of: fn(&Mesh<'_>) -> usize| {
            let all = meshes.iter().try_fold(0usize, |sum, mesh| sum.checked_add(of(mesh)));
            all.filter(|&count| count < NO_HIT as usize).ok_or(BuildError::TooManyTriangles)
        };
        let mut positions = Vec::with_capacity(count(|mesh| mesh.positions.len())?);
        let mut triangles = Vec::with_capacity(count(|mesh| mesh.indices.len())?);
        let mut first = Vec::with_capacity(meshes.len());
        for (geometry, mesh) in meshes.iter().enumerate() {
            first.push(triangles.len() as u32);
            let shift = positions.len() as u32;
            for (primitive, corners) in mesh.indices.iter().enumerate() {
                if let Some(&index) = corners.iter().find(|&&index| index as usize >= mesh.positions.len()) {
                    return Err(BuildError::IndexOutOfRange { geometry, primitive, index });
                }
                triangles.push(corners.map(|index| index + shift));
            }
            positions.extend_from_slice(mesh.positions);
        }
        let corners = |i: usize| triangles[i].map(|index| positions[index as usize]);
        let bvh = Bvh::build(triangles.len(), 0, Quality::Good, join, corners);
        Ok(Self { token, bvh, positions, triangles, first })
    }

    /// How many triangles were left out.
    #[must_use]
    pub fn left_out(&self) -> usize {
        self.triangles.len() - self.bvh.primitives()
    }

    /// Least and greatest corner of all triangles that were not left out; `None` if there are none.
    #[must_use]
    pub fn bounds(&self) -> Option<[[f32; 3]; 2]> {
        let bounds = self.bvh.bounds();
        let corner = |[x, y, z, _]: [f32; 4]| [x, y, z];
        bounds.is_finite().then(|| [corner(bounds.low), corner(bounds.high)])
    }

    /// Finds the nearest hit of each ray; on equal distance the lower pair of geometry and primitive.
    ///
    /// # Panics
    /// If there are not as many hits as rays.
    #[inline]
    pub fn intersect(&self, rays: &[Ray], hits: &mut [Hit]) {
        assert_eq!(rays.len(), hits.len(), "as many hits as rays");
        let mut packet = None;
        let mut near = 0;
        for (rays, hits) in rays.chunks(WIDTH).zip(hits.chunks_mut(WIDTH)) {
            if rays.len() < FEW {
                for (ray, hit) in rays.iter().zip(hits) {
                    *hit = self.intersect_one(ray).unwrap_or(Hit::NONE);
                }
                continue;
            }
            let packet = packet.get_or_insert_with(RayPacket::<WIDTH>::default);
            packet.reset(0..rays.len());
            fill(packet, rays);
            self.bvh.intersect(self.token, packet);
            for (i, (ray, hit)) in rays.iter().zip(hits).enumerate() {
                *hit = self.hit(ray, packet.t_max[i], packet.hits.primitive[i], &mut near);
            }
        }
    }

    /// Finds the nearest hit of a ray: the same as [`intersect`](Self::intersect) finds.
    #[inline]
    #[must_use]
    pub fn intersect_one(&self, ray: &Ray) -> Option<Hit> {
        let Ray { origin, direction, t_min, t_max } = *ray;
        let (t, id) = self.bvh.intersect_one(self.token, origin.into(), direction.into(), [t_min, t_max])?;
        Some(self.hit(ray, t, id, &mut 0))
    }

    /// Finds which rays hit anything.
    ///
    /// # Panics
    /// If there are not as many answers as rays.
    #[inline]
    pub fn occluded(&self, rays: &[Ray], occluded: &mut [bool]) {
        assert_eq!(rays.len(), occluded.len(), "as many answers as rays");
        let mut packet = None;
        for (rays, occluded) in rays.chunks(WIDTH).zip(occluded.chunks_mut(WIDTH)) {
            if rays.len() < FEW {
                for (ray, occluded) in rays.iter().zip(occluded) {
                    *occluded = self.occluded_one(ray);
                }
                continue;
            }
            let packet = packet.get_or_insert_with(AnyHitPacket::<WIDTH>::default);
            packet.reset(0..rays.len());
            fill(packet, rays);
            self.bvh.occlude(self.token, packet);
            for (i, (ray, occluded)) in rays.iter().zip(occluded).enumerate() {
                // A ray that reaches nowhere looks as if it were done.
                *occluded = packet.occluded(i) && ray.t_max != f32::NEG_INFINITY;
            }
        }
    }

    /// Does a ray hit anything?
    #[inline]
    #[must_use]
    pub fn occluded_one(&self, ray: &Ray) -> bool {
        let Ray { origin, direction, t_min, t_max } = *ray;
        self.bvh.occluded_one(self.token, origin.into(), direction.into(), [t_min, t_max])
    }

    /// What is to be told of the hit of triangle `id`. `near`: the mesh to look at first.
    fn hit(&self, ray: &Ray, t: f32, id: u32, near: &mut usize) -> Hit {
        if id == NO_HIT {
            return Hit::NONE;
        }
        let holds = |geometry: usize| {
            let end = self.first.get(geometry + 1).copied().unwrap_or(NO_HIT);
            self.first.get(geometry).is_some_and(|&first| first <= id && id < end)
        };
        if !holds(*near) {
            *near = self.first.partition_point(|&first| first <= id) - 1;
        }
        let corners = self.triangles[id as usize].map(|index| Vec3::from(self.positions[index as usize]));
        let [u, v] = weights(corners, ray);
        let normal = normal(corners);
        Hit { t, u, v, normal, geometry: *near as u32, primitive: id - self.first[*near] }
    }
}

/// Puts rays into a packet, which is told if they start at one point.
fn fill<const N: usize>(packet: &mut crate::Rays<N>, rays: &[Ray]) {
    for (i, ray) in rays.iter().enumerate() {
        packet.set_ray(i, ray.origin.into(), ray.direction.into());
        packet.set_interval(i, ray.t_min, ray.t_max);
    }
    let first = rays[0].origin.map(f32::to_bits);
    if rays.iter().all(|ray| ray.origin.map(f32::to_bits) == first) {
        packet.promise(crate::Properties::COMMON_ORIGIN);
    }
}

/// Weights of the second and the third corner where a ray hits a triangle, each in 0..=1: ratios of the volumes that the ray
/// and each edge span. In f64, where products of f32 neither overflow nor vanish.
fn weights(corners: [Vec3; 3], ray: &Ray) -> [f32; 2] {
    let direction = ray.direction.map(f64::from);
    let [a, b, c] = corners.map(|p| [0, 1, 2].map(|k| f64::from(p[k]) - f64::from(ray.origin[k])));
    let volume = |p: [f64; 3], q: [f64; 3]| dot(direction, cross(p, q));
    let volumes = [volume(b, c), volume(c, a), volume(a, b)];
    let whole: f64 = volumes.iter().sum();
    if whole == 0.0 || !whole.is_finite() {
        return [1.0 / 3.0; 2];
    }
    let u = ((volumes[1] / whole) as f32).clamp(0.0, 1.0);
    [u, ((volumes[2] / whole) as f32).clamp(0.0, 1.0).min(1.0 - u)]
}

/// Unit normal of a triangle. In f64 for the same reason.
fn normal([a, b, c]: [Vec3; 3]) -> [f32; 3] {
    let edge = |p: Vec3| [0, 1, 2].map(|k| f64::from(p[k]) - f64::from(a[k]));
    let n = cross(edge(b), edge(c));
    let length = libm::sqrt(dot(n, n));
    if length > 0.0 { n.map(|x| (x / length) as f32) } else { [0.0; 3] }
}

fn cross(p: [f64; 3], q: [f64; 3]) -> [f64; 3] {
    [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]]
}

fn dot(p: [f64; 3], q: [f64; 3]) -> f64 {
    p[0] * q[0] + p[1] * q[1] + p[2] * q[2]
}
