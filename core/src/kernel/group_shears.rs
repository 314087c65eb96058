//! Where the groups of a packet go, if all rays have an origin or a direction in common: what the edge functions of triangles
//! ([`super::edges`]) are bounded over.

use mobula_simd::{F32Lanes, Token};

use super::groups::Row;
use super::margin::larger;
use crate::Column;

/// The least rectangle around the shears of the rays that are asked about.
#[derive(Clone, Copy, Debug)]
pub struct Window {
    /// Its middle.
    pub center: [f32; 2],
    /// The farthest that a ray is from the middle along either axis.
    pub radius: f32,
}

impl Window {
    /// Between the least and the greatest shears.
    #[inline(always)]
    pub fn new(least: [f32; 2], greatest: [f32; 2]) -> Self {
        let (mut center, mut radius) = ([0.0; 2], 0.0);
        for k in 0..2 {
            center[k] = 0.5 * least[k] + 0.5 * greatest[k];
            // Rounding keeps order: no difference is rounded to more than these.
            radius = larger(radius, larger(greatest[k] - center[k], center[k] - least[k]));
        }
        Self { center, radius }
    }
}

/// Where groups of rays go that have an origin or a direction in common. From an origin they differ in their shears; parallel
/// rays in their bases, which are x and y where they pass a plane of equal depth.
#[derive(Clone, Copy, Debug)]
pub struct GroupShears {
    /// Around the shears or bases of all of them.
    pub window: Window,
    /// The middle of the window less that of each group, x and y.
    pub turned: [Row; 2],
    /// How far from it any ray of the group may be.
    pub radius: [Row; 2],
    /// The greatest length that a direction has in the plane of the dominant axis and x, and y, for 1 along that axis.
    pub length: [f32; 2],
    /// Of parallel rays.
    pub parallel: Option<Parallel>,
}

/// What parallel rays have in common.
#[derive(Clone, Copy, Debug)]
pub struct Parallel {
    /// Their shears, x and y.
    pub shear: [f32; 2],
    /// What bases and `start` are relative to.
    pub center: [f32; 3],
    /// The depth at which bases are taken.
    pub start: f32,
    /// The greatest coordinate of an origin.
    pub away: f32,
}

impl Default for GroupShears {
    fn default() -> Self {
        let zero = [Column::splat(0.0); 2];
        let window = Window { center: [0.0; 2], radius: 0.0 };
        Self { window, turned: zero, radius: zero, length: [1.0; 2], parallel: None }
    }
}

/// More than rounding takes from the middle and the radius of shears, which are at most 1 in size.
const ROUNDING: f32 = 4.0 * f32::EPSILON;

impl GroupShears {
    /// Of the least and the greatest shears or bases of each of some groups, by x and y, and of all together.
    #[inline(always)]
    pub(crate) fn new<T: Token>(
        token: T,
        ends: &[[Row; 2]; 2],
        all: [[f32; 2]; 2],
        groups: usize,
        parallel: Option<Parallel>,
    ) -> Self {
        let mut window = Window::new([all[0][0], all[1][0]], [all[0][1], all[1][1]]);
        window.radius += ROUNDING;
        let mut of = Self { window, parallel, ..Self::default() };
        for k in 0..2 {
            let [least, greatest] = parallel.map_or([all[k][0], all[k][1]], |rays| [rays.shear[k]; 2]);
            let steepest = larger(least.abs(), greatest.abs());
            of.length[k] = libm::sqrtf(1.0 + steepest * steepest);
        }
        let half = token.splat(0.5);
        let mut at = 0;
        while at < groups {
            for k in 0..2 {
                let (least, greatest) = (token.load(&ends[0][k][..], at), token.load(&ends[1][k][..], at));
                let turned = (least + greatest).neg_mul_add(half, token.splat(window.center[k]));
                turned.store(&mut of.turned[k][..], at);
                let radius = (greatest - least).mul_add(half, token.splat(ROUNDING));
                radius.store(&mut of.radius[k][..], at);
            }
            at += T::LANES;
        }
        of
    }
}
