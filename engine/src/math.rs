//! Arithmetic whose bits depend on no platform: plain IEEE operations, nothing fused, no system library.

use glam::Vec3;

/// `base` to the power of `exponent`, for a base in 0..=1 and a finite exponent >= 0; relative error below 1e-6.
/// A base of NaN or below 0 counts as 0, one above 1 as 1. `pow(0, 0)` is 1.
pub fn pow(base: f32, exponent: f32) -> f32 {
    if exponent <= 0.0 || base >= 1.0 {
        return 1.0;
    }
    if base.is_nan() || base <= 0.0 {
        return 0.0;
    }
    let power = f64::from(exponent) * log2(f64::from(base));
    if power < -126.0 { 0.0 } else { exp2(power) as f32 }
}

/// `exp(-x)`; relative error below 1e-6. 1 for a NaN or what is not above 0, 0 where it is no normal number any more.
pub fn exp_minus(x: f32) -> f32 {
    if x.is_nan() || x <= 0.0 {
        return 1.0;
    }
    let power = -f64::from(x) * core::f64::consts::LOG2_E;
    if power < -126.0 { 0.0 } else { exp2(power) as f32 }
}

/// Logarithm to base 2 of a positive normal number: the exponent, and `ln m = 2 artanh((m - 1) / (m + 1))` of the mantissa.
pub(crate) fn log2(x: f64) -> f64 {
    let bits = x.to_bits();
    // Split so that the mantissa is in [sqrt(1/2), sqrt(2)): |s| <= 0.172, and the next term is below 1e-10.
    let shifted = bits.wrapping_sub(0x3fe6_a09e_667f_3bcd);
    let exponent = (shifted as i64) >> 52;
    let m = f64::from_bits(bits.wrapping_sub((exponent << 52) as u64));
    let s = (m - 1.0) / (m + 1.0);
    let q = s * s;
    let series = 1.0 + q * (1.0 / 3.0 + q * (1.0 / 5.0 + q * (1.0 / 7.0 + q * (1.0 / 9.0 + q * (1.0 / 11.0)))));
    exponent as f64 + 2.0 * core::f64::consts::LOG2_E * s * series
}

/// 2 to the power of a number in -1000..=1000: the exponent's whole part, and a Taylor series on [-1/2, 1/2].
pub(crate) fn exp2(x: f64) -> f64 {
    let whole = (x + 0.5).floor();
    let y = (x - whole) * core::f64::consts::LN_2;
    let mut series = 1.0;
    for n in (1..=9).rev() {
        series = 1.0 + series * y / f64::from(n);
    }
    series * f64::from_bits(((whole as i64 + 1023) as u64) << 52)
}

/// The angle whose sine and cosine have this ratio, for a sine >= 0: from 0 to pi, with an error below 2e-5. (Arctangent on [0, 1]:
/// Abramowitz and Stegun 4.4.49.)
#[inline(always)]
pub(crate) fn angle(sine: f64, cosine: f64) -> f32 {
    use core::f32::consts::{FRAC_PI_2, PI};
    let size = cosine.abs();
    let (less, more) = if sine < size { (sine, size) } else { (size, sine) };
    let t = (less / more) as f32;
    let q = t * t;
    let arc = t * (0.999_866 + q * (-0.330_299_5 + q * (0.180_141 + q * (-0.085_133 + q * 0.020_835_1))));
    // Sums, not branches: which of these it is, is as good as random.
    let arc = arc + f32::from(sine > size) * (FRAC_PI_2 - 2.0 * arc);
    arc + f32::from(cosine < 0.0) * (PI - 2.0 * arc)
}

/// `v` at length 1: every operation correctly rounded. The zero vector gives NaN.
#[inline(always)]
pub fn normalize(v: Vec3) -> Vec3 {
    v * (1.0 / v.dot(v).sqrt())
}

/// `v` at length 1 however short or long it is, by way of f64; `otherwise` if it is zero or not finite.
pub fn normalize_or(v: [f64; 3], otherwise: Vec3) -> Vec3 {
    let largest = v.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
    if !(largest > 0.0 && v.iter().all(|x| x.is_finite())) {
        return otherwise;
    }
    let [x, y, z] = v.map(|x| x / largest);
    let scale = 1.0 / (x * x + y * y + z * z).sqrt();
    Vec3::new((x * scale) as f32, (y * scale) as f32, (z * scale) as f32)
}

/// A well-mixed function of its argument: neighbouring arguments give unrelated results.
#[inline(always)]
pub const fn hash(mut x: u32) -> u32 {
    x = (x ^ (x >> 16)).wrapping_mul(0x85eb_ca6b);
    x = (x ^ (x >> 13)).wrapping_mul(0xc2b2_ae35);
    x ^ (x >> 16)
}

/// The upper 24 bits of `x` as a number in [0, 1).
#[inline(always)]
pub const fn unit(x: u32) -> f32 {
    (x >> 8) as f32 * (1.0 / 16_777_216.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn pow_is_close_to_the_exact_power(base in 0.0_f32..=1.0, exponent in 0.0_f32..2000.0) {
            let exact = f64::from(base).powf(f64::from(exponent));
            let got = f64::from(pow(base, exponent));
            prop_assert!((got - exact).abs() <= 1e-6 * exact + 1e-37, "{} for {}", got, exact);
        }

        #[test]
        fn exp_minus_is_close_to_the_exact_value(x in 0.0_f32..100.0) {
            let exact = (-f64::from(x)).exp();
            let got = f64::from(exp_minus(x));
            prop_assert!((got - exact).abs() <= 1e-6 * exact + 1e-37, "{} for {}", got, exact);
        }

        #[test]
        fn angles_are_close_to_the_exact_ones(turn in 0.0..=std::f64::consts::PI, size in -300..300) {
            let size = 10_f64.powi(size);
            prop_assert!((f64::from(angle(size * turn.sin(), size * turn.cos())) - turn).abs() < 2e-5);
        }

        #[test]
        fn any_vector_is_normalized(v in [-1e300_f64..1e300, -1e-300..1e-300, -1.0..1.0]) {
            let length = normalize_or(v, Vec3::X).length();
            prop_assert!((length - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn pow_at_the_ends() {
        assert_eq!([pow(0.0, 5.0), pow(f32::NAN, 5.0), pow(-1.0, 5.0), pow(1e-40, 10.0)], [0.0; 4]);
        assert_eq!([pow(1.0, 5.0), pow(0.0, 0.0), pow(2.0, 3.0)], [1.0; 3]);
    }

    #[test]
    fn exp_minus_at_the_ends() {
        assert_eq!([0.0, -1.0, f32::NAN, f32::NEG_INFINITY].map(exp_minus), [1.0; 4]);
        assert_eq!([f32::INFINITY, 1e30, 90.0].map(exp_minus), [0.0; 3]);
    }

    #[test]
    fn zero_and_infinite_vectors_take_the_alternative() {
        for v in [[0.0; 3], [f64::NAN, 0.0, 0.0], [f64::INFINITY, 1.0, 1.0]] {
            assert_eq!(normalize_or(v, Vec3::Y), Vec3::Y);
        }
    }
}
