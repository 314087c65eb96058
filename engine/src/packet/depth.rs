//! Optical depths: how much of the light gets through surfaces, as integers that may be added in any order.

use mobula_core::sink::OPAQUE;

use crate::math::{exp2, log2};

/// What a halving of the light counts.
const HALF: f64 = (1 << 24) as f64;

/// The optical depth of a surface that stops this fraction of the light. At least 1, and NaN, count as all of it, at most 0 as none.
pub fn optical_depth(opacity: f32) -> u32 {
    if opacity.is_nan() || opacity >= 1.0 {
        return OPAQUE;
    }
    let depth = -log2(1.0 - f64::from(opacity.max(0.0))) * HALF;
    ((depth + 0.5) as u32).min(OPAQUE)
}

/// The fraction of the light that gets through an optical depth; nothing through [`OPAQUE`].
pub fn transmittance(depth: u32) -> f32 {
    if depth >= OPAQUE { 0.0 } else { exp2(-f64::from(depth) / HALF) as f32 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn what_gets_through_is_what_is_not_stopped(opacity in 0.0_f32..=0.9999) {
            let through = transmittance(optical_depth(opacity));
            prop_assert!((through - (1.0 - opacity)).abs() < 2e-6, "{} of {}", through, 1.0 - opacity);
        }

        #[test]
        fn depths_of_several_surfaces_multiply(some in prop::collection::vec(0.0_f32..0.7, 0..6)) {
            let depth = some.iter().map(|&opacity| optical_depth(opacity)).sum();
            let product: f32 = some.iter().map(|opacity| 1.0 - opacity).product();
            prop_assert!((transmittance(depth) - product).abs() < 1e-5);
        }
    }

    #[test]
    fn all_and_nothing() {
        assert_eq!([1.0, 2.0, f32::NAN, f32::INFINITY, 1.0 - f32::EPSILON].map(optical_depth), [OPAQUE; 5]);
        assert_eq!([0.0, -1.0, f32::NEG_INFINITY].map(optical_depth), [0; 3]);
        assert_eq!([transmittance(0), transmittance(OPAQUE), transmittance(u32::MAX)], [1.0, 0.0, 0.0]);
        assert_eq!(transmittance(optical_depth(0.5)), 0.5);
    }
}
