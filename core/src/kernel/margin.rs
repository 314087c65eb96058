//! How far boxes are widened, so that nothing is lost to rounding, and the frame in which they are measured.
//!
//! The primitive tests decide what is hit. A box may not hide what they would accept. What they lose to rounding is in proportion
//! to how far a corner is from the ray's origin, wherever both are. So the coordinates of a tree's boxes are relative to a point
//! amid most of its primitives, the centre of its [`Frame`]; a box is widened by [`PAD`] of its own greatest coordinate when the
//! tree is filled ([`Frame::widen`]), and by as much of the ray's origin when a ray meets it, by moving the origin. Neither
//! depends on what else is in the tree: one triangle far away costs the others nothing.
//!
//! Let u = 2^-24, a and b the greatest sizes of a coordinate of the ray's origin and of the box in that frame, and S = a + b. A
//! corner in the box is at most S from the origin along an axis, and sheared at most 2 S. The triangle test moves a corner sideways
//! when it subtracts the origin (u S, and as much through the depth), rounds the shear factor (two roundings, 2 u S), and shears
//! (fused one rounding, 2 u S; unfused two, 3 u S): 7 u S. It accepts weights whose point is off the ray by
//! [`OFF`](super::triangle::OFF) of 2 S: 32 u S. Weighing, dividing and scaling the depth takes ten roundings of u S: 10 u S.
//! It says 0 of a depth of up to [`NEAR`](super::triangle::NEAR) of 2 S: 16 u S.
//!
//! Moving box and origin into the frame rounds both (u S). The slab test rounds where the origin is moved by the margin, the
//! reciprocal, two products and their difference: 6 u S. A frustum, which is tested in its place, rounds its base (7 u a) and moves
//! it by the margin (3 u a); it rounds where it starts (3 u a), and the depth of a plane, the product with a slope and the sum
//! (3 u S): 16 u S. Together 82 u S < [`PAD`] S.
//!
//! All this is of numbers that are not denormal: what falls below is rounded by up to 2^-150 whatever its size. `LEAST`, by which
//! boxes are widened beside, is far more than that, and is lost in the rounding of coordinates above 1e-28.

use mobula_simd::{F32Lanes, Token};

use crate::vector::{load3, splat3, sub};
use crate::{Column, Columns3, Rays};

/// Boxes are widened by this much of a coordinate: see the [module](self).
pub const PAD: f32 = 96.0 / (1 << 24) as f32;
/// And by this, for denormal numbers.
const LEAST: f32 = 1e-36;

/// The frame in which the boxes of a tree are measured, and how far the primitives reach in it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Frame {
    /// What coordinates of boxes are relative to: a point amid most primitives.
    pub center: [f32; 3],
    /// About how far most primitives reach from there along an axis: a measure of what is large in this scene.
    pub size: f32,
    /// How far the farthest of them reaches.
    pub farthest: f32,
}

impl Frame {
    /// A box in this frame, widened.
    #[inline(always)]
    pub fn widen(&self, low: [f32; 3], high: [f32; 3]) -> [[f32; 3]; 2] {
        let (mut low, mut high, mut greatest) = (low, high, 0.0);
        for k in 0..3 {
            (low[k], high[k]) = (low[k] - self.center[k], high[k] - self.center[k]);
            greatest = larger(larger(low[k].abs(), high[k].abs()), greatest);
        }
        let margin = greatest * PAD + LEAST;
        // Where both are infinite nothing is known, and so nothing is outside.
        let (low, high) = (low.map(|x| x - margin), high.map(|x| x + margin));
        let known = |x: f32, otherwise: f32| if x.is_nan() { otherwise } else { x };
        (low.map(|x| known(x, f32::NEG_INFINITY)), high.map(|x| known(x, f32::INFINITY))).into()
    }

    /// Origins of rays in this frame.
    #[inline(always)]
    pub fn origins<T: Token>(&self, token: T, origins: [T::F32; 3]) -> [T::F32; 3] {
        sub(origins, splat3(token, self.center))
    }

    /// The origins of all rays of a packet in this frame.
    #[inline(always)]
    pub fn columns<T: Token, const N: usize>(&self, token: T, rays: &Rays<N>) -> Columns3<N> {
        let mut columns = [Column::splat(0.0); 3];
        let mut at = 0;
        while at < N {
            let origins = self.origins(token, load3(token, rays.origins(), at));
            for (column, origin) in columns.iter_mut().zip(origins) {
                origin.store(&mut column[..], at);
            }
            at += T::LANES;
        }
        columns
    }

    /// The origin of a ray in this frame.
    #[inline(always)]
    pub fn origin(&self, origin: [f32; 3]) -> [f32; 3] {
        [origin[0] - self.center[0], origin[1] - self.center[1], origin[2] - self.center[2]]
    }
}

/// `if x > y { x } else { y }`
#[inline(always)]
pub(crate) fn larger(x: f32, y: f32) -> f32 {
    if x > y { x } else { y }
}
