//! What the colours of particles mean: the name of the attribute, and its colours with their values.

use super::sheet::{CHARACTER, Sheet};
use crate::color::to_pixel;
use crate::geometry::{Coloring, Particles};
use crate::particles::elements::symbol;

/// Size of a bar of colours.
const BAR: [usize; 2] = [256, 12];
/// Side of a square of one colour.
const SQUARE: usize = 10;
/// More whole numbers than these are a bar.
const FEW: usize = 12;

/// The legend of particles, for the lower left corner of a picture; none if no attribute decides about their colours.
pub fn legend(particles: &Particles) -> Option<Sheet> {
    let coloring = particles.coloring.as_ref()?;
    let kinds = particles.kinds(&coloring.attribute).filter(|kinds| kinds.len() <= FEW);
    Some(kinds.map_or_else(|| bar(coloring), |kinds| squares(coloring, &kinds)))
}

/// A bar with its ends and its middle.
fn bar(Coloring { attribute, map }: &Coloring) -> Sheet {
    let [low, high] = map.range();
    let ends = [low, low * 0.5 + high * 0.5, high].map(|value| short(value, f64::from(high) - f64::from(low)));
    let (line, size) = (CHARACTER[1] + 2, [BAR[0].max(attribute.chars().count() * CHARACTER[0]), 0]);
    let mut sheet = Sheet::new([size[0], 2 * line + BAR[1] + 4], true);
    sheet.write([0, 0], attribute);
    for x in 0..BAR[0] {
        let part = (x as f32 + 0.5) / BAR[0] as f32;
        let value = low * (1.0 - part) + high * part;
        sheet.fill([x, line], [1, BAR[1]], bytes(map.color(value)));
    }
    for (i, text) in ends.iter().enumerate() {
        let width = text.chars().count() * CHARACTER[0];
        sheet.write([(BAR[0].saturating_sub(width)) * i / 2, line + BAR[1] + 4], text);
    }
    sheet
}

/// A square for each kind.
fn squares(Coloring { attribute, map }: &Coloring, kinds: &[u8]) -> Sheet {
    let name = |kind: u8| if attribute == "element" { symbol(kind) } else { kind.to_string() };
    let names: Vec<String> = kinds.iter().map(|&kind| name(kind)).collect();
    let longest = names.iter().map(|name| SQUARE + 6 + name.len() * CHARACTER[0]);
    let width = longest.chain([attribute.chars().count() * CHARACTER[0]]).max().unwrap_or(0);
    let line = CHARACTER[1] + 2;
    let mut sheet = Sheet::new([width, (names.len() + 1) * line], true);
    sheet.write([0, 0], attribute);
    for (i, (&kind, name)) in kinds.iter().zip(&names).enumerate() {
        let y = (i + 1) * line;
        sheet.fill([0, y + 1], [SQUARE; 2], bytes(map.color(kind.into())));
        sheet.write([SQUARE + 6, y], name);
    }
    sheet
}

fn bytes(linear: [f32; 3]) -> [u8; 3] {
    let [r, g, b, _] = to_pixel(linear.into()).to_le_bytes();
    [r, g, b]
}

/// A value in no more digits than its range makes sense of.
fn short(value: f32, range: f64) -> String {
    let digits = 10_f64.powf((range / 1000.0).abs().max(1e-30).log10().floor());
    let rounded = (f64::from(value) / digits).round() * digits;
    let short: f64 = format!("{rounded:.6e}").parse().unwrap_or(rounded);
    if short != 0.0 && !(1e-4..1e7).contains(&short.abs()) { format!("{short:e}") } else { format!("{short}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bar_has_the_colours_of_the_map() {
        let particles = Particles::example(0);
        let sheet = legend(&particles).unwrap();
        let mut rows = vec![vec![0; 300]; 100];
        rows.iter_mut().enumerate().for_each(|(y, row)| sheet.cover([300, 100], y, row));
        let map = &particles.coloring.as_ref().unwrap().map;
        let pixel = |value: f32| {
            let [r, g, b] = bytes(map.color(value));
            u32::from_be_bytes([0, r, g, b])
        };
        for value in [0.5 / 256.0, 100.5 / 256.0, 255.5 / 256.0] {
            let count = rows.iter().flatten().filter(|found| **found == pixel(value)).count();
            assert!(count >= BAR[1], "{value}: {count}");
        }
        assert!(rows.iter().flatten().any(|found| *found == 0x00ff_ffff), "text");
        let mut plain = particles;
        plain.coloring = None;
        assert!(legend(&plain).is_none());
    }

    #[test]
    fn values_are_short() {
        let texts = [(0.100_001, 1.0), (2.5, 2.5), (1234.4, 5000.0), (3.0e-9, 1.0e-8), (0.0, 1.0)];
        assert_eq!(texts.map(|(value, range)| short(value, range)), ["0.1", "2.5", "1234", "3e-9", "0"]);
        assert_eq!(short(f32::MAX, 2.0 * f64::from(f32::MAX)), "3.403e38");
    }
}
