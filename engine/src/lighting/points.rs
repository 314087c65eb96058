//! Points to light: positions and normals of hits, and where rays that leave them start.

use std::ops::Range;

use glam::Vec3;
use mobula_core::simd::{F32Lanes, Task, Token};

use crate::lanes::{add, greatest, load3, scale};
use crate::packet::{Column, Columns3, SubPacket, columns3, part, part_mut, vec3};
use crate::scratch::ForWidth;

/// What materials and lights need of hits: one row a hit.
#[derive(Debug)]
pub struct Points {
    position: Columns3,
    normal: Columns3,
    geometric_normal: Columns3,
    samples: [Column<u32>; 2],
    /// Size of the numbers that the hit was computed from.
    magnitude: Column<f32>,
    count: usize,
}

/// The unit of [`Points::offset`]: 2^-18, or 64 times the rounding error of one f32 operation.
const OFFSET: f32 = 1.0 / 262_144.0;

impl ForWidth for Points {
    fn for_width(width: usize) -> Self {
        Self {
            position: columns3(width),
            normal: columns3(width),
            geometric_normal: columns3(width),
            samples: [Column::new(width), Column::new(width)],
            magnitude: Column::new(width),
            count: 0,
        }
    }
}

impl Points {
    /// There are none from now on.
    pub fn clear(&mut self) {
        self.count = 0;
    }

    /// Adds those of `hits`; all derived values stay in the packet for who else wants them.
    ///
    /// # Panics
    /// If there are more than the width.
    pub fn append(&mut self, hits: &mut SubPacket<'_>) {
        let rows = self.count..self.count + hits.len();
        let copy = |from: [&[f32]; 3], to: &mut Columns3| {
            part_mut(to, rows.clone()).into_iter().zip(from).for_each(|(to, from)| to.copy_from_slice(from));
        };
        copy(hits.positions(), &mut self.position);
        copy(hits.forward_normals(), &mut self.normal);
        copy(hits.geometric_normals(), &mut self.geometric_normal);
        for (to, from) in self.samples.iter_mut().zip(hits.samples()) {
            to[rows.clone()].copy_from_slice(from);
        }
        let extents = hits.error_scales();
        self.magnitude[rows.clone()].copy_from_slice(extents);
        let (directions, distances) = (hits.directions(), hits.distances());
        hits.token().run(Magnitudes { points: self, rows: rows.clone(), directions, distances });
        self.count = rows.end;
    }

    /// Number of points.
    #[inline(always)]
    pub fn len(&self) -> usize {
        self.count
    }

    /// Are there none?
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Where the rays hit.
    pub fn positions(&self) -> [&[f32]; 3] {
        part(&self.position, 0..self.count)
    }

    /// The [samples](crate::packet::Packet::samples) that the rays belong to.
    pub fn samples(&self) -> [&[u32]; 2] {
        let [seeds, numbers] = &self.samples;
        [&seeds[..self.count], &numbers[..self.count]]
    }

    /// Unit shading normals, on the side that the rays came from.
    pub fn normals(&self) -> [&[f32]; 3] {
        part(&self.normal, 0..self.count)
    }

    /// Unit geometric normals, on the side that the rays came from.
    pub fn geometric_normals(&self) -> [&[f32]; 3] {
        part(&self.geometric_normal, 0..self.count)
    }

    /// Unit shading normal, on the side that the ray came from.
    #[inline(always)]
    pub fn normal(&self, i: usize) -> Vec3 {
        vec3(&self.normal, i)
    }

    /// Unit geometric normal, on the side that the ray came from.
    #[inline(always)]
    pub fn geometric_normal(&self, i: usize) -> Vec3 {
        vec3(&self.geometric_normal, i)
    }

    /// A start for rays that leave the surface on the side that the ray came from (`side` 1) or on the other (-1), or an
    /// end for rays that come from `distance` away: the position, moved along the geometric normal so far that rounding
    /// cannot put it on the other side.
    ///
    /// How far is that? Let e = 2^-24, the rounding of one operation. The position is `o + t d`. Rounding of its sum and
    /// product is at most e (|P| + 2 t|d|) a coordinate. `t` is a mean of corner depths relative to the origin: corners
    /// are subtracted from it (error e |v - o| <= e (t|d| + extent)), sheared and weighted with a handful of operations,
    /// so the plane is missed by less than about 16 e (t|d| + extent), *along the normal*: a grazing ray has a worse
    /// `t`, but moves along the surface. A ray back from a light at distance D suffers the same with D, and 2 e D from its
    /// own direction. All of that is below 64 e = 2^-18 times the largest of |P|, t|d| and D; the extent of a primitive
    /// enters with an eighth, since only a hit near one end of a long edge has nearly all of its error.
    #[inline(always)]
    pub fn offset(&self, i: usize, side: f32, distance: f32) -> Vec3 {
        let by = side * OFFSET * self.magnitude[i].max(distance);
        vec3(&self.position, i) + self.geometric_normal(i) * by
    }

    /// The [offsets](Self::offset) of a vector of points, the first of which is `at`.
    #[inline(always)]
    pub(crate) fn offsets<T: Token>(&self, token: T, at: usize, side: f32, distance: T::F32) -> [T::F32; 3] {
        let by = token.splat(side * OFFSET) * token.load(&self.magnitude, at).max(distance);
        add(load3(token, &self.position, at), scale(load3(token, &self.geometric_normal, at), by))
    }
}

/// Finds the [magnitudes](Points::magnitude) of some rows, in whose place are error scales.
struct Magnitudes<'a> {
    points: &'a mut Points,
    rows: Range<usize>,
    directions: [&'a [f32]; 3],
    distances: &'a [f32],
}

impl Task for Magnitudes<'_> {
    type Output = ();

    #[inline(always)]
    fn run<T: Token>(self, token: T) {
        let Self { points, rows, directions, distances } = self;
        let positions = part(&points.position, rows.clone());
        let magnitudes = &mut points.magnitude[rows.clone()];
        for at in (0..rows.len()).step_by(T::LANES) {
            let travelled = greatest(load3(token, &directions, at)) * token.load(distances, at);
            let extent = token.load(magnitudes, at) * token.splat(0.125);
            let magnitude = greatest(load3(token, &positions, at)).max(travelled).max(extent);
            magnitude.store(magnitudes, at);
        }
    }
}
