//! Four spheres.

use bytemuck::Zeroable;
use mobula_simd::{F32Lanes, Token};

use super::Bounds;
use super::block::{BLOCK, Block};
use super::bounds::FOUR;
use crate::kernel::few::FewRays;
use crate::kernel::group_shears::GroupShears;
use crate::kernel::outline::Outlines;
use crate::kernel::sphere::{RADII, sphere};
use crate::rays::AXES;
use crate::vector::{load3, splat3, sub};
use crate::{NO_HIT, Properties, Rays};

/// Four spheres: centres by axis, radii, and what says which spheres they are.
#[derive(Clone, Copy, Debug, Zeroable)]
#[repr(C, align(16))]
pub struct SphereBlock<I = OwnIds> {
    center: [[f32; BLOCK]; 3],
    radius: [f32; BLOCK],
    ids: I,
}

/// What says which spheres those of a block are.
pub trait SphereIds: Copy + Send + Sync + Zeroable + 'static {
    /// Of no spheres.
    const NONE: Self;

    /// The sphere at a place of the block has this id.
    fn set(&mut self, place: usize, id: u32);

    /// The ids of the spheres of block `number`, whose unused places have the radius NaN.
    fn get(&self, number: usize, radius: &[f32; BLOCK]) -> [u32; BLOCK];
}

/// An id for each sphere.
pub type OwnIds = [u32; BLOCK];

impl SphereIds for OwnIds {
    const NONE: Self = [NO_HIT; BLOCK];

    #[inline(always)]
    fn set(&mut self, place: usize, id: u32) {
        self[place] = id;
    }

    #[inline(always)]
    fn get(&self, _number: usize, _radius: &[f32; BLOCK]) -> [u32; BLOCK] {
        *self
    }
}

/// Ids are places, four a block: they take no memory, and a block fills a cache line.
#[derive(Clone, Copy, Debug, Zeroable)]
#[repr(align(64))]
pub struct Places;

impl SphereIds for Places {
    const NONE: Self = Self;

    fn set(&mut self, _place: usize, _id: u32) {}

    #[inline(always)]
    fn get(&self, number: usize, radius: &[f32; BLOCK]) -> [u32; BLOCK] {
        let first = (number * BLOCK) as u32;
        [0, 1, 2, 3].map(|i| if radius[i].is_nan() { NO_HIT } else { first + i as u32 })
    }
}

impl SphereBlock {
    /// The same spheres without their ids.
    #[inline(always)]
    pub(crate) fn placed(&self) -> SphereBlock<Places> {
        let Self { center, radius, .. } = *self;
        SphereBlock { center, radius, ids: Places }
    }
}

impl<I: SphereIds> SphereBlock<I> {
    /// The sphere at a place: x, y, z of its centre, and its radius.
    ///
    /// # Panics
    /// If there is no such place.
    pub fn sphere(&self, place: usize) -> [f32; 4] {
        let [x, y, z] = self.center.map(|row| row[place]);
        [x, y, z, self.radius[place]]
    }
}

impl<I: SphereIds> Block for SphereBlock<I> {
    /// `[x, y, z, radius]`.
    type Primitive = [f32; 4];
    const EMPTY: Self = Self { center: [[f32::NAN; BLOCK]; 3], radius: [f32::NAN; BLOCK], ids: I::NONE };
    const COMPACT: bool = true;
    const NOWHERE: [f32; 4] = [f32::NAN; 4];

    /// Vectors from the centres to the common origin, or the centres; radii.
    type Prepared = ([[f32; BLOCK]; 3], [f32; BLOCK]);

    #[inline(always)]
    fn bounds(&[x, y, z, r]: &[f32; 4]) -> Option<Bounds> {
        let (low, high) = ([x - r, y - r, z - r], [x + r, y + r, z + r]);
        let finite = low.iter().chain(&high).all(|x| x.is_finite());
        (RADII.contains(&r) && finite).then(|| Bounds::of_points(&[low, high]).outward())
    }

    #[inline(always)]
    fn set(&mut self, place: usize, id: u32, &[x, y, z, r]: &[f32; 4]) {
        (self.center[0][place], self.center[1][place], self.center[2][place]) = (x, y, z);
        self.radius[place] = r;
        self.ids.set(place, id);
    }

    #[inline(always)]
    fn whole(&self) -> Bounds {
        let mut bounds = Bounds::EMPTY;
        let radius = FOUR.load(&self.radius, 0);
        for axis in 0..3 {
            let center = FOUR.load(&self.center[axis], 0);
            let (mut lows, mut highs) = ([0.0; BLOCK], [0.0; BLOCK]);
            (center - radius).store(&mut lows, 0);
            (center + radius).store(&mut highs, 0);
            // NaN, in unused places, is passed over.
            bounds.low[axis] = lows.into_iter().fold(f32::INFINITY, |a, b| if b < a { b } else { a });
            bounds.high[axis] = highs.into_iter().fold(f32::NEG_INFINITY, |a, b| if b > a { b } else { a });
        }
        // Steps outwards keep order: one of all is the same as one of each.
        if bounds.low[0] <= bounds.high[0] { bounds.outward() } else { Bounds::EMPTY }
    }

    #[inline(always)]
    fn ids(&self, number: usize) -> [u32; BLOCK] {
        self.ids.get(number, &self.radius)
    }

    #[inline(always)]
    fn prepare<const N: usize, const COMMON_ORIGIN: bool>(&self, rays: &Rays<N>) -> Self::Prepared {
        let mut center = self.center;
        if COMMON_ORIGIN {
            let first = rays.range().start;
            for (row, origin) in center.iter_mut().zip(rays.origins()) {
                for x in row {
                    *x = origin[first] - *x;
                }
            }
        }
        (center, self.radius)
    }

    #[inline(always)]
    fn touched<T: Token, const N: usize>(
        token: T,
        (center, radius): &Self::Prepared,
        axis: usize,
        shears: &GroupShears,
    ) -> [u32; BLOCK] {
        let outlines = Outlines::new(center, radius, AXES[axis % 3], shears);
        let mut touched = [0; BLOCK];
        for (i, touched) in touched.iter_mut().enumerate() {
            if outlines.may_be_hit(i) {
                *touched = outlines.groups::<T, N>(token, i, shears);
            }
        }
        touched
    }

    #[inline(always)]
    fn test<T: Token, const N: usize, const COMMON_ORIGIN: bool, const OWN_AXES: bool>(
        token: T,
        (center, radius): &Self::Prepared,
        i: usize,
        _axis: usize,
        rays: &Rays<N>,
        at: usize,
        among: T::Mask,
    ) -> (T::Mask, T::F32) {
        let (t_min, t_max) = (token.load(&rays.t_min()[..], at), token.load(&rays.t_max[..], at));
        let direction = load3(token, rays.directions(), at);
        let center = splat3(token, [center[0][i], center[1][i], center[2][i]]);
        let center = if COMMON_ORIGIN { center } else { sub(load3(token, rays.origins(), at), center) };
        let radius = token.splat(radius[i]);
        let radius2 = radius * radius;
        if rays.properties().contains(Properties::NORMALIZED_DIRECTIONS) {
            sphere::<T, true>(token, among, center, radius2, direction, t_min, t_max)
        } else {
            sphere::<T, false>(token, among, center, radius2, direction, t_min, t_max)
        }
    }

    #[inline(always)]
    fn test_few<T: Token>(&self, token: T, rays: &FewRays<T>, i: usize) -> (T::Mask, T::F32) {
        let [x, y, z] = &self.center;
        let center = sub(rays.origin, [token.repeat(x, i), token.repeat(y, i), token.repeat(z, i)]);
        let radius = token.repeat(&self.radius, i);
        let radius2 = radius * radius;
        if rays.unit {
            sphere::<T, true>(token, token.mask(u32::MAX), center, radius2, rays.direction, rays.t_min, rays.t_max)
        } else {
            sphere::<T, false>(token, token.mask(u32::MAX), center, radius2, rays.direction, rays.t_min, rays.t_max)
        }
    }
}
