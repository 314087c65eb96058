//! Trees in a space of their own: rays are moved into it, and what they find back. Distances are the same in both.

use alloc::vec::Vec;

use mobula_simd::AnyToken;

use super::paths::Paths;
use super::{intersect, occlude};
use crate::bvh::Tree;
use crate::sink::Opacity;
use crate::{AnyHitPacket, NO_HIT, Properties, RayPacket, Rays};

/// The way from the space of rays into that of a tree, and the part of the former in which the tree is seen.
#[derive(Clone, Debug, PartialEq)]
pub struct Local {
    /// A point (x, y, z) is at the products of these rows with (x, y, z, 1).
    rows: [[f64; 4]; 3],
    /// A point is seen where no product of these with (x, y, z, 1) is above 0.
    cuts: Vec<[f64; 4]>,
}

impl Local {
    /// Points are moved by `rows`, times (x, y, z, 1), and cut off where one of `cuts` times (x, y, z, 1) is above 0.
    pub fn new(rows: [[f64; 4]; 3], cuts: Vec<[f64; 4]>) -> Self {
        Self { rows, cuts }
    }

    /// As [`Bvh::intersect`](crate::bvh::WideBvh::intersect). `moved`, of at least as many rays, is room for rays that are moved:
    /// walks need not be compiled for more than its width.
    ///
    /// # Panics
    /// If it is of fewer.
    pub fn intersect<B: Tree, const N: usize, const M: usize>(
        &self,
        tree: &B,
        token: AnyToken,
        packet: &mut RayPacket<N>,
        moved: &mut RayPacket<M>,
    ) -> Paths {
        let (rays, hits) = moved.split();
        self.enter(packet, rays);
        let range = packet.range();
        // A lower id at the distance of an earlier hit counts: but not beyond a cut.
        let before = rays.t_max;
        for i in range.clone() {
            hits.primitive[i] = if before[i] < packet.t_max[i] { NO_HIT } else { packet.hits.primitive[i] };
        }
        let ids = hits.primitive;
        let paths = intersect(tree, token, moved);
        for i in range {
            if moved.t_max[i] < before[i] || moved.hits.primitive[i] != ids[i] {
                packet.t_max[i] = moved.t_max[i];
                packet.hits.primitive[i] = moved.hits.primitive[i];
            }
        }
        paths
    }

    /// As [`Bvh::occlude`](crate::bvh::WideBvh::occlude), or with an opacity as
    /// [`occlude_through`](crate::bvh::WideBvh::occlude_through).
    ///
    /// # Panics
    /// If `moved` is of fewer rays.
    pub fn occlude<B: Tree, const N: usize, const M: usize>(
        &self,
        tree: &B,
        token: AnyToken,
        packet: &mut AnyHitPacket<N>,
        moved: &mut AnyHitPacket<M>,
        opacity: Option<&dyn Opacity>,
    ) -> Paths {
        let range = packet.range();
        {
            let (rays, depth) = moved.split();
            self.enter(packet, rays);
            depth[range.clone()].copy_from_slice(&packet.depth()[range.clone()]);
        }
        let paths = occlude(tree, token, moved, opacity);
        let (rays, depth) = packet.split();
        for i in range.clone() {
            if moved.occluded(i) {
                rays.t_max[i] = f32::NEG_INFINITY;
            }
        }
        depth[range.clone()].copy_from_slice(&moved.depth()[range]);
        paths
    }

    /// Moves rays into the space, and cuts their intervals.
    fn enter<const N: usize, const M: usize>(&self, from: &Rays<N>, to: &mut Rays<M>) {
        let range = from.range();
        to.reset(range.clone(), Properties::empty());
        if range.is_empty() {
            return;
        }
        let [x, y, z] = self.rows;
        let point = |[px, py, pz]: [f32; 3], row: [f64; 4]| {
            (row[0] * f64::from(px) + row[1] * f64::from(py) + row[2] * f64::from(pz) + row[3]) as f32
        };
        let turned = |[dx, dy, dz]: [f32; 3], row: [f64; 4]| {
            (row[0] * f64::from(dx) + row[1] * f64::from(dy) + row[2] * f64::from(dz)) as f32
        };
        for i in range.clone() {
            let direction = from.ray(i).1.to_array();
            let moved = [turned(direction, x), turned(direction, y), turned(direction, z)];
            for (column, value) in to.directions_mut().iter_mut().zip(moved) {
                column[i] = value;
            }
        }
        if from.properties().contains(Properties::COMMON_ORIGIN) {
            let origin = from.ray(range.start).0.to_array();
            to.set_common_origin([point(origin, x), point(origin, y), point(origin, z)].into());
        } else {
            for i in range.clone() {
                let origin = from.ray(i).0.to_array();
                let moved = [point(origin, x), point(origin, y), point(origin, z)];
                for (column, value) in to.origins_mut().iter_mut().zip(moved) {
                    column[i] = value;
                }
            }
        }
        to.t_min_mut()[range.clone()].copy_from_slice(&from.t_min()[range.clone()]);
        to.t_max[range.clone()].copy_from_slice(&from.t_max[range.clone()]);
        for cut in &self.cuts {
            for i in range.clone() {
                let (origin, direction) = from.ray(i);
                let (above, slope) = (point(origin.to_array(), *cut), turned(direction.to_array(), *cut));
                // Not minus infinity, which says that something is in the way.
                let t = (-above / slope).max(f32::MIN);
                if slope > 0.0 {
                    to.t_max[i] = if t < to.t_max[i] { t } else { to.t_max[i] };
                } else if slope < 0.0 {
                    let t_min = to.t_min()[i];
                    to.t_min_mut()[i] = if t > t_min { t } else { t_min };
                } else if above > 0.0 {
                    to.t_max[i] = f32::MIN;
                }
            }
        }
    }
}
