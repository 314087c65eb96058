//! Four triangles.

use mobula_simd::{F32Lanes, I32Lanes, MaskLanes, Token};

use super::block::{BLOCK, Block};
use super::{Bounds, Bvh, Join};
use crate::kernel::sub;
use crate::kernel::triangle::{ShearedRay, triangle};
use crate::rays::load3;
use crate::traverse::SingleRay;
use crate::{NO_HIT, Properties, Rays};

/// Four triangles by corner, axis, and place.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub struct TriangleBlock {
    corners: [[[f32; BLOCK]; 3]; 3],
    ids: [u32; BLOCK],
}

impl Bvh<TriangleBlock> {
    /// Builds over triangles `0..count`, whose ids are `first_id..first_id + count`. Those with a corner that is not
    /// finite or without area (two corners equal) are left out; [`primitives`](Bvh::primitives) says how many are in.
    pub fn triangles(
        count: usize,
        first_id: u32,
        join: &impl Join,
        corners: impl Fn(usize) -> [[f32; 3]; 3] + Sync,
    ) -> Self {
        let bounds = |i| {
            let [a, b, c] = corners(i);
            let finite = [a, b, c].iter().flatten().all(|x| x.is_finite());
            (finite && a != b && b != c && c != a).then(|| Bounds::of_points(&[a, b, c]))
        };
        Self::build(count, join, bounds, |indices| {
            let mut block = TriangleBlock { corners: [[[f32::NAN; BLOCK]; 3]; 3], ids: [NO_HIT; BLOCK] };
            for (place, &index) in indices.iter().enumerate() {
                for (corner, point) in corners(index as usize).into_iter().enumerate() {
                    for (axis, x) in point.into_iter().enumerate() {
                        block.corners[corner][axis][place] = x;
                    }
                }
                block.ids[place] = first_id + index;
            }
            block
        })
    }
}

impl Block for TriangleBlock {
    type Prepared<T: Token> = [[T::F32; 3]; 3];

    #[inline(always)]
    fn ids(&self) -> &[u32; BLOCK] {
        &self.ids
    }

    fn can_hoist<const N: usize>(rays: &Rays<N>) -> bool {
        rays.properties().contains(Properties::COMMON_ORIGIN | Properties::HAVE_SHEARS | Properties::CONSTANT_AXIS)
    }

    #[inline(always)]
    fn derive<T: Token, const N: usize>(token: T, rays: &mut Rays<N>) {
        rays.shears(token);
    }

    #[inline(always)]
    fn prepare<T: Token, const N: usize, const HOISTED: bool>(
        &self,
        token: T,
        i: usize,
        rays: &Rays<N>,
    ) -> [[T::F32; 3]; 3] {
        let first = rays.range().start;
        let axis = if HOISTED { rays.axes()[first] as usize % 3 } else { 2 };
        // Hoisted: relative to the origin, the dominant axis last. Otherwise as they are.
        self.corners.map(|corner| {
            [(axis + 1) % 3, (axis + 2) % 3, axis].map(|k| {
                let x = corner[k][i];
                token.splat(if HOISTED { x - rays.origins()[k][first] } else { x })
            })
        })
    }

    #[inline(always)]
    fn test<T: Token, const N: usize, const HOISTED: bool>(
        token: T,
        corners: &[[T::F32; 3]; 3],
        rays: &Rays<N>,
        at: usize,
    ) -> (T::Mask, T::F32) {
        let shear = rays.shear_columns();
        let (t_min, t_max) = (token.load(&rays.t_min()[..], at), token.load(&rays.t_max[..], at));
        let shear = [token.load(&shear[0][..], at), token.load(&shear[1][..], at)];
        if HOISTED {
            let axis = rays.axes()[rays.range().start] as usize % 3;
            let forward = token.load(&rays.directions()[axis][..], at);
            return triangle(token, *corners, &ShearedRay { shear, forward, t_min, t_max });
        }
        let origin = load3(token, rays.origins(), at);
        let direction = load3(token, rays.directions(), at);
        let axes = token.load_u32(&rays.axes()[..], at);
        let mut hit = token.mask(0);
        let mut t = token.splat(0.0);
        for axis in 0..3 {
            let lanes = axes.eq(token.splat_i32(axis as i32));
            if lanes.any() {
                let [a, b, c] = *corners;
                let permute = |v: [T::F32; 3]| [v[(axis + 1) % 3], v[(axis + 2) % 3], v[axis]];
                let relative = [permute(sub(a, origin)), permute(sub(b, origin)), permute(sub(c, origin))];
                let ray = ShearedRay { shear, forward: direction[axis], t_min, t_max };
                let (found, distance) = triangle(token, relative, &ray);
                hit = hit | (found & lanes);
                t = distance.select(lanes, t);
            }
        }
        (hit, t)
    }

    #[inline(always)]
    fn test_single<T: Token>(&self, token: T, ray: &SingleRay<T>, i: usize) -> (T::Mask, T::F32) {
        let corners = self.corners.map(|corner| {
            [(ray.axis + 1) % 3, (ray.axis + 2) % 3, ray.axis]
                .map(|k| token.load(&corner[k % 3][..], i) - ray.origin[k % 3])
        });
        let sheared = ShearedRay {
            shear: ray.shear,
            forward: ray.direction[ray.axis % 3],
            t_min: ray.t_min,
            t_max: ray.t_max,
        };
        triangle(token, corners, &sheared)
    }
}
