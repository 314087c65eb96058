//! Points to shade: position and normals of a sub-packet's hits, and where rays that leave them start.

use glam::Vec3;

use crate::packet::{Column, Columns3, SubPacket, columns3, part, vec3};
use crate::scratch::ForWidth;

/// What materials and lights need of the hits of a sub-packet: one row a hit.
#[derive(Clone, Debug)]
pub struct Points {
    position: Columns3,
    normal: Columns3,
    geometric_normal: Columns3,
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
            magnitude: Column::new(width),
            count: 0,
        }
    }
}

fn copy(from: [&[f32]; 3], to: &mut Columns3) {
    for (to, from) in to.iter_mut().zip(from) {
        to[..from.len()].copy_from_slice(from);
    }
}

impl Points {
    /// Becomes the points of `hits`; all derived values stay in the packet for who else wants them.
    pub fn fill(&mut self, hits: &mut SubPacket<'_>) {
        self.count = hits.len();
        copy(hits.positions(), &mut self.position);
        copy(hits.forward_normals(), &mut self.normal);
        copy(hits.geometric_normals(), &mut self.geometric_normal);
        let magnitude = &mut self.magnitude[..hits.len()];
        hits.error_scales(magnitude);
        let (position, directions, distances) = (&self.position, &hits.directions(), hits.distances());
        for (i, magnitude) in magnitude.iter_mut().enumerate() {
            let travelled = vec3(directions, i).abs().max_element() * distances[i];
            let extent = *magnitude * 0.125;
            *magnitude = vec3(position, i).abs().max_element().max(travelled).max(extent);
        }
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

    /// Unit shading normals, on the side that the rays came from.
    pub fn normals(&self) -> [&[f32]; 3] {
        part(&self.normal, 0..self.count)
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
}
