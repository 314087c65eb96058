//! Which groups of a packet may hit a sphere at all, before any ray is tested.
//!
//! Rays with a common origin and one dominant axis z go along `(s, t, 1)`, where `s` and `t` are their shears. A ray lies in the plane
//! `x = s z`, from which the centre (X, Y, Z) of a sphere, relative to the origin, is `|X - s Z| / sqrt(1 + s^2)` away. If the ray hits,
//! that is at most the radius R. With `m` in the middle of the shears of a group, `w` the farthest that one of them is from there, and
//! `k^2 = 1 + s^2` at its greatest in the packet, a group with a ray that hits has
//!
//! ```text
//! |X - m Z| <= k R + w |Z|
//! ```
//!
//! and the same in y. Nothing is divided. The bound is that of the box around the outline, an ellipse in the plane of shears, and it holds
//! as well where there is no outline, because the origin is in the sphere or next to it: then it is true of all groups. Parallel rays have
//! one shear and differ in their bases, which are x and y where they pass a plane of equal depth. There Z is 1, and X is where the
//! centre is moved to along the rays.
//!
//! A sphere that the [test](super::sphere) finds is never dismissed. Let u = 2^-24, S the greatest size of X, Y, Z, and R, and q the vector
//! from the centre to the nearest point of the ray. The test's has a part along the ray, which only makes it longer; across it, it is
//! off by u |q| and, unfused, u sqrt(3) S. Its square is off by 3 u of it, that of the radius by u. So a ray that is said to hit has |q| of
//! at most R + 6 u S; times k <= sqrt(2), 9 u S. Shears are off by 2 u: 2 u S. Ours shears the centre by the middle of the packet (3 u S) and
//! from there by that of the group (6 u S), and rounds what it is compared with (12 u S). Together 32 u S.
//!
//! For parallel rays, let S be the sum of the radius and of the greatest coordinates of a centre and of an origin, in the tree's frame. The
//! test subtracts the two with an error of u sqrt(3) S more: 12 u S in all. Shears take 2 u S; bases, their middles and moving into the frame
//! 15 u S, and the centre 8 u S, as in [`super::edges`]; sums and what they are compared with 12 u S. Together 49 u S. `SLACK` is more than
//! that. The middle and the radius of a group's shears are widened by what they are rounded.
//!
//! - NaN, coordinates out of proportion, and radii above those of [`RADII`]: may hit. Radii below count as the least of these.

use mobula_simd::{F32Lanes, MaskLanes, Token};

use super::group_shears::GroupShears;
use super::groups::group_lanes;
use super::margin::larger;
use super::sphere::RADII;

/// Slack by S: see the [module](self).
const SLACK: f32 = 64.0 / (1 << 24) as f32;

/// The outlines of `B` spheres, as seen by the rays of a packet.
#[derive(Clone, Copy, Debug)]
pub struct Outlines<const B: usize> {
    /// The centres across the rays in the middle of the window, x and y.
    center: [[f32; B]; 2],
    /// How far they move across when the rays are turned by 1.
    depth: [f32; B],
    /// How far from the centre a ray passes that hits, in x and y.
    reach: [[f32; B]; 2],
    /// Negative where no ray of the window hits.
    clearance: [f32; B],
}

impl<const B: usize> Outlines<B> {
    /// Of spheres by axis and place: their centres, for rays with a common origin relative to it (either way round), and radii; `axes` in
    /// order, the dominant one last.
    #[inline(always)]
    pub fn new(center: &[[f32; B]; 3], radius: &[f32; B], axes: [usize; 3], shears: &GroupShears) -> Self {
        let [x, y, z] = [axes[0] % 3, axes[1] % 3, axes[2] % 3];
        let zero = [0.0; B];
        let mut of = Self { center: [zero; 2], depth: zero, reach: [zero; 2], clearance: zero };
        for i in 0..B {
            let [px, py, pz] = [center[x][i], center[y][i], center[z][i]];
            let size;
            match &shears.parallel {
                None => {
                    let [s, t] = shears.window.center;
                    size = larger(larger(px.abs(), py.abs()), larger(pz.abs(), radius[i]));
                    (of.center[0][i], of.center[1][i], of.depth[i]) = (px - s * pz, py - t * pz, pz);
                }
                Some(rays) => {
                    let depth = pz - rays.center[z] - rays.start;
                    let across =
                        |p: f32, k: usize| p - rays.center[[x, y][k]] - shears.window.center[k] - rays.shear[k] * depth;
                    (of.center[0][i], of.center[1][i], of.depth[i]) = (across(px, 0), across(py, 1), 1.0);
                    // A base is at most 3 `away` from the frame's centre, so a centre at most that and these.
                    size = 4.0 * rays.away
                        + larger(of.center[0][i].abs(), of.center[1][i].abs())
                        + depth.abs()
                        + radius[i];
                }
            }
            // What the test says of squares that have lost bits, or are infinite, means nothing, but it is the same for all.
            let reach = if radius[i] <= *RADII.end() { larger(radius[i], *RADII.start()) } else { f32::INFINITY };
            let mut clearance = f32::INFINITY;
            for k in 0..2 {
                of.reach[k][i] = reach * shears.length[k] + SLACK * size;
                let beyond = of.reach[k][i] + shears.window.radius * of.depth[i].abs() - of.center[k][i].abs();
                clearance = if clearance < beyond { clearance } else { beyond };
            }
            of.clearance[i] = clearance;
        }
        of
    }

    /// May a ray of the window hit sphere `i`?
    #[inline(always)]
    pub fn may_be_hit(&self, i: usize) -> bool {
        let clearance = self.clearance[i % B];
        clearance >= 0.0 || clearance.is_nan()
    }

    /// Which groups have rays that may hit sphere `i`, a bit each.
    #[inline(always)]
    pub fn groups<T: Token, const N: usize>(&self, token: T, i: usize, groups: &GroupShears) -> u32 {
        let i = i % B;
        let depth = token.splat(self.depth[i]);
        let (x, y) = (token.splat(self.center[0][i]), token.splat(self.center[1][i]));
        let reach = [token.splat(self.reach[0][i]), token.splat(self.reach[1][i])];
        let mut touched = 0;
        let mut at = 0;
        while at < group_lanes(N) {
            let x = token.load(&groups.turned[0][..], at).mul_add(depth, x);
            let y = token.load(&groups.turned[1][..], at).mul_add(depth, y);
            let wide = token.load(&groups.radius[0][..], at).mul_add(depth.abs(), reach[0]);
            let high = token.load(&groups.radius[1][..], at).mul_add(depth.abs(), reach[1]);
            touched |= (!(x.abs().gt(wide) | y.abs().gt(high))).bits() << at;
            at += T::LANES;
        }
        touched
    }
}
