//! Light from all around, by a table of radiance.

use std::f32::consts::{FRAC_1_PI, PI, TAU};
use std::fmt;
use std::sync::Arc;

use glam::Vec3;

use crate::packet::{Column, set_vec3, vec3};
use crate::scratch::lend;
use crate::stack::{Context, Illumination, Light, Receivers};

/// Light from infinitely far away, from everywhere, as a table says: its columns go around the axis that is up, its rows from there down, as
/// in a picture that shows the whole sphere. Directions are chosen by the table (Pharr, Jakob and Humphreys, "Physically Based Rendering",
/// 3rd edition, 14.2.4, "Infinite Area Lights"): first a row, then a texel of it, each as often as its radiance times its solid angle is
/// large, then evenly within. What is bright is found by most samples, and all samples weigh about the same.
///
/// Of a few directions that are chosen so for a surface, one remains, the more often the more it counts there (Talbot, Cline and Egbert,
/// "Importance Resampling for Global Illumination", 2005): few are lost behind the surface, and one shadow ray is as good as several.
#[derive(Clone)]
pub struct Environment {
    table: Arc<Table>,
    /// How far it is turned, clockwise seen from above: radians.
    turn: f32,
}

struct Table {
    columns: usize,
    /// The heights of the upper edges of the rows, and of the lower edge of the last.
    heights: Vec<f32>,
    /// The part of the whole up to and with each row.
    rows: Vec<f32>,
    /// Of each row, the part of it up to and with each texel.
    texels: Vec<f32>,
    /// What arrives from a sample in each texel: its radiance over pi times the density of its direction.
    arrives: Vec<Vec3>,
}

/// How much a direction counts for a surface that it grazes, where one across it counts this and 1.
const GRAZING: f32 = 0.1;

/// The brightness of a colour (ITU-R BT.709).
pub(crate) fn luminance(color: Vec3) -> f32 {
    color.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

impl Environment {
    /// Light of this radiance, linear RGB, from the texels of a table with so many columns: rows from the direction that is up to the one that
    /// is down, columns as [`direction`] has them. What is not finite or below 0 is dark. `None` if all is dark, or rows are not whole.
    pub fn new(columns: usize, radiance: &[Vec3]) -> Option<Self> {
        if columns == 0 || !radiance.len().is_multiple_of(columns) {
            return None;
        }
        let rows = radiance.len() / columns;
        let sound = |color: Vec3| if color.is_finite() { color.max(Vec3::ZERO) } else { Vec3::ZERO };
        // All texels of a row are as large.
        let solid_angle = |row: usize| {
            let height = |row: usize| libm::cos(std::f64::consts::PI * row as f64 / rows as f64);
            (height(row) - height(row + 1)) * std::f64::consts::TAU / columns as f64
        };
        let mut of_rows = Vec::with_capacity(rows);
        let mut texels = Vec::with_capacity(radiance.len());
        for colors in radiance.chunks(columns) {
            let before = texels.len();
            let sum = accumulate(colors.iter().map(|&color| f64::from(luminance(sound(color)))), &mut texels);
            of_rows.push(sum * solid_angle(before / columns));
        }
        let mut parts = Vec::with_capacity(rows);
        let sum = accumulate(of_rows.into_iter(), &mut parts);
        if sum.is_nan() || sum <= 0.0 {
            return None;
        }
        // What can be chosen is what the rounded sums say.
        let part = |sums: &[f32], i: usize| sums[i] - if i == 0 { 0.0 } else { sums[i - 1] };
        let mut arrives = Vec::with_capacity(radiance.len());
        for (row, colors) in radiance.chunks(columns).enumerate() {
            let solid_angle = solid_angle(row) as f32;
            let sums = &texels[row * columns..(row + 1) * columns];
            arrives.extend(colors.iter().enumerate().map(|(i, &color)| {
                let probability = part(&parts, row) * part(sums, i);
                let weight = solid_angle * FRAC_1_PI / probability;
                if weight.is_finite() { sound(color) * weight } else { Vec3::ZERO }
            }));
        }
        let heights = (0..=rows).map(|row| libm::cosf(PI * row as f32 / rows as f32)).collect();
        let table = Table { columns, heights, rows: parts, texels, arrives };
        Some(Self { table: Arc::new(table), turn: 0.0 })
    }

    /// Turned by so many whole turns, clockwise seen from above.
    pub fn turned(&self, turn: f32) -> Self {
        Self { turn: self.turn + TAU * turn, ..self.clone() }
    }

    /// For a point of the unit square: a direction, with y up, and what arrives from there.
    fn sample(&self, [u, v]: [f32; 2]) -> (Vec3, Vec3) {
        let Table { columns, heights, rows, texels, arrives } = &*self.table;
        let (row, down) = find(rows, v);
        let (column, along) = find(&texels[row * columns..(row + 1) * columns], u);
        let (above, below) = (heights[row], heights[row + 1]);
        let y = above + (below - above) * down;
        let angle = TAU * (column as f32 + along) / *columns as f32;
        (around(angle + self.turn, y), arrives[row * columns + column])
    }

    /// As [`sample`](Self::sample), for a surface with this normal: one of four such samples, half a square apart.
    fn resampled(&self, [u, v]: [f32; 2], normal: Vec3) -> (Vec3, Vec3) {
        let half = |x: f32| if x < 0.5 { x + 0.5 } else { x - 0.5 };
        let samples = [[u, v], [half(u), v], [u, half(v)], [half(u), half(v)]].map(|square| self.sample(square));
        let weights = samples.map(|(direction, arrives)| {
            let cosine = direction.dot(normal);
            // By more than the cosine, since highlights do not vanish with it.
            if cosine > 0.0 { luminance(arrives) * (cosine + GRAZING) } else { 0.0 }
        });
        let sum = weights.iter().sum::<f32>();
        // Which one is decided by what the place of a sample in its texel is decided by: the last digits.
        let mut left = (v * 4096.0).fract() * sum;
        let chosen = weights.iter().position(|&weight| {
            left -= weight;
            weight > 0.0 && left < 0.0
        });
        let last = || weights.iter().rposition(|&weight| weight > 0.0);
        let Some(chosen) = chosen.or_else(last) else { return (samples[0].0, Vec3::ZERO) };
        let (direction, arrives) = samples[chosen];
        (direction, arrives * (sum / (weights.len() as f32 * weights[chosen])))
    }
}

/// Adds to `sums` the part of the sum of values up to and with each of them, and returns that sum. If it is 0 they are as good as equal.
fn accumulate(values: impl ExactSizeIterator<Item = f64> + Clone, sums: &mut Vec<f32>) -> f64 {
    let (count, whole) = (values.len(), values.clone().sum::<f64>());
    let mut sum = 0.0;
    for (i, value) in values.enumerate() {
        sum += value;
        let part = if whole > 0.0 { (sum / whole).min(1.0) as f32 } else { (i + 1) as f32 / count as f32 };
        sums.push(part);
    }
    // Rounding must leave nothing at the end; what is dark there must not be chosen.
    let last = sums.len() - count;
    let end = sums[last..].last().copied().unwrap_or(1.0);
    sums[last..].iter_mut().rev().take_while(|part| **part == end).for_each(|part| *part = 1.0);
    whole
}

/// The first of rising sums that is above `x`, and how far `x` is between the one before and it: from 0 to 1.
fn find(sums: &[f32], x: f32) -> (usize, f32) {
    let place = sums.partition_point(|&sum| sum <= x).min(sums.len() - 1);
    let before = if place == 0 { 0.0 } else { sums[place - 1] };
    let part = (x - before) / (sums[place] - before);
    (place, if part.is_finite() { part.clamp(0.0, 1.0) } else { 0.5 })
}

/// The unit vector at this angle around y and of this height.
fn around(angle: f32, y: f32) -> Vec3 {
    let across = (1.0 - y * y).max(0.0).sqrt();
    // The middle of a row, at pi, is behind what is looked at from the front.
    Vec3::new(-across * libm::sinf(angle), y, across * libm::cosf(angle))
}

/// The direction, with y up, of a place of a picture that shows the whole sphere: from 0 to 1 along its columns and down its rows. What is in
/// the middle is behind what is looked at from the front: at negative z.
pub fn direction(column: f32, row: f32) -> Vec3 {
    around(TAU * column, libm::cosf(PI * row))
}

/// The place of a direction of unit length: the inverse of [`direction`].
pub fn place(direction: Vec3) -> [f32; 2] {
    let angle = libm::atan2f(-direction.x, direction.z);
    let column = angle / TAU;
    [if column < 0.0 { column + 1.0 } else { column }, libm::acosf(direction.y.clamp(-1.0, 1.0)) * FRAC_1_PI]
}

impl Light for Environment {
    fn illuminate(&self, context: &Context<'_>, points: Receivers<'_>, out: &mut Illumination) {
        let count = points.len();
        let (mut u, mut v) = (lend::<Column<f32>>(context.width), lend::<Column<f32>>(context.width));
        let (u, v) = (&mut u[..count], &mut v[..count]);
        points.choose(context.token, [u, v]);
        let up = context.scene.up;
        let normals = points.normals();
        for (i, (&mut u, &mut v)) in u.iter_mut().zip(v.iter_mut()).enumerate() {
            let (direction, arrives) = match &normals {
                Some(normals) => self.resampled([u, v], up.to_y_up(vec3(normals, i))),
                None => self.sample([u, v]),
            };
            set_vec3(&mut out.direction, i, up.from_y_up(direction));
            set_vec3(&mut out.radiance, i, arrives);
        }
        out.distance[..count].fill(f32::INFINITY);
    }

    fn position(&self, _context: &Context<'_>) -> Option<Vec3> {
        None
    }
}

impl fmt::Debug for Environment {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Environment").field("columns", &self.table.columns).field("turn", &self.turn).finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{hash, unit};

    /// Points of the square as even as may be.
    fn even(count: usize) -> impl Iterator<Item = [f32; 2]> {
        (0..count * count).map(move |i| [i % count, i / count].map(|k| (k as f32 + 0.5) / count as f32))
    }

    #[test]
    fn directions_and_places_are_inverse() {
        for [u, v] in even(17) {
            let way = direction(u, v);
            let found = place(way);
            assert!((way.length() - 1.0).abs() < 1e-6 && (found[0] - u).abs() < 1e-5 && (found[1] - v).abs() < 1e-5);
        }
        assert!(direction(0.5, 0.5).distance(Vec3::NEG_Z) < 1e-6, "the middle is behind");
        assert!(direction(0.75, 0.5).distance(Vec3::X) < 1e-6, "right is right");
    }

    #[test]
    fn samples_add_up_to_the_table() {
        let size = [16, 8];
        let radiance: Vec<Vec3> =
            (0..128).map(|i| Vec3::new((i * 37 % 11 + 1) as f32, (i % 7 + 1) as f32, 1.0)).collect();
        let light = Environment::new(size[0], &radiance).unwrap();
        // The mean of what arrives, weighted by something smooth, is that of the radiance over all directions.
        let weight = |way: Vec3| 1.5 + way.x + way.y * way.z;
        let found = even(256).map(|square| light.sample(square)).map(|(way, arrives)| arrives * weight(way));
        let found = found.fold(Vec3::ZERO, |a, b| a + b) / (256.0 * 256.0);
        let (mut expected, fine) = (Vec3::ZERO, 256);
        for [u, v] in even(fine) {
            let texel = (u * 16.0) as usize + (v * 8.0) as usize * 16;
            let solid_angle = TAU * PI * libm::sinf(PI * v) / (fine * fine) as f32;
            expected += radiance[texel] * weight(direction(u, v)) * solid_angle * FRAC_1_PI;
        }
        assert!(((found - expected) / expected).abs().max_element() < 1e-2, "{found} for {expected}");
    }

    #[test]
    fn of_several_samples_one_stands_for_all() {
        let radiance: Vec<Vec3> = (0..128).map(|i| Vec3::splat((i * 37 % 11) as f32 + 0.1)).collect();
        let light = Environment::new(16, &radiance).unwrap();
        let normal = Vec3::new(0.48, 0.6, -0.64);
        let scattered = |(way, arrives): (Vec3, Vec3)| arrives.x * way.dot(normal).max(0.0);
        let moments = |rows: &mut dyn Iterator<Item = f32>| {
            rows.fold([0.0; 2], |[a, b], x| [a + x / 65_536.0, b + x * x / 65_536.0])
        };
        let squares = || (0..65_536).map(|i| [i, !i].map(|seed| unit(hash(hash(seed)))));
        let plain = moments(&mut squares().map(|square| scattered(light.sample(square))));
        let resampled = moments(&mut squares().map(|square| scattered(light.resampled(square, normal))));
        assert!((plain[0] / resampled[0] - 1.0).abs() < 0.02, "the same mean: {plain:?} {resampled:?}");
        let [before, after] = [plain, resampled].map(|[mean, square]| square - mean * mean);
        assert!(after < 0.35 * before, "and less noise: {before} {after}");
    }

    #[test]
    fn what_is_dark_is_never_chosen_and_tables_may_be_odd() {
        let mut radiance = vec![Vec3::ZERO; 8 * 4];
        (radiance[9], radiance[20]) = (Vec3::ONE, Vec3::splat(1e6));
        radiance[3] = Vec3::splat(f32::NAN);
        radiance[5] = Vec3::splat(-4.0);
        let light = Environment::new(8, &radiance).unwrap();
        for square in even(64).chain([[0.0, 0.0], [0.999_9, 0.999_9]]) {
            let (way, arrives) = light.sample(square);
            let [u, v] = place(way);
            let texel = (u * 8.0) as usize % 8 + (v * 4.0) as usize * 8;
            assert!(arrives.x > 0.0 && arrives.is_finite() && (texel == 9 || texel == 20), "{square:?}: {texel}");
        }
        assert!(Environment::new(8, &[Vec3::ZERO; 32]).is_none() && Environment::new(0, &[]).is_none());
        assert!(Environment::new(5, &[Vec3::ONE; 32]).is_none() && Environment::new(1, &[Vec3::ONE]).is_some());
        assert!(Environment::new(2, &[Vec3::splat(f32::MAX); 4]).is_some_and(|light| {
            let (_, arrives) = light.sample([0.3, 0.3]);
            arrives.min_element() >= 0.0
        }));
    }
}
