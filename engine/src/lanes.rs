//! Vectors of three, a lane a ray, with the bits that `glam` gives for one ray at a time: nothing is fused, so that all levels agree.

use mobula_core::simd::F32Lanes;
pub(crate) use mobula_core::vector::{load3, splat3, sub};

/// Writes each component to a row of its own, at the same place.
#[inline(always)]
pub(crate) fn store3<F: F32Lanes, R: AsMut<[f32]>>(v: [F; 3], rows: &mut [R; 3], at: usize) {
    let [x, y, z] = rows;
    v[0].store(x.as_mut(), at);
    v[1].store(y.as_mut(), at);
    v[2].store(z.as_mut(), at);
}

/// `a + b` by component.
#[inline(always)]
pub(crate) fn add<F: F32Lanes>(a: [F; 3], b: [F; 3]) -> [F; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// `a` times a number.
#[inline(always)]
pub(crate) fn scale<F: F32Lanes>(a: [F; 3], by: F) -> [F; 3] {
    [a[0] * by, a[1] * by, a[2] * by]
}

/// `-a`.
#[inline(always)]
pub(crate) fn neg<F: F32Lanes>(a: [F; 3]) -> [F; 3] {
    [-a[0], -a[1], -a[2]]
}

/// `a . b`.
#[inline(always)]
pub(crate) fn dot<F: F32Lanes>(a: [F; 3], b: [F; 3]) -> F {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// `a x b`.
#[inline(always)]
pub(crate) fn cross<F: F32Lanes>(a: [F; 3], b: [F; 3]) -> [F; 3] {
    [a[1] * b[2] - b[1] * a[2], a[2] * b[0] - b[2] * a[0], a[0] * b[1] - b[0] * a[1]]
}

/// The greatest absolute value of a component.
#[inline(always)]
pub(crate) fn greatest<F: F32Lanes>(a: [F; 3]) -> F {
    a[0].abs().max(a[1].abs().max(a[2].abs()))
}

/// `if mask { a } else { b }`.
#[inline(always)]
pub(crate) fn select3<F: F32Lanes>(mask: F::Mask, a: [F; 3], b: [F; 3]) -> [F; 3] {
    [a[0].select(mask, b[0]), a[1].select(mask, b[1]), a[2].select(mask, b[2])]
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use mobula_core::simd::{AnyToken, Task, Token};

    use super::*;

    /// Products of two rows of vectors: dot, cross, and the sum of both vectors scaled by that.
    struct Products<'a>([&'a [f32]; 3], [&'a [f32]; 3]);

    impl Task for Products<'_> {
        type Output = [Vec<f32>; 8];

        #[inline(always)]
        fn run<T: Token>(self, token: T) -> Self::Output {
            let count = self.0[0].len();
            let mut out: [Vec<f32>; 8] = std::array::from_fn(|_| vec![0.0; count]);
            let [dots, greatests, x, y, z, sums @ ..] = &mut out;
            let mut crosses = [x, y, z];
            for at in (0..count).step_by(T::LANES) {
                let (a, b) = (load3(token, &self.0, at), load3(token, &self.1, at));
                let product = dot(a, b);
                product.store(dots, at);
                greatest(a).store(greatests, at);
                store3(cross(a, b), &mut crosses, at);
                store3(add(a, scale(select3(product.lt(token.splat(0.0)), neg(b), b), product)), sums, at);
            }
            out
        }
    }

    #[test]
    fn all_levels_give_what_glam_gives() {
        let number = |i: usize, of: usize| ((i * 7 + of * 13) as f32 * 0.618_034).fract() * 3.0 - 1.5;
        let rows: [Vec<f32>; 6] = std::array::from_fn(|of| (0..37).map(|i| number(i, of)).collect());
        let [ax, ay, az, bx, by, bz] = rows.each_ref().map(|row| &row[..]);
        for token in AnyToken::available() {
            let out = token.run(Products([ax, ay, az], [bx, by, bz]));
            for i in 0..37 {
                let (a, b) = (Vec3::new(ax[i], ay[i], az[i]), Vec3::new(bx[i], by[i], bz[i]));
                let sum = a + if a.dot(b) < 0.0 { -b } else { b } * a.dot(b);
                let Vec3 { x, y, z } = a.cross(b);
                let expected = [a.dot(b), a.abs().max_element(), x, y, z, sum.x, sum.y, sum.z];
                assert_eq!(out.each_ref().map(|column| column[i]), expected, "{}", token.level());
            }
        }
    }
}
