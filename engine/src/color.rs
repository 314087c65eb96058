//! From linear colours to bytes on the sRGB curve (IEC 61966-2-1), a vector at a time. Nothing is fused: the same bytes at
//! every level.
//!
//! Above the linear part the curve is `1.055 x^(1/2.4) - 0.055`. With `u = x^(1/4)`, which is two square roots, that is a
//! smooth function of `u`, `1.055 u^(5/3) - 0.055`, for which a polynomial of degree 6 is good to 1/2000 of a byte.

use mobula_core::simd::{AnyToken, F32Lanes, I32Lanes, Scalar, Task, Token};

use glam::Vec3;

use crate::lanes::load3;
use crate::tone::Tone;

/// Where the linear part ends.
const LINEAR: f32 = 0.003_130_8;
/// `255 (1.055 u^(5/3) - 0.055) + 0.5`, interpolated at the Chebyshev points of `LINEAR^(1/4)..=1`; highest power first.
const CURVE: [f32; 7] = [16.542_696, -78.039_43, 162.886_22, -213.936_16, 346.857_5, 35.898_08, -14.708_646];

/// The bytes that are nearest to `linear` on the curve. At most 0, and NaN, give 0; at least 1 gives 255.
#[inline(always)]
fn srgb<T: Token>(token: T, linear: T::F32) -> T::I32 {
    let x = linear.max(token.splat(0.0)).min(token.splat(1.0));
    let u = x.sqrt().sqrt();
    let mut curve = token.splat(CURVE[0]);
    // Not a fold: what is in a closure that is called elsewhere is not compiled for the level.
    for power in 1..CURVE.len() {
        curve = curve * u + token.splat(CURVE[power]);
    }
    let line = x * token.splat(255.0 * 12.92) + token.splat(0.5);
    line.select(x.le(token.splat(LINEAR)), curve).to_i32()
}

/// The opaque pixels of linear colours, as a frame buffer holds them: red in the lowest byte.
#[inline(always)]
fn pixels<T: Token>(token: T, [r, g, b]: [T::F32; 3]) -> T::I32 {
    let opaque = token.splat_i32(0xff << 24);
    srgb(token, r) | srgb(token, g).shl(8) | srgb(token, b).shl(16) | opaque
}

/// The opaque pixel of a frame buffer that shows a linear colour.
pub fn to_pixel(linear: Vec3) -> u32 {
    let (token, mut pixel) = (Scalar::new(), [0]);
    pixels(token, linear.to_array().map(|channel| token.splat(channel))).store(&mut pixel, 0);
    pixel[0]
}

/// The pixels of the first `count` of some colours, as `tone` shows them; what the others become is not said.
pub fn to_pixels(token: AnyToken, tone: Tone, colors: [&[f32]; 3], count: usize, out: &mut [u32]) {
    token.run(ToPixels { tone, colors, count, out });
}

/// The linear colour that bytes on the sRGB curve stand for.
pub fn from_srgb8(bytes: [u8; 3]) -> Vec3 {
    from_srgb(bytes.map(|byte| f64::from(byte) / 255.0))
}

/// The linear colour that three numbers from 0 to 1 on the sRGB curve stand for.
pub fn from_srgb(curve: [f64; 3]) -> Vec3 {
    let linear = |v: f64| if v <= 0.04045 { v / 12.92 } else { libm::pow((v + 0.055) / 1.055, 2.4) };
    Vec3::from(curve.map(|v| linear(v) as f32))
}

/// A colour in words: three numbers from 0 to 1 with commas or blanks between them, which are linear in light; or `#` and six or three
/// hexadecimal digits, which are on the sRGB curve (of six, the `#` may be left out).
pub fn parse(text: &str) -> Option<Vec3> {
    let text = text.trim();
    let digits = text.strip_prefix('#').unwrap_or(text);
    let number = u32::from_str_radix(digits, 16).ok().filter(|_| !digits.starts_with('+'));
    match (number, digits.len()) {
        (Some(number), 6) => Some(from_srgb8([number >> 16, number >> 8, number].map(|byte| byte as u8))),
        // Each digit stands for two.
        (Some(number), 3) if digits != text => {
            Some(from_srgb8([number >> 8, number >> 4, number].map(|digit| (digit & 15) as u8 * 17)))
        }
        _ => {
            let parts: Vec<&str> = text.split([',', ' ']).filter(|part| !part.is_empty()).collect();
            let numbers: Vec<f32> = parts.iter().filter_map(|part| part.parse().ok()).collect();
            let &[r, g, b] = &numbers[..] else { return None };
            let whole = parts.len() == 3 && !text.contains(",,");
            (whole && [r, g, b].iter().all(|x| (0.0..=1.0).contains(x))).then_some(Vec3::new(r, g, b))
        }
    }
}

struct ToPixels<'a> {
    tone: Tone,
    colors: [&'a [f32]; 3],
    count: usize,
    out: &'a mut [u32],
}

impl Task for ToPixels<'_> {
    type Output = ();

    #[inline(always)]
    fn run<T: Token>(self, token: T) {
        let Self { tone, colors, count, out } = self;
        for at in (0..count.min(out.len())).step_by(T::LANES) {
            pixels(token, tone.map(token, load3(token, &colors, at))).store(out, at);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::rgba8;

    fn to_srgb8(linear: f32) -> u8 {
        to_pixel(Vec3::new(linear, 0.0, 0.0)) as u8
    }

    #[test]
    fn every_byte_survives_the_way_through_linear() {
        for byte in 0..=255_u8 {
            assert_eq!(to_pixel(from_srgb8([byte, 255 - byte, 7])), rgba8(byte, 255 - byte, 7, 255));
        }
    }

    #[test]
    fn agrees_with_the_curve_between_the_bytes() {
        for i in 0..100_000 {
            let x = i as f32 / 99_999.0;
            let v = if x <= 0.003_130_8 { 12.92 * f64::from(x) } else { 1.055 * f64::from(x).powf(1.0 / 2.4) - 0.055 };
            let exact = 255.0 * v;
            let byte = f64::from(to_srgb8(x));
            assert!((byte - exact).abs() <= 0.5 + 5e-4, "{x}: {byte} for {exact}");
        }
    }

    #[test]
    fn out_of_range_is_black_or_white() {
        assert_eq!([-1.0, -0.0, f32::NAN, -f32::NAN, f32::NEG_INFINITY, 1e-30].map(to_srgb8), [0; 6]);
        assert_eq!([1.0, 1.1, f32::INFINITY, f32::MAX].map(to_srgb8), [255; 4]);
        assert_eq!(to_pixel(Vec3::new(1.0, 0.0, f32::NAN)), rgba8(255, 0, 0, 255));
    }

    #[test]
    fn all_levels_give_the_same_bytes() {
        let values = [f32::NAN, -1.0, 1e-30, LINEAR, 1.0, f32::INFINITY, 0.999_999_94, 1e30];
        let at = |i: usize| values.get(i).copied().unwrap_or((i as f32 * 0.618_034).fract());
        let mut colors = [[0.0; 256]; 3];
        for (axis, column) in colors.iter_mut().enumerate() {
            column.iter_mut().enumerate().for_each(|(i, value)| *value = at((i + 85 * axis) % 256));
        }
        for token in AnyToken::available() {
            let mut out = [7; 256];
            to_pixels(token, Tone::default(), colors.each_ref().map(|column| &column[..]), 251, &mut out);
            for i in 0..251 {
                let one = to_pixel(Vec3::new(colors[0][i], colors[1][i], colors[2][i]));
                assert_eq!(out[i], one, "{} {i}", token.level());
            }
        }
    }
}
