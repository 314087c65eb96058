//! Which groups of a packet may hit a triangle at all, before any ray is tested.
//!
//! Rays with a common origin and one dominant axis differ in their shears only, and an edge function of the watertight
//! test ([`super::triangle`]) is linear in them: with corners `b` and `c` relative to the origin, `x` and `y` the ray's
//! shears less those of the packet's middle, and `B = (b0, b1)`, `C = (c0, c1)` sheared by the middle,
//!
//! ```text
//! (C - (x, y) c2) x (B - (x, y) b2) = C x B + x (b2 C1 - c2 B1) + y (c2 B0 - b2 C0)
//! ```
//!
//! since the square terms cancel. What is in brackets is the same for all rays. Taken from the packet's middle, the
//! corners are small where the triangle is near the rays, and so is what is lost to rounding.
//!
//! The answer is not the test's, but errs to one side: a ray that the test finds inside is never dismissed. Let u =
//! 2^-24, Z the greatest depth of a corner along the axis, and X a bound on all sheared corners for all rays of the packet.
//! The exact test shears corners with an error of u (Z + X), and calls zero what is within 2 u X^2 of it: its edge
//! functions are off by at most u (4 Z X + 6 X^2). Ours has the same error in the corners, u 2 X in what the shear is
//! moved by, and the rounding of nine products of at most 2 X^2: u (4 Z X + 36 X^2). `SLACK` is more than half again of
//! both.
//!
//! Parallel rays differ in their bases instead, which are x and y where they pass a plane of equal depth. Corners that are sheared
//! onto that plane are moved across a ray by what its base is moved, so the same holds with a depth of 1. Let S be the
//! sum of the greatest coordinates of a corner and of an origin, in the tree's frame. The exact test errs by 7 u S and u X in a corner
//! (subtracting the origin, in depth and sideways, and the product); ours by 8 u S, in the bases by 7 u S, in their middle and the
//! window's by 6 u S, and by 2 u S where both are moved into the frame: together 30 u S a corner, 120 u S X an edge function.
//! `PARALLEL_SLACK` is half again of that.
//!
//! - NaN: anything; the exact test says no.
//! - Degenerate triangles and coordinates out of proportion: may hit.

use mobula_simd::{F32Lanes, MaskLanes, Token};

use super::group_shears::{GroupShears, Parallel, Window};
use super::groups::group_lanes;
use super::margin::larger;

/// Slack by X^2 and by Z X: see the [module](self).
const SLACK: [f32; 2] = [64.0 / (1 << 24) as f32, 16.0 / (1 << 24) as f32];
/// And by S X, for parallel rays.
const PARALLEL_SLACK: f32 = 192.0 / (1 << 24) as f32;
/// Slack for what underflows, and the most with which no product overflows.
const RANGE: [f32; 2] = [f32::MIN_POSITIVE, 1e30];

/// The edge functions of `B` triangles, as seen by the rays of a [`Window`].
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Edges<const B: usize> {
    /// By edge, coefficients of the shear's distance to the middle, x and y, turned; and the constant, plus the slack.
    function: [[[f32; B]; 3]; 3],
    /// Twice the slack; infinite where every ray may hit.
    width: [f32; B],
    /// Negative where no ray of the window is on the right side of all edges: Manta's corner rays, at all corners at once.
    clearance: [f32; B],
}

impl<const B: usize> Edges<B> {
    /// Of nothing: every ray may hit.
    pub const NONE: Self = Self { function: [[[0.0; B]; 3]; 3], width: [f32::INFINITY; B], clearance: [0.0; B] };

    /// Of triangles by corner, axis and place, and the common origin; `axes` in order, the dominant one last.
    #[inline(always)]
    pub fn new(corners: &[[[f32; B]; 3]; 3], origin: [f32; 3], axes: [usize; 3], window: &Window) -> Self {
        let [x, y, z] = [axes[0] % 3, axes[1] % 3, axes[2] % 3];
        Self::of::<false>(
            corners,
            [0.0; 3],
            [origin[x], origin[y], origin[z]],
            window.center,
            [x, y, z],
            window.radius,
            0.0,
        )
    }

    /// The same for parallel rays: the window is around their bases.
    #[inline(always)]
    pub fn parallel(corners: &[[[f32; B]; 3]; 3], rays: &Parallel, axes: [usize; 3], window: &Window) -> Self {
        let [x, y] = window.center;
        Self::of::<true>(corners, rays.center, [x, y, rays.start], rays.shear, axes, window.radius, rays.away)
    }

    /// What moves a corner across the rays when they move by 1 is its depth from an origin, and 1 if they are `PARALLEL`; then `away` is
    /// the greatest coordinate of an origin.
    #[inline(always)]
    fn of<const PARALLEL: bool>(
        corners: &[[[f32; B]; 3]; 3],
        center: [f32; 3],
        [ox, oy, oz]: [f32; 3],
        [cx, cy]: [f32; 2],
        axes: [usize; 3],
        radius: f32,
        away: f32,
    ) -> Self {
        let mut edges = Self::NONE;
        let [x, y, z] = [axes[0] % 3, axes[1] % 3, axes[2] % 3];
        for i in 0..B {
            let (mut px, mut py, mut depth) = ([0.0; 3], [0.0; 3], [0.0; 3]);
            let mut wide = [0.0; 3];
            for k in 0..3 {
                depth[k] = corners[k][z][i] - center[z] - oz;
                px[k] = corners[k][x][i] - center[x] - ox - cx * depth[k];
                py[k] = corners[k][y][i] - center[y] - oy - cy * depth[k];
                wide[k] = larger(px[k].abs(), py[k].abs());
            }
            let deep = larger(larger(depth[0].abs(), depth[1].abs()), depth[2].abs());
            let wide = larger(larger(wide[0], wide[1]), wide[2]);
            let (wide, by_size) = if PARALLEL {
                depth = [1.0; 3];
                // A base is at most 3 `away` from the frame's centre, so a corner at most that and these, and S is the sum.
                (wide + radius, PARALLEL_SLACK * (4.0 * away + wide + deep))
            } else {
                (wide + radius * deep, SLACK[1] * deep)
            };
            let slack = wide * (SLACK[0] * wide + by_size) + RANGE[0];
            let (mut most, mut least) = ([0.0; 3], [0.0; 3]);
            for k in 0..3 {
                // Edges from b to c, from c to a, from a to b.
                let (b, c) = ([1, 2, 0][k], [2, 0, 1][k]);
                let (x, y) = (depth[c] * py[b] - depth[b] * py[c], depth[b] * px[c] - depth[c] * px[b]);
                let one = px[c] * py[b] - py[c] * px[b] + slack;
                (edges.function[k][0][i], edges.function[k][1][i], edges.function[k][2][i]) = (x, y, one);
                let spread = (x.abs() + y.abs()) * radius;
                (most[k], least[k]) = (one + spread, one - spread);
            }
            let width = if slack < RANGE[1] { slack + slack } else { f32::INFINITY };
            edges.width[i] = width;
            let below = smaller(smaller(most[0], most[1]), most[2]);
            let above = larger(larger(least[0], least[1]), least[2]);
            edges.clearance[i] = larger(below, width - above);
        }
        edges
    }

    /// Which groups have rays that may hit triangle `i`, a bit each.
    #[inline(always)]
    pub fn groups<T: Token, const N: usize>(&self, token: T, i: usize, groups: &GroupShears) -> u32 {
        let i = i % B;
        let [a, b, c] = &self.function;
        let edges = [function(token, a, i), function(token, b, i), function(token, c, i)];
        let width = token.splat(self.width[i]);
        let mut touched = 0;
        let mut at = 0;
        while at < group_lanes(N) {
            let turned = [token.load(&groups.turned[0][..], at), token.load(&groups.turned[1][..], at)];
            let radius = [token.load(&groups.radius[0][..], at), token.load(&groups.radius[1][..], at)];
            let [a, b, c] = edges;
            let (a, b, c) = (bounds(a, turned, radius), bounds(b, turned, radius), bounds(c, turned, radius));
            // One is less than minus the slack for all rays of the group, and one more than the slack.
            let below = a[1].min(b[1]).min(c[1]).lt(token.splat(0.0));
            let above = a[0].max(b[0]).max(c[0]).gt(width);
            touched |= (!(below & above)).bits() << at;
            at += T::LANES;
        }
        touched
    }

    /// May a ray of the window hit triangle `i`?
    #[inline(always)]
    pub fn may_be_hit(&self, i: usize) -> bool {
        let clearance = self.clearance[i % B];
        clearance >= 0.0 || clearance.is_nan()
    }
}

/// An edge function of triangle `i`.
#[inline(always)]
fn function<T: Token, const B: usize>(token: T, [x, y, one]: &[[f32; B]; 3], i: usize) -> [T::F32; 3] {
    [token.splat(x[i]), token.splat(y[i]), token.splat(one[i])]
}

#[inline(always)]
fn value<F: F32Lanes>([x, y, one]: [F; 3], turned: [F; 2]) -> F {
    turned[0].mul_add(x, turned[1].mul_add(y, one))
}

/// The least and the greatest value within a radius.
#[inline(always)]
fn bounds<F: F32Lanes>([x, y, one]: [F; 3], turned: [F; 2], radius: [F; 2]) -> [F; 2] {
    let middle = value([x, y, one], turned);
    let spread = x.abs().mul_add(radius[0], y.abs() * radius[1]);
    [middle - spread, middle + spread]
}

#[inline(always)]
fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}
