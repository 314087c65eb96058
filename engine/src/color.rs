//! From linear colours to bytes, by integer comparisons only: the same bytes on every machine.
//!
//! The sRGB curve (IEC 61966-2-1) is inverted at compile time: for each byte v the least linear value that rounds to it.
//! A table over the upper 16 bits of a float then finds the byte with one addition.

use glam::Vec3;

use crate::image::rgba8;

/// The byte that is nearest to `linear` on the sRGB curve. At most 0, and NaN, give 0; at least 1 gives 255.
#[inline]
pub fn to_srgb8(linear: f32) -> u8 {
    let bits = linear.to_bits();
    if linear >= 1.0 {
        return 255;
    }
    if linear.is_nan() || linear < f32::from_bits(FIRST << 16) {
        return 0;
    }
    ((TABLE[(bits >> 16) as usize - FIRST as usize] + (bits & 0xffff)) >> 16) as u8
}

/// The opaque pixel of a frame buffer that shows a linear colour.
#[inline]
pub fn to_pixel(linear: Vec3) -> u32 {
    let [r, g, b] = linear.to_array().map(to_srgb8);
    rgba8(r, g, b, 255)
}

/// Upper bits of 2^-13, which is below the least value that is not black.
const FIRST: u32 = (127 - 13) << 7;
/// 13 octaves of 128 steps up to 1: no step holds more than one threshold.
const STEPS: usize = 13 * 128;

/// For each step: the byte at its beginning, times 2^16, plus what carries into it from the threshold inside on.
static TABLE: [u32; STEPS] = table();

const fn table() -> [u32; STEPS] {
    let mut out = [0; STEPS];
    let mut byte = 0;
    let mut next = threshold(1).to_bits();
    let mut step = 0;
    while step < STEPS {
        let from = (FIRST + step as u32) << 16;
        out[step] = byte << 16;
        if byte < 255 && next >> 16 == from >> 16 {
            out[step] += 0x1_0000 - (next & 0xffff);
            byte += 1;
            if byte < 255 {
                next = threshold(byte + 1).to_bits();
                assert!(next >> 16 != from >> 16, "two thresholds in one step");
            }
        }
        step += 1;
    }
    assert!(byte == 255);
    out
}

/// The least linear value that is shown as `byte`: the curve's inverse at `byte - 0.5`.
const fn threshold(byte: u32) -> f32 {
    let v = (byte as f64 - 0.5) / 255.0;
    if v <= 0.04045 {
        return (v / 12.92) as f32;
    }
    // x^2.4 = (x^(1/5))^12; the root by Newton's method from above, which only falls.
    let x = (v + 0.055) / 1.055;
    let mut root = 1.0;
    let mut i = 0;
    while i < 60 {
        root -= (root - x / (root * root * root * root)) / 5.0;
        i += 1;
    }
    let cube = root * root * root;
    let sixth = cube * cube;
    (sixth * sixth) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_byte_survives_the_way_through_linear() {
        for byte in 0..=255_u8 {
            let v = f64::from(byte) / 255.0;
            let linear = if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) };
            assert_eq!(to_srgb8(linear as f32), byte);
        }
    }

    #[test]
    fn agrees_with_the_curve_between_the_bytes() {
        for i in 0..100_000 {
            let x = i as f32 / 99_999.0;
            let v = if x <= 0.003_130_8 { 12.92 * f64::from(x) } else { 1.055 * f64::from(x).powf(1.0 / 2.4) - 0.055 };
            let exact = 255.0 * v;
            let byte = f64::from(to_srgb8(x));
            assert!((byte - exact).abs() <= 0.5 + 1e-4, "{x}: {byte} for {exact}");
        }
    }

    #[test]
    fn out_of_range_is_black_or_white() {
        assert_eq!([-1.0, -0.0, f32::NAN, -f32::NAN, f32::NEG_INFINITY, 1e-30].map(to_srgb8), [0; 6]);
        assert_eq!([1.0, 1.1, f32::INFINITY, f32::MAX].map(to_srgb8), [255; 4]);
        assert_eq!(to_pixel(Vec3::new(1.0, 0.0, f32::NAN)), rgba8(255, 0, 0, 255));
    }
}
