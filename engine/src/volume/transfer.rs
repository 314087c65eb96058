//! Transfer functions: the colour and the extinction that each value of a volume has. Between points both are linear; light is
//! emitted and absorbed as Max, "Optical Models for Direct Volume Rendering" (1995), has it.

use super::color_space::from_hsv;
use crate::color::from_srgb;

/// What one value looks like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TransferPoint {
    /// The value.
    pub value: f64,
    /// Its colour, linear RGB.
    pub color: [f32; 3],
    /// Part of the light that is lost in a unit of length, for short lengths: finite, at least 0.
    pub extinction: f64,
}

/// What numbers of a transfer function are measured by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// They mean what they say: values are those of the volume, lengths those of its space.
    Absolute,
    /// Values: 0 is the least value of the volume, 1 the greatest. Lengths: the volume's longest side is 1.
    Relative,
}

/// The colour and the extinction of each value.
#[derive(Clone, Debug, PartialEq)]
pub struct TransferFunction {
    /// What people call it.
    pub name: String,
    /// At least one, by value; two of one value are a jump. Before the first and after the last nothing changes.
    pub points: Vec<TransferPoint>,
    /// What values are measured by.
    pub values: Scale,
    /// What the length is measured by that extinction is for.
    pub lengths: Scale,
}

/// The most points of a function that is not made in a program.
pub const MOST_POINTS: usize = 1 << 16;

/// The most labels that get colours.
pub const MOST_LABELS: usize = 4096;

/// What is wrong with a transfer function. Points are counted from 1.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum TransferError {
    /// No points.
    #[error("a transfer function needs at least one point")]
    NoPoints,
    /// More labels than there are colours for.
    #[error("{0} labels: at most {MOST_LABELS} get colours")]
    ManyLabels(usize),
    /// A value that is no number.
    #[error("the value of point {0} is not finite")]
    Value(usize),
    /// A value below the one before, or a third of the same.
    #[error("the values must ascend, at most two of them the same; that of point {0} does not")]
    Order(usize),
    /// A colour that is none.
    #[error("the colour of point {0} is negative or not finite")]
    Color(usize),
    /// An extinction that is none.
    #[error("the extinction of point {0} is negative or not finite")]
    Extinction(usize),
}

impl TransferFunction {
    /// A function through some points.
    ///
    /// # Errors
    /// If there are none, if their values do not ascend, or if something is negative or not finite.
    pub fn new(
        name: impl Into<String>,
        points: Vec<TransferPoint>,
        values: Scale,
        lengths: Scale,
    ) -> Result<Self, TransferError> {
        if points.is_empty() {
            return Err(TransferError::NoPoints);
        }
        for (i, point) in points.iter().enumerate() {
            let number = i + 1;
            if !point.value.is_finite() {
                return Err(TransferError::Value(number));
            }
            if !point.color.iter().all(|channel| (0.0..f32::INFINITY).contains(channel)) {
                return Err(TransferError::Color(number));
            }
            if !(0.0..f64::INFINITY).contains(&point.extinction) {
                return Err(TransferError::Extinction(number));
            }
            let falls = i > 0 && point.value < points[i - 1].value;
            if falls || i > 1 && point.value == points[i - 2].value {
                return Err(TransferError::Order(number));
            }
        }
        Ok(Self { name: name.into(), points, values, lengths })
    }

    /// A colour for each of some labels, as segmentations have them: from half below a whole number to half above it. Label 0 and
    /// what is no label are clear. A label has the same colour in every volume. Samples are to be looked up, not interpolated: between
    /// labels 1 and 3 is no 2.
    ///
    /// # Errors
    /// If there is no label, or if there are too many.
    pub fn labels(name: impl Into<String>, labels: impl IntoIterator<Item = i32>) -> Result<Self, TransferError> {
        let labels: Vec<_> = labels.into_iter().map(|l| (f64::from(l), label_color(l))).collect();
        Self::steps(name, labels)
    }

    /// As [`labels`](Self::labels), in given colours, linear RGB. Labels that are no whole numbers reach half the way to the next. Of
    /// two of one label the first counts.
    ///
    /// # Errors
    /// Those of [`labels`](Self::labels), and those of [`new`](Self::new).
    pub fn steps(
        name: impl Into<String>,
        labels: impl IntoIterator<Item = (f64, [f32; 3])>,
    ) -> Result<Self, TransferError> {
        let mut labels: Vec<_> = labels.into_iter().collect();
        labels.sort_by(|a, b| a.0.total_cmp(&b.0));
        // 0 and -0 are one label.
        labels.dedup_by(|a, b| a.0 == b.0);
        if labels.len() > MOST_LABELS {
            return Err(TransferError::ManyLabels(labels.len()));
        }
        let touches = |i: usize| labels.get(i + 1).is_some_and(|next| next.0 - labels[i].0 <= 1.0);
        let middle = |i: usize| labels[i].0 + (labels[i + 1].0 - labels[i].0) / 2.0;
        let mut points = Vec::new();
        for (i, &(label, color)) in labels.iter().enumerate() {
            let extinction = if label == 0.0 { 0.0 } else { LABEL_EXTINCTION };
            let inside = |value| TransferPoint { value, color, extinction };
            let clear = |value| TransferPoint { value, color, extinction: 0.0 };
            // Where labels touch, the jump is from one colour to the other.
            match i.checked_sub(1).filter(|&before| touches(before)) {
                Some(before) => points.push(inside(middle(before))),
                None => points.extend([clear(label - 0.5), inside(label - 0.5)]),
            }
            if touches(i) {
                points.push(inside(middle(i)));
            } else {
                points.extend([inside(label + 0.5), clear(label + 0.5)]);
            }
        }
        Self::new(name, points, Scale::Absolute, Scale::Relative)
    }

    /// The values that it is for, in a volume with this range: their middle, and how wide they are; 1 if it has one value only.
    pub fn span(&self, range: [f64; 2]) -> [f64; 2] {
        let points = self.resolve(range, 1.0);
        let ends = points.first().zip(points.last());
        let [low, high] = ends.map_or([0.0, 1.0], |(first, last)| [first.value, last.value]);
        [low * 0.5 + high * 0.5, if high > low { high - low } else { 1.0 }]
    }

    /// The points in the values and lengths of a volume whose least and greatest value and whose longest side are given; the side
    /// must be above 0.
    pub fn resolve(&self, range: [f64; 2], longest_side: f64) -> Vec<TransferPoint> {
        let mut least = f64::MIN;
        let point = |point: &TransferPoint| {
            let value = match self.values {
                Scale::Absolute => point.value,
                // Rounded values of a wide range might fall.
                Scale::Relative => range[0] * (1.0 - point.value) + range[1] * point.value,
            };
            // NaN, from a range or values out of all proportion, changes nothing.
            least = if value > least { value.min(f64::MAX) } else { least };
            let extinction = match self.lengths {
                Scale::Absolute => point.extinction,
                Scale::Relative => (point.extinction / longest_side).min(f64::MAX),
            };
            TransferPoint { value: least, extinction, ..*point }
        };
        self.points.iter().map(point).collect()
    }
}

/// Extinction of labels, for a longest side of 1: nearly opaque after a fiftieth of it.
const LABEL_EXTINCTION: f64 = 200.0;

/// The colour of a label, linear RGB: neighbours have hues that are far apart, by the golden ratio.
fn label_color(label: i32) -> [f32; 3] {
    let hue = (f64::from(label) * 0.618_033_988_749_895).rem_euclid(1.0);
    let saturation = [0.85, 0.6, 0.4][label.rem_euclid(3) as usize];
    let value = [0.95, 0.75][label.rem_euclid(2) as usize];
    from_srgb(from_hsv([hue, saturation, value])).to_array()
}

/// Two piecewise linear functions of one value made points: one has the colours, one the extinction. Each has at least one point,
/// values that ascend, and jumps where two are the same.
pub(crate) fn joined(colors: &[(f64, [f32; 3])], extinctions: &[(f64, f64)]) -> Vec<TransferPoint> {
    let mut values: Vec<f64> = colors.iter().map(|c| c.0).chain(extinctions.iter().map(|e| e.0)).collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    let mut points = Vec::with_capacity(values.len());
    for value in values {
        let point = |(color, extinction): ([f64; 3], [f64; 1])| TransferPoint {
            value,
            color: color.map(|channel| channel as f32),
            extinction: extinction[0],
        };
        let color = |side| at(colors, value, side, |color| color.map(f64::from));
        let extinction = |side| at(extinctions, value, side, |extinction| [extinction]);
        let [below, above] = [Side::Below, Side::Above].map(|side| point((color(side), extinction(side))));
        points.push(below);
        if above != below {
            points.push(above);
        }
    }
    points
}

/// From which side a value is met.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Side {
    Below,
    Above,
}

/// A piecewise linear function, seen from one side of a value.
fn at<T: Copy, const N: usize>(
    points: &[(f64, T)],
    value: f64,
    side: Side,
    numbers: impl Fn(T) -> [f64; N],
) -> [f64; N] {
    let next = points.partition_point(|point| if side == Side::Below { point.0 < value } else { point.0 <= value });
    let (Some(before), Some(after)) = (next.checked_sub(1).map(|i| points[i]), points.get(next)) else {
        return numbers(points[next.min(points.len() - 1)].1);
    };
    let part = (value - before.0) / (after.0 - before.0);
    let (a, b) = (numbers(before.1), numbers(after.1));
    std::array::from_fn(|k| a[k] * (1.0 - part) + b[k] * part)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(value: f64, extinction: f64) -> TransferPoint {
        TransferPoint { value, color: [0.25, 0.5, 1.0], extinction }
    }

    fn made(points: &[TransferPoint]) -> Result<TransferFunction, TransferError> {
        TransferFunction::new("test", points.to_vec(), Scale::Absolute, Scale::Absolute)
    }

    #[test]
    fn functions_are_checked() {
        assert_eq!(made(&[]), Err(TransferError::NoPoints));
        assert!(made(&[point(1.0, 0.0)]).is_ok());
        assert!(made(&[point(1.0, 0.0), point(1.0, 2.0), point(2.0, 2.0)]).is_ok());
        assert_eq!(made(&[point(1.0, 0.0), point(0.5, 2.0)]), Err(TransferError::Order(2)));
        assert_eq!(made(&[point(1.0, 0.0); 3]), Err(TransferError::Order(3)));
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(made(&[point(0.0, 0.0), point(bad, 0.0)]), Err(TransferError::Value(2)));
            assert_eq!(made(&[point(0.0, bad)]), Err(TransferError::Extinction(1)));
            let color = [0.0, bad as f32, 0.0];
            assert_eq!(made(&[TransferPoint { color, ..point(0.0, 0.0) }]), Err(TransferError::Color(1)));
        }
        assert_eq!(made(&[point(0.0, -0.1)]), Err(TransferError::Extinction(1)));
        assert_eq!(made(&[TransferPoint { color: [-0.1, 0.0, 0.0], ..point(0.0, 0.0) }]), Err(TransferError::Color(1)));
    }

    #[test]
    fn relative_functions_fit_the_volume() {
        let mut function = made(&[point(0.0, 0.0), point(0.25, 3.0), point(1.0, 5.0)]).unwrap();
        assert_eq!(function.resolve([-100.0, 300.0], 4.0), function.points);
        function.values = Scale::Relative;
        let values = |function: &TransferFunction, range| {
            function.resolve(range, 4.0).iter().map(|point| point.value).collect::<Vec<_>>()
        };
        assert_eq!(values(&function, [-100.0, 300.0]), [-100.0, 0.0, 300.0]);
        assert_eq!(values(&function, [7.0, 7.0]), [7.0; 3]);
        let wide = values(&function, [-f64::MAX, f64::MAX]);
        assert!(wide[0] == -f64::MAX && wide[1] < -f64::MAX / 2.01 && wide[2] == f64::MAX, "{wide:?}");
        function.points[2].value = 1e300;
        assert!(function.resolve([1e10, 2e10], 1.0).is_sorted_by(|a, b| a.value <= b.value));
        function.lengths = Scale::Relative;
        let extinctions: Vec<_> = function.resolve([0.0, 1.0], 4.0).iter().map(|point| point.extinction).collect();
        assert_eq!(extinctions, [0.0, 0.75, 1.25]);
        assert!(function.resolve([0.0, 1.0], 1e-320).iter().all(|point| point.extinction.is_finite()));
    }

    /// Colour and extinction of a value.
    fn looks(function: &TransferFunction, value: f64, side: Side) -> ([f64; 3], f64) {
        let colors: Vec<_> = function.points.iter().map(|point| (point.value, point.color)).collect();
        let extinctions: Vec<_> = function.points.iter().map(|point| (point.value, point.extinction)).collect();
        let color = at(&colors, value, side, |color| color.map(f64::from));
        (color, at(&extinctions, value, side, |extinction| [extinction])[0])
    }

    #[test]
    fn labels_are_steps() {
        let function = TransferFunction::labels("labels", [7, 3, 0, 1, 3, 4]).unwrap();
        assert_eq!((function.values, function.lengths), (Scale::Absolute, Scale::Relative));
        for label in [1, 3, 4, 7] {
            let color = label_color(label).map(f64::from);
            for (value, side) in [(-0.5, Side::Above), (0.0, Side::Above), (0.5, Side::Below)] {
                let there = looks(&function, f64::from(label) + value, side);
                assert_eq!(there, (color, LABEL_EXTINCTION), "{label} {value}");
            }
        }
        for clear in [-3.0, 0.0, 0.4, 2.0, 1.6, 5.0, 6.4, 8.0] {
            assert_eq!(looks(&function, clear, Side::Above).1, 0.0, "{clear}");
        }
        assert_eq!(looks(&function, 0.5, Side::Below).1, 0.0);
        assert_eq!(TransferFunction::labels("none", []), Err(TransferError::NoPoints));
        assert!(TransferFunction::labels("many", 0..4096).is_ok());
        assert_eq!(TransferFunction::labels("more", 0..4097), Err(TransferError::ManyLabels(4097)));
        assert!(TransferFunction::labels("ends", [i32::MIN, i32::MAX]).is_ok());
    }

    #[test]
    fn labels_have_colours_of_their_own() {
        let mut colors: Vec<_> = (1..=4096).map(label_color).collect();
        let apart = |a: [f32; 3], b: [f32; 3]| (0..3).map(|k| (a[k] - b[k]).abs()).fold(0.0, f32::max);
        for pair in colors[..64].windows(2) {
            assert!(apart(pair[0], pair[1]) > 0.15, "{pair:?}");
        }
        colors.sort_by(|a, b| a.partial_cmp(b).unwrap());
        colors.dedup();
        assert_eq!(colors.len(), 4096);
    }

    #[test]
    fn labels_between_whole_numbers_share_the_way() {
        let colors = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let function = TransferFunction::steps("fine", [(0.1, colors[0]), (0.3, colors[1]), (2.0, colors[2])]).unwrap();
        assert_eq!(looks(&function, 0.19, Side::Above), ([1.0, 0.0, 0.0], LABEL_EXTINCTION));
        assert_eq!(looks(&function, 0.21, Side::Above), ([0.0, 1.0, 0.0], LABEL_EXTINCTION));
        assert_eq!(looks(&function, 0.79, Side::Above).1, LABEL_EXTINCTION);
        assert_eq!(looks(&function, 1.0, Side::Above).1, 0.0);
        assert_eq!(looks(&function, -0.41, Side::Above).1, 0.0);
    }

    #[test]
    fn colours_and_extinction_are_joined() {
        let colors = [(0.0, [0.0; 3]), (1.0, [1.0; 3])];
        let points = joined(&colors, &[(-1.0, 2.0), (0.5, 2.0), (0.5, 4.0), (2.0, 10.0)]);
        let found: Vec<_> = points.iter().map(|point| (point.value, point.color[0], point.extinction)).collect();
        assert_eq!(
            found,
            [(-1.0, 0.0, 2.0), (0.0, 0.0, 2.0), (0.5, 0.5, 2.0), (0.5, 0.5, 4.0), (1.0, 1.0, 6.0), (2.0, 1.0, 10.0)]
        );
    }
}
