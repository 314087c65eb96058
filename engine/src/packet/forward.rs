//! Normals turned to the side that rays come from.

use mobula_core::simd::{AnyToken, F32Lanes, Task, Token};

use crate::lanes::{dot, load3, neg, select3, store3};

/// Turns geometric normals to the side that the rays come from, and shading normals to the side of these; shading normals that the
/// rays do not see even then become the geometric ones.
pub(super) fn turn_forward(
    token: AnyToken,
    directions: [&[f32]; 3],
    geometric: [&mut [f32]; 3],
    normals: [&mut [f32]; 3],
) {
    token.run(Forward { directions, geometric, normals });
}

struct Forward<'a> {
    directions: [&'a [f32]; 3],
    geometric: [&'a mut [f32]; 3],
    normals: [&'a mut [f32]; 3],
}

impl Task for Forward<'_> {
    type Output = ();

    #[inline(always)]
    fn run<T: Token>(self, token: T) {
        let Self { directions, mut geometric, mut normals } = self;
        let zero = token.splat(0.0);
        for at in (0..directions[0].len()).step_by(T::LANES) {
            let direction = load3(token, &directions, at);
            let outward = load3(token, &geometric, at);
            let outward = select3(dot(outward, direction).gt(zero), neg(outward), outward);
            let normal = load3(token, &normals, at);
            let normal = select3(dot(normal, outward).lt(zero), neg(normal), normal);
            store3(select3(dot(normal, direction).lt(zero), normal, outward), &mut normals, at);
            store3(outward, &mut geometric, at);
        }
    }
}
