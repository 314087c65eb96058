//! Points to shade: position and normals of a sub-packet's hits, and where rays that leave them start.

use std::ops::Range;

use glam::Vec3;
use mobula_core::rays::vec3;
use mobula_core::{Column, Columns3, SubPacket};

use crate::stack::Context;

/// What materials and lights need of the hits of a sub-packet, in the rows of its range.
#[derive(Clone, Debug, Default)]
pub struct Points<const N: usize> {
    /// Where the rays hit.
    pub position: Columns3<N>,
    normal: Columns3<N>,
    geometric_normal: Columns3<N>,
    /// Size of the numbers that the hit was computed from.
    magnitude: Column<f32, N>,
    range: Range<usize>,
}

/// The unit of [`Points::offset`]: 2^-18, or 64 times the rounding error of one f32 operation.
const OFFSET: f32 = 1.0 / 262_144.0;

impl<const N: usize> Points<N> {
    /// Becomes the points of `hits`; all derived values stay in the packet for who else wants them.
    pub fn fill(&mut self, context: &Context<'_, N>, hits: &mut SubPacket<'_, N>) {
        self.range = hits.range();
        let scene = context.scene;
        let range = hits.range();
        let copy = |from: &Columns3<N>, to: &mut Columns3<N>| {
            for (to, from) in to.iter_mut().zip(from) {
                to[range.clone()].copy_from_slice(&from[range.clone()]);
            }
        };
        copy(hits.positions(), &mut self.position);
        copy(hits.forward_normals(scene.surface()), &mut self.normal);
        copy(hits.geometric_normals(scene.surface()), &mut self.geometric_normal);
        let mut near = 0;
        for i in range {
            let (_, direction) = hits.ray(i);
            let travelled = direction.abs().max_element() * hits.t_max[i];
            let extent = scene.geometry().extent(hits.hits.primitive[i], &mut near) * 0.125;
            let magnitude = vec3(&self.position, i).abs().max_element().max(travelled).max(extent);
            self.magnitude[i] = magnitude;
        }
    }

    /// The rows that are filled.
    pub fn range(&self) -> Range<usize> {
        self.range.clone()
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
