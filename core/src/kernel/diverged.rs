//! The rays of groups that have diverged against one box, each ray for itself: where the bounds of a group say little.
//!
//! NaN, zero directions, degenerate boxes: as [`super::aabb`]; boxes are widened by the margin of [`super::margin`].

use mobula_simd::{MaskLanes, Token};

use super::aabb::{aabb, slabs};
use super::boxes::Planes;
use super::groups::{GROUPS, group_size};
use super::words::WORDS;
use crate::vector::{load3, splat3, sub};
use crate::{Columns3, Rays};

/// The signs of directions that are not the same for all rays.
pub const ANY_SIGNS: u8 = u8::MAX;

/// Which of `groups` have rays that meet box `slot`, and how many rays that are; `lanes` says which, a bit a ray. `signs` are
/// those of all directions (bit k: axis k is negative), or [`ANY_SIGNS`]; boxes and `origins` are in the tree's frame, and the box is
/// widened by `margin`.
#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "rays, a box, and what is known of both")]
pub fn rays_meeting<T: Token, const N: usize, const COMMON_ORIGIN: bool>(
    token: T,
    rays: &Rays<N>,
    signs: u8,
    origins: &Columns3<N>,
    margin: f32,
    planes: &Planes,
    slot: usize,
    groups: u32,
    lanes: &mut [u64; WORDS],
) -> (u32, u32) {
    let size = group_size(N);
    let [mut low, mut high] = [[0.0; 3]; 2];
    for axis in 0..3 {
        let origin = if COMMON_ORIGIN { origins[axis][rays.range().start] } else { 0.0 };
        low[axis] = planes[axis][slot % 8] - (origin + margin);
        high[axis] = planes[axis + 3][slot % 8] - (origin - margin);
        if signs >> axis & 1 != 0 {
            (low[axis], high[axis]) = (high[axis], low[axis]);
        }
    }
    let (low, high) = (splat3(token, low), splat3(token, high));
    let (mut met, mut count) = (0, 0);
    lanes[..N.div_ceil(64)].fill(0);
    let mut left = groups;
    while left != 0 {
        let group = left.trailing_zeros() as usize % GROUPS;
        left &= left - 1;
        let mut at = group * size;
        while at < N.min((group + 1) * size) {
            let inverse = load3(token, rays.inverse_columns(), at);
            let (mut to_low, mut to_high) = (low, high);
            if !COMMON_ORIGIN {
                let origin = load3(token, origins, at);
                (to_low, to_high) = (sub(low, origin), sub(high, origin));
            }
            let (t_min, t_max) = (token.load(&rays.t_min()[..], at), token.load(&rays.t_max[..], at));
            let (hit, _) = if signs == ANY_SIGNS {
                aabb(token, to_low, to_high, inverse, t_min, t_max)
            } else {
                slabs(token, to_low, to_high, inverse, t_min, t_max)
            };
            let hit = (hit & rays.active(token, at)).bits();
            lanes[at / 64 % WORDS] |= u64::from(hit) << (at % 64);
            met |= u32::from(hit != 0) << group;
            count += hit.count_ones();
            at += T::LANES;
        }
    }
    (met, count)
}
