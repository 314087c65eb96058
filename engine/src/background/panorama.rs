//! A picture of everything around.

use std::fmt;
use std::sync::Arc;

use glam::Vec3;

use crate::light::{Environment, Hemisphere, place};
use crate::math::normalize;
use crate::packet::{SubPacket, set_vec3, vec3};
use crate::stack::{Background, Context, SkyLight};
use crate::texture::Picture;
use crate::view::Up;

/// A picture that shows the whole sphere around the scene (equirectangular: columns are directions around the axis that is up, rows go from
/// there down), and lights it. What is in its middle is behind the scene, seen from the front: at negative z where y is up, at y where z is.
#[derive(Clone)]
pub struct Panorama(Arc<Texels>);

struct Texels {
    size: [usize; 2],
    /// Linear RGB, by rows from above.
    colors: Vec<[f32; 3]>,
    /// How far it is turned, in parts of a whole turn.
    turn: f32,
    light: Option<Environment>,
}

/// The table by which it lights has no more columns than this: averages of texels of larger pictures.
const COLUMNS: usize = 1024;

impl Panorama {
    /// A picture turned by `rotate` degrees clockwise, seen from above, whose light is multiplied by `strength`. A number that is not finite
    /// turns it by nothing; a strength that is not, or below 0, makes it black.
    pub fn new(picture: &Picture, rotate: f32, strength: f32) -> Self {
        let strength = if strength.is_finite() { strength.max(0.0) } else { 0.0 };
        let most = Vec3::splat(f32::MAX);
        let colors: Vec<_> =
            picture.colors().into_iter().map(|color| (color * strength).min(most).to_array()).collect();
        let size = picture.size().map(|side| side as usize);
        let turn = if rotate.is_finite() { (rotate / 360.0).rem_euclid(1.0) } else { 0.0 };
        let light = environment(size, &colors, turn);
        Self(Arc::new(Texels { size, colors, turn, light }))
    }

    /// The radiance in a direction of any length, with y up: between the middles of texels.
    fn at(&self, direction: Vec3) -> Vec3 {
        let Texels { size: [columns, rows], colors, turn, .. } = &*self.0;
        let [u, v] = place(normalize(direction));
        let x = (u - turn).rem_euclid(1.0) * *columns as f32 - 0.5;
        let y = v * *rows as f32 - 0.5;
        let (left, top) = (x.floor(), y.floor());
        let texel = |column: f32, row: f32| {
            let column = (column as isize).rem_euclid(*columns as isize) as usize;
            let row = (row.max(0.0) as usize).min(rows - 1);
            Vec3::from(colors[row * columns + column])
        };
        let row = |row: f32| {
            let (a, b) = (texel(left, row), texel(left + 1.0, row));
            a + (b - a) * (x - left)
        };
        let (a, b) = (row(top), row(top + 1.0));
        a + (b - a) * (y - top)
    }
}

/// The light of a picture: as many texels are one of the table as it takes to have few enough.
fn environment([columns, rows]: [usize; 2], colors: &[[f32; 3]], turn: f32) -> Option<Environment> {
    let by = columns.div_ceil(COLUMNS).max(rows.div_ceil(COLUMNS / 2)).max(1);
    let [width, height] = [columns, rows].map(|side| side.div_ceil(by));
    let mut table = vec![Vec3::ZERO; width * height];
    for (row, table) in table.chunks_mut(width).enumerate() {
        let rows = row * rows / height..(row + 1) * rows / height;
        for (column, texel) in table.iter_mut().enumerate() {
            let some = column * columns / width..(column + 1) * columns / width;
            let share = 1.0 / (rows.len() * some.len()) as f32;
            for row in rows.clone() {
                let of_row = &colors[row * columns..(row + 1) * columns];
                of_row[some.clone()].iter().for_each(|&color| *texel += Vec3::from(color) * share);
            }
        }
    }
    Environment::new(width, &table).map(|light| light.turned(turn))
}

impl Background for Panorama {
    fn shade(&self, context: &Context<'_>, misses: &mut SubPacket<'_>) {
        let up = context.scene.up;
        let count = misses.len();
        let (directions, mut colors) = misses.directions_and_colors();
        for i in 0..count {
            set_vec3(&mut colors, i, self.at(up.to_y_up(vec3(&directions, i))));
        }
    }

    fn light(&self, _up: Up) -> Option<SkyLight> {
        let lights = self.0.light.iter().map(|light| Arc::new(light.clone()) as _).collect();
        Some(SkyLight { lights, ambient: Arc::new(Hemisphere { above: Vec3::ZERO, below: Vec3::ZERO }) })
    }
}

impl fmt::Debug for Panorama {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Panorama").field("size", &self.0.size).field("turn", &self.0.turn).finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light::direction;
    use crate::texture::Texels;

    fn picture(size: [u32; 2], color: impl Fn(u32, u32) -> [f32; 3]) -> Picture {
        let texel = |i: u32| {
            let [r, g, b] = color(i % size[0], i / size[0]);
            [r, g, b, 1.0]
        };
        Picture::new(size, Texels::Floats((0..size[0] * size[1]).map(texel).collect())).unwrap()
    }

    #[test]
    fn texels_are_seen_where_they_are_and_turn_clockwise() {
        let around = picture([8, 4], |x, y| [x as f32, y as f32, 0.0]);
        let seen = |rotate, x: f32, y: f32| {
            Panorama::new(&around, rotate, 1.0).at(direction((x + 0.5) / 8.0, (y + 0.5) / 4.0))
        };
        for (x, y) in [(0.0, 0.0), (3.0, 1.0), (7.0, 3.0), (4.0, 2.0)] {
            assert!(seen(0.0, x, y).distance(Vec3::new(x, y, 0.0)) < 1e-4, "{x} {y}");
            assert!(seen(90.0, (x + 2.0) % 8.0, y).distance(Vec3::new(x, y, 0.0)) < 1e-4, "{x} {y}");
        }
        assert!((seen(0.0, 3.5, 1.0).x - 3.5).abs() < 1e-4);
        // What was in front of one who looks at negative z is to the right after a quarter turn.
        let mark = picture([8, 4], |x, _| [f32::from(x == 3 || x == 4); 3]);
        assert!(Panorama::new(&mark, 90.0, 2.0).at(Vec3::X).x > 1.99);
        assert!(Panorama::new(&mark, 90.0, f32::NAN).at(Vec3::X) == Vec3::ZERO);
    }

    #[test]
    fn pictures_of_any_size_light() {
        for size in [[1, 1], [2, 1], [3000, 2], [1, 700], [1025, 513]] {
            let light = Panorama::new(&picture(size, |_, _| [0.5; 3]), 10.0, 2.0).light(Up::Y).unwrap();
            assert_eq!(light.lights.len(), 1, "{size:?}");
        }
        let dark = Panorama::new(&picture([4, 2], |_, _| [0.0; 3]), 0.0, 1.0);
        assert!(dark.light(Up::Z).unwrap().lights.is_empty());
    }
}
