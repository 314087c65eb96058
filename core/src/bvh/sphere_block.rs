//! Four spheres.

use mobula_simd::Token;

use super::block::{BLOCK, Block};
use super::{Bounds, Bvh, Join};
use crate::kernel::sphere::sphere;
use crate::kernel::sub;
use crate::rays::load3;
use crate::traverse::SingleRay;
use crate::{NO_HIT, Properties, Rays};

/// Four spheres: centres by axis, radii.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(16))]
pub struct SphereBlock {
    center: [[f32; BLOCK]; 3],
    radius: [f32; BLOCK],
    ids: [u32; BLOCK],
}

impl Bvh<SphereBlock> {
    /// Builds over spheres `0..count` (`[x, y, z, radius]`), whose ids are `first_id..first_id + count`. Those that are
    /// not finite or whose radius is not positive are left out.
    pub fn spheres(count: usize, first_id: u32, join: &impl Join, sphere: impl Fn(usize) -> [f32; 4] + Sync) -> Self {
        let bounds = |i| {
            let [x, y, z, r] = sphere(i);
            let low = [x - r, y - r, z - r];
            let high = [x + r, y + r, z + r];
            let bounds = Bounds::of_points(&[low, high]);
            (r > 0.0 && low.iter().chain(&high).all(|x| x.is_finite())).then_some(bounds)
        };
        Self::build(count, join, bounds, |indices| {
            let mut block = SphereBlock {
                center: [[f32::NAN; BLOCK]; 3],
                radius: [f32::NAN; BLOCK],
                ids: [NO_HIT; BLOCK],
            };
            for (place, &index) in indices.iter().enumerate() {
                let [x, y, z, r] = sphere(index as usize);
                (block.center[0][place], block.center[1][place], block.center[2][place]) = (x, y, z);
                block.radius[place] = r;
                block.ids[place] = first_id + index;
            }
            block
        })
    }
}

/// A sphere for a packet: the vector from its centre to the common origin (hoisted), or its centre.
#[derive(Clone, Copy, Debug)]
pub struct Prepared<F> {
    center: [F; 3],
    radius2: F,
}

impl Block for SphereBlock {
    type Prepared<T: Token> = Prepared<T::F32>;

    #[inline(always)]
    fn ids(&self) -> &[u32; BLOCK] {
        &self.ids
    }

    fn can_hoist<const N: usize>(rays: &Rays<N>) -> bool {
        rays.properties().contains(Properties::COMMON_ORIGIN)
    }

    #[inline(always)]
    fn derive<T: Token, const N: usize>(_token: T, _rays: &mut Rays<N>) {}

    #[inline(always)]
    fn prepare<T: Token, const N: usize, const HOISTED: bool>(
        &self,
        token: T,
        i: usize,
        rays: &Rays<N>,
    ) -> Prepared<T::F32> {
        let first = rays.range().start;
        let center = core::array::from_fn(|k| {
            let x = self.center[k][i];
            token.splat(if HOISTED { rays.origins()[k][first] - x } else { x })
        });
        Prepared { center, radius2: token.splat(self.radius[i] * self.radius[i]) }
    }

    #[inline(always)]
    fn test<T: Token, const N: usize, const HOISTED: bool>(
        token: T,
        prepared: &Prepared<T::F32>,
        rays: &Rays<N>,
        at: usize,
    ) -> (T::Mask, T::F32) {
        let (t_min, t_max) = (token.load(&rays.t_min()[..], at), token.load(&rays.t_max[..], at));
        let direction = load3(token, rays.directions(), at);
        let center =
            if HOISTED { prepared.center } else { sub(load3(token, rays.origins(), at), prepared.center) };
        if rays.properties().contains(Properties::NORMALIZED_DIRECTIONS) {
            sphere::<T, true>(token, center, prepared.radius2, direction, t_min, t_max)
        } else {
            sphere::<T, false>(token, center, prepared.radius2, direction, t_min, t_max)
        }
    }

    #[inline(always)]
    fn test_single<T: Token>(&self, token: T, ray: &SingleRay<T>, i: usize) -> (T::Mask, T::F32) {
        let center = core::array::from_fn(|k| ray.origin[k] - token.load(&self.center[k][..], i));
        let radius = token.load(&self.radius[..], i);
        let radius2 = radius * radius;
        if ray.unit {
            sphere::<T, true>(token, center, radius2, ray.direction, ray.t_min, ray.t_max)
        } else {
            sphere::<T, false>(token, center, radius2, ray.direction, ray.t_min, ray.t_max)
        }
    }
}
