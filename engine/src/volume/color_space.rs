//! The colour spaces that colour maps are made in, from and to sRGB from 0 to 1: HSV, CIELAB with the white of D65, and the polar
//! form of CIELAB of Moreland, "Diverging Color Maps for Scientific Visualization" (2009).

use std::f64::consts::{FRAC_PI_3, PI, TAU};

use crate::color::from_srgb;

/// Hue, saturation and value, all from 0 to 1.
pub(crate) fn to_hsv([r, g, b]: [f64; 3]) -> [f64; 3] {
    let (value, least) = (r.max(g).max(b), r.min(g).min(b));
    let chroma = value - least;
    if chroma <= 0.0 {
        return [0.0, 0.0, value];
    }
    let sixths = if value == r {
        (g - b) / chroma
    } else if value == g {
        (b - r) / chroma + 2.0
    } else {
        (r - g) / chroma + 4.0
    };
    [sixths.rem_euclid(6.0) / 6.0, chroma / value, value]
}

/// From hue, which may be any number of turns, saturation and value.
pub(crate) fn from_hsv([hue, saturation, value]: [f64; 3]) -> [f64; 3] {
    [5.0, 3.0, 1.0].map(|channel| {
        let sixths = (channel + 6.0 * hue).rem_euclid(6.0);
        value * (1.0 - saturation * sixths.min(4.0 - sixths).clamp(0.0, 1.0))
    })
}

/// The white of D65.
const WHITE: [f64; 3] = [0.950_47, 1.0, 1.088_83];

/// L* from 0 to 100, a* and b*.
pub(crate) fn to_lab(srgb: [f64; 3]) -> [f64; 3] {
    let [r, g, b] = from_srgb(srgb).to_array().map(f64::from);
    let xyz = [
        0.412_456_4 * r + 0.357_576_1 * g + 0.180_437_5 * b,
        0.212_672_9 * r + 0.715_152_2 * g + 0.072_175_0 * b,
        0.019_333_9 * r + 0.119_192_0 * g + 0.950_304_1 * b,
    ];
    let [x, y, z] = [0, 1, 2].map(|k| {
        let part = xyz[k] / WHITE[k];
        if part > 216.0 / 24_389.0 { libm::cbrt(part) } else { (24_389.0 / 27.0 * part + 16.0) / 116.0 }
    });
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// From L*, a* and b*; what no screen shows becomes what is nearest in each channel.
pub(crate) fn from_lab([l, a, b]: [f64; 3]) -> [f64; 3] {
    let middle = (l + 16.0) / 116.0;
    let parts = [middle + a / 500.0, middle, middle - b / 200.0];
    let [x, y, z] = [0, 1, 2].map(|k| {
        let cube = parts[k] * parts[k] * parts[k];
        WHITE[k] * if cube > 216.0 / 24_389.0 { cube } else { (116.0 * parts[k] - 16.0) * (27.0 / 24_389.0) }
    });
    let linear = [
        3.240_454_2 * x - 1.537_138_5 * y - 0.498_531_4 * z,
        -0.969_266_0 * x + 1.876_010_8 * y + 0.041_556_0 * z,
        0.055_643_4 * x - 0.204_025_9 * y + 1.057_225_2 * z,
    ];
    linear.map(|v| {
        let v = v.clamp(0.0, 1.0);
        if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * libm::pow(v, 1.0 / 2.4) - 0.055 }
    })
}

/// A part of the way between two colours, by hue, saturation and value. A colour without a hue takes that of the other; `wrap`: the
/// shorter way around.
pub(crate) fn between_hsv(ends: [[f64; 3]; 2], part: f64, wrap: bool) -> [f64; 3] {
    let [mut a, mut b] = ends.map(to_hsv);
    if wrap && (a[0] - b[0]).abs() > 0.5 {
        let lower = if a[0] < b[0] { &mut a } else { &mut b };
        lower[0] += 1.0;
    }
    from_hsv(mix(a, b, part))
}

/// A part of the way between two colours, by CIELAB.
pub(crate) fn between_lab(ends: [[f64; 3]; 2], part: f64) -> [f64; 3] {
    let [a, b] = ends.map(to_lab);
    from_lab(mix(a, b, part))
}

/// A part of the way between two colours by Moreland's map: over white, if both have colours of different hues.
pub(crate) fn between_diverging(ends: [[f64; 3]; 2], part: f64) -> [f64; 3] {
    let [mut a, mut b] = ends.map(|end| to_polar(to_lab(end)));
    let mut part = part;
    let apart = (a[2] - b[2]).abs();
    if a[1] > 0.05 && b[1] > 0.05 && apart.min(TAU - apart) > FRAC_PI_3 {
        let white = [a[0].max(b[0]).max(88.0), 0.0, 0.0];
        if part < 0.5 {
            (b, part) = (white, 2.0 * part);
        } else {
            (a, part) = (white, 2.0 * part - 1.0);
        }
    }
    if a[1] < 0.05 && b[1] > 0.05 {
        a[2] = hue_of_grey(b, a[0]);
    } else if b[1] < 0.05 && a[1] > 0.05 {
        b[2] = hue_of_grey(a, b[0]);
    }
    from_lab(from_polar(mix(a, b, part)))
}

/// Magnitude, saturation as an angle, hue as an angle.
fn to_polar([l, a, b]: [f64; 3]) -> [f64; 3] {
    let magnitude = libm::sqrt(l * l + a * a + b * b);
    let saturation = if magnitude > 0.001 { libm::acos((l / magnitude).clamp(-1.0, 1.0)) } else { 0.0 };
    let hue = if saturation > 0.001 { libm::atan2(b, a) } else { 0.0 };
    [magnitude, saturation, hue]
}

fn from_polar([magnitude, saturation, hue]: [f64; 3]) -> [f64; 3] {
    let chroma = magnitude * libm::sin(saturation);
    [magnitude * libm::cos(saturation), chroma * libm::cos(hue), chroma * libm::sin(hue)]
}

/// The hue that a grey of some magnitude gets beside a colour, so that the way between both looks even.
fn hue_of_grey([magnitude, saturation, hue]: [f64; 3], grey: f64) -> f64 {
    if magnitude >= grey - 0.1 {
        return hue;
    }
    let spin = saturation * libm::sqrt(grey * grey - magnitude * magnitude) / (magnitude * libm::sin(saturation));
    // Away from purple.
    if hue > -PI / 3.0 { hue + spin } else { hue - spin }
}

fn mix(a: [f64; 3], b: [f64; 3], part: f64) -> [f64; 3] {
    [0, 1, 2].map(|k| a[k] * (1.0 - part) + b[k] * part)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(found: [f64; 3], expected: [f64; 3], within: f64) {
        assert!((0..3).all(|k| (found[k] - expected[k]).abs() <= within), "{found:?} for {expected:?}");
    }

    #[test]
    fn known_colours() {
        near(to_hsv([1.0, 0.5, 0.0]), [1.0 / 12.0, 1.0, 1.0], 1e-12);
        near(to_hsv([0.2, 0.2, 0.6]), [2.0 / 3.0, 2.0 / 3.0, 0.6], 1e-12);
        near(to_lab([1.0; 3]), [100.0, 0.0, 0.0], 0.02);
        near(to_lab([1.0, 0.0, 0.0]), [53.24, 80.09, 67.20], 0.02);
        near(to_lab([0.0, 0.0, 1.0]), [32.30, 79.19, -107.86], 0.02);
    }

    #[test]
    fn there_and_back() {
        for i in 0..1000 {
            let color = [i % 10, i / 10 % 10, i / 100].map(|step| f64::from(step) / 9.0);
            near(from_hsv(to_hsv(color)), color, 1e-12);
            near(from_lab(to_lab(color)), color, 2e-4);
            near(from_lab(from_polar(to_polar(to_lab(color)))), color, 2e-4);
        }
    }

    /// What VTK 9 finds between the three colours of such a map.
    #[test]
    fn ways_between_colours_are_those_of_others() {
        let [blue, grey, red] = [[0.2, 0.3, 0.75], [0.865; 3], [0.7, 0.02, 0.15]];
        near(between_lab([blue, grey], 0.25), [0.421_95, 0.430_268, 0.782_839], 1e-3);
        near(between_diverging([blue, grey], 0.25), [0.355_982, 0.509_625, 0.913_781], 1e-3);
        near(between_diverging([grey, red], 1.0 / 6.0), [0.935_26, 0.809_46, 0.740_223], 1e-3);
        near(between_hsv([blue, grey], 0.25, false), [0.350_438, 0.778_75, 0.720_344], 1e-3);
        let over_white = between_diverging([blue, red], 0.5);
        assert!(over_white.iter().all(|&channel| (0.8..0.9).contains(&channel)), "{over_white:?}");
    }
}
