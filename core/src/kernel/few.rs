//! A few rays as leaves test them, each against four primitives at once: with 16 lanes four rays together.
//!
//! Where triangles cover a pixel or less, few rays of a packet come to a leaf. A vector of them would be nearly empty, and would be
//! tested once for each primitive.

use mobula_simd::{F32Lanes, Token};

use crate::vector::splat3;
use crate::{Column, Columns3, Properties, Rays};

/// Primitives that a ray is tested against at once.
const FOUR: usize = 4;

/// Rays of which each is in four lanes, lanes 4 k to 4 k + 3 ray k, or one ray in every lane.
#[derive(Clone, Copy, Debug)]
pub struct FewRays<T: Token> {
    /// Origins.
    pub origin: [T::F32; 3],
    /// Directions.
    pub direction: [T::F32; 3],
    /// See [`Rays::inverse_directions`].
    pub inverse: [T::F32; 3],
    /// See [`Rays::shears`].
    pub shear: [T::F32; 3],
    /// The dominant axis of all.
    pub axis: usize,
    /// If not all have the same: which have y, and which z. Then `axis` means nothing.
    pub own_axes: Option<[T::Mask; 2]>,
    /// Do the directions have length 1?
    pub unit: bool,
    /// Near ends of the intervals.
    pub t_min: T::F32,
    /// Far ends, lowered by hits if it is one ray.
    pub t_max: T::F32,
}

impl<T: Token> FewRays<T> {
    /// How many rays a vector takes.
    pub const COUNT: usize = if T::LANES < FOUR { 1 } else { T::LANES / FOUR };

    /// Up to [`COUNT`](Self::COUNT) rays by their numbers, whose inverse directions and shears are derived; lanes that are left
    /// over are the first ray's. `axis` is the dominant axis of all, if it is one.
    #[inline(always)]
    pub fn of<const N: usize>(token: T, rays: &Rays<N>, numbers: &[usize], axis: Option<usize>) -> Self {
        let own_axes = match axis {
            Some(_) => None,
            None => Some([have_axis(token, rays, numbers, 1), have_axis(token, rays, numbers, 2)]),
        };
        let origin = if rays.properties().contains(Properties::COMMON_ORIGIN) {
            splat3(token, rays.ray(rays.range().start).0.to_array())
        } else {
            fours3(token, rays.origins(), numbers)
        };
        Self {
            origin,
            direction: fours3(token, rays.directions(), numbers),
            inverse: fours3(token, rays.inverse_columns(), numbers),
            shear: fours3(token, rays.shear_columns(), numbers),
            axis: axis.unwrap_or(0),
            own_axes,
            unit: rays.properties().contains(Properties::NORMALIZED_DIRECTIONS),
            t_min: fours(token, rays.t_min(), numbers),
            t_max: fours(token, &rays.t_max, numbers),
        }
    }
}

/// The number of ray `k`, or where there is none, of the first.
#[inline(always)]
fn number<const N: usize>(numbers: &[usize], k: usize) -> usize {
    numbers[if k < numbers.len() { k } else { 0 }] % N
}

/// Values of some rays, each in four lanes.
#[inline(always)]
fn fours<T: Token, const N: usize>(token: T, column: &Column<f32, N>, numbers: &[usize]) -> T::F32 {
    let mut lanes = token.splat(column[number::<N>(numbers, 0)]);
    let mut k = 1;
    while k < FewRays::<T>::COUNT {
        let lanes_of_it = token.mask(0xf << (FOUR * k));
        lanes = token.splat(column[number::<N>(numbers, k)]).select(lanes_of_it, lanes);
        k += 1;
    }
    lanes
}

#[inline(always)]
fn fours3<T: Token, const N: usize>(token: T, columns: &Columns3<N>, numbers: &[usize]) -> [T::F32; 3] {
    let [x, y, z] = columns;
    [fours(token, x, numbers), fours(token, y, numbers), fours(token, z, numbers)]
}

/// The lanes of rays whose dominant axis is this.
#[inline(always)]
fn have_axis<T: Token, const N: usize>(token: T, rays: &Rays<N>, numbers: &[usize], axis: u32) -> T::Mask {
    let mut lanes = 0;
    let mut k = 0;
    while k < FewRays::<T>::COUNT {
        lanes |= u32::from(rays.axes()[number::<N>(numbers, k)] == axis) * (0xf << (FOUR * k));
        k += 1;
    }
    token.mask(lanes)
}
