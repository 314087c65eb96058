//! Colours by value: what a transfer function says without its extinction, as a table over a range.

use super::transfer::TransferFunction;

/// Entries of a table.
const ENTRIES: usize = 1024;
/// The colour of what is no number, linear RGB.
const GREY: [f32; 3] = [0.2; 3];

/// The colours of values.
#[derive(Clone, Debug, PartialEq)]
pub struct ColorMap {
    /// What people call it.
    pub name: String,
    range: [f32; 2],
    per_unit: f32,
    table: Vec<[f32; 3]>,
}

impl ColorMap {
    /// The colours of a transfer function, stretched over a range if its values are relative. What is below counts as the least value,
    /// what is above as the greatest.
    pub fn new(function: &TransferFunction, range: [f32; 2]) -> Self {
        let [low, high] = range.map(f64::from);
        let points = function.resolve([low, high], 1.0);
        let at = |i: usize| {
            let value = low + (high - low) * i as f64 / (ENTRIES - 1) as f64;
            let next = points.partition_point(|point| point.value <= value);
            let (Some(a), Some(b)) = (next.checked_sub(1).map(|i| &points[i]), points.get(next)) else {
                return points.get(next).or(points.last()).map_or(GREY, |point| point.color);
            };
            let part = ((value - a.value) / (b.value - a.value)) as f32;
            [0, 1, 2].map(|k| a.color[k] * (1.0 - part) + b.color[k] * part)
        };
        let per_unit = ((ENTRIES - 1) as f64 / (high * 0.5 - low * 0.5)) as f32;
        Self { name: function.name.clone(), range, per_unit, table: (0..ENTRIES).map(at).collect() }
    }

    /// The colour of a value, linear RGB; grey if it is no number.
    #[inline]
    pub fn color(&self, value: f32) -> [f32; 3] {
        if value.is_nan() {
            return GREY;
        }
        // Halved, so that the difference of two values is finite.
        let entry = (value * 0.5 - self.range[0] * 0.5) * self.per_unit + 0.5;
        // Of a range of one value, NaN.
        self.table[(entry.max(0.0) as usize).min(ENTRIES - 1)]
    }

    /// From which value to which.
    pub fn range(&self) -> [f32; 2] {
        self.range
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::Preset;

    #[test]
    fn values_have_the_colours_of_the_function() {
        let function = Preset::CoolWarm.function([0.0, 1.0]);
        let map = ColorMap::new(&function, [10.0, 30.0]);
        let ends = [function.points[0].color, function.points[function.points.len() - 1].color];
        assert_eq!([map.color(10.0), map.color(30.0)], ends);
        assert_eq!([map.color(-5.0), map.color(f32::INFINITY)], ends);
        assert_eq!(map.color(f32::NAN), GREY);
        assert!(map.color(20.0).iter().all(|x| (0.5..0.9).contains(x)), "{:?}", map.color(20.0));
        let one = ColorMap::new(&function, [7.0, 7.0]);
        assert!(ends.contains(&one.color(7.0)) && ends.contains(&one.color(8.0)));
    }

    #[test]
    fn labels_are_steps() {
        let function = TransferFunction::labels("labels", [1, 2, 5]).unwrap();
        let map = ColorMap::new(&function, [0.0, 8.0]);
        let colors = [1.0, 2.0, 5.0].map(|label| map.color(label));
        assert!(colors[0] != colors[1] && colors[1] != colors[2]);
        assert_eq!(map.color(1.25), colors[0]);
    }
}
