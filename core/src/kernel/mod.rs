//! Intersection kernels: one body each, generic over lanes. Whether lanes are rays and the primitive is the same in all
//! of them (packets), or lanes are primitives and the ray is the same (single rays), is the caller's: what is the same
//! for all lanes is hoisted into a splat, and the bits stay the same.

pub mod aabb;
pub mod sphere;
pub mod triangle;

use mobula_simd::F32Lanes;

/// `a . b`, in one fixed order: every path of a family gives the same bits.
#[inline(always)]
pub fn dot<F: F32Lanes>(a: [F; 3], b: [F; 3]) -> F {
    a[2].mul_add(b[2], a[1].mul_add(b[1], a[0] * b[0]))
}

/// `a - b` by component.
#[inline(always)]
pub fn sub<F: F32Lanes>(a: [F; 3], b: [F; 3]) -> [F; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}
