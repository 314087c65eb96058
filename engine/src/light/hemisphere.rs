//! Light that comes from everywhere, without shadows.

use glam::Vec3;
use mobula_core::simd::{AnyToken, Task, Token};

use crate::lanes::{add, dot, load3, scale, splat3, store3};
use crate::stack::AmbientLight;

/// A sky and a ground, blended by how much a surface faces up. Equal colours make it constant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hemisphere {
    /// What a surface that faces up gets, linear RGB.
    pub above: Vec3,
    /// What a surface that faces down gets, linear RGB.
    pub below: Vec3,
}

impl Default for Hemisphere {
    fn default() -> Self {
        Self { above: Vec3::new(0.30, 0.33, 0.38), below: Vec3::new(0.12, 0.11, 0.10) }
    }
}

impl AmbientLight for Hemisphere {
    fn illuminate(&self, token: AnyToken, up: Vec3, normals: [&[f32]; 3], out: [&mut [f32]; 3]) {
        token.run(Arrive { light: self, up, normals, out });
    }
}

struct Arrive<'a> {
    light: &'a Hemisphere,
    up: Vec3,
    normals: [&'a [f32]; 3],
    out: [&'a mut [f32]; 3],
}

impl Task for Arrive<'_> {
    type Output = ();

    #[inline(always)]
    fn run<T: Token>(self, token: T) {
        let Self { light, up, normals, mut out } = self;
        let middle = splat3(token, ((light.above + light.below) * 0.5).to_array());
        let half_difference = splat3(token, ((light.above - light.below) * 0.5).to_array());
        let up = splat3(token, up.to_array());
        for at in (0..out[0].len()).step_by(T::LANES) {
            let upward = dot(load3(token, &normals, at), up);
            store3(add(middle, scale(half_difference, upward)), &mut out, at);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blends_between_the_poles() {
        let light = Hemisphere { above: Vec3::ONE, below: Vec3::ZERO };
        let mut out = [[9.0; 3]; 3];
        let [r, g, b] = &mut out;
        light.illuminate(AnyToken::detect(), Vec3::Z, [&[0.0, 1.0, 0.0], &[0.0; 3], &[1.0, 0.0, -1.0]], [r, g, b]);
        assert_eq!(out, [[1.0, 0.5, 0.0]; 3]);
    }
}
