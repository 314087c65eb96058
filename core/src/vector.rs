//! Vectors of three, a lane a ray or a primitive.

use mobula_simd::{F32Lanes, Token};

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

/// Each component the same in all lanes.
#[inline(always)]
pub fn splat3<T: Token>(token: T, v: [f32; 3]) -> [T::F32; 3] {
    [token.splat(v[0]), token.splat(v[1]), token.splat(v[2])]
}

/// Each component from a row of its own, at the same place.
#[inline(always)]
pub fn load3<T: Token, R: AsRef<[f32]>>(token: T, rows: &[R; 3], at: usize) -> [T::F32; 3] {
    [token.load(rows[0].as_ref(), at), token.load(rows[1].as_ref(), at), token.load(rows[2].as_ref(), at)]
}
