//! Colour maps of ParaView, as its colour map editor writes them: JSON. What is made of them is said at
//! [`load_transfer`](super::load_transfer).

use std::path::Path;

use serde_json::{Map, Value};

use crate::color::from_srgb;
use crate::load::LoadError;
use crate::load::text::{counted, number, quoted};
use crate::volume::color_space::{between_diverging, between_hsv, between_lab};
use crate::volume::{MOST_POINTS, Scale, TransferFunction, joined};

/// Pieces that a map is made of at least, if it has any way to go between colours.
const PIECES: usize = 32;
/// ParaView's unit distance of opacity, by the longest side.
const UNIT: f64 = 0.01;
/// What is opaque lets this much through.
const OPAQUE: f64 = 0.999;
/// The greatest opacity of a map that has none.
const RAMP: f64 = 0.2;

pub(super) fn read(file: &Path, name: String, text: &str) -> Result<TransferFunction, LoadError> {
    let value: Value = serde_json::from_str(text).map_err(|error| {
        let problem = error.to_string();
        let problem = problem.split(" at line ").next().unwrap_or_default();
        let remedy = "check it in a text editor; all numbers must be finite";
        LoadError::new(file, format!("this is not JSON: {problem}"), remedy).at(error.line() as u64)
    })?;
    function(&value, name).map_err(|problem| LoadError::new(file, problem, "export it from ParaView again"))
}

fn function(value: &Value, name: String) -> Result<TransferFunction, String> {
    let is_map = |map: &&Map<String, Value>| map.contains_key("RGBPoints") || map.contains_key("IndexedColors");
    let map = match value {
        Value::Array(list) => list.iter().filter_map(Value::as_object).find(is_map),
        other => other.as_object().filter(is_map),
    };
    let map = map.ok_or("no colour map is in it: nothing has RGBPoints or IndexedColors")?;
    let name = map.get("Name").and_then(Value::as_str).map_or(name, str::to_owned);
    let Some(colors) = numbers::<4>(map, "RGBPoints")? else { return labels(map, name) };
    let colors = by_value(colors);
    let opacities = numbers::<4>(map, "Points")?.map(by_value);
    let (Some(first), Some(last)) = (colors.first(), colors.last()) else { return Err("RGBPoints is empty".into()) };
    let ends = [first[0], last[0]];
    for color in &colors {
        in_unit("a colour", &color[1..])?;
    }
    let values = if matches!(ends, [0.0 | -1.0, 1.0]) { Scale::Relative } else { Scale::Absolute };
    let fit = |value: f64, [low, high]: [f64; 2]| match values {
        Scale::Absolute => value,
        Scale::Relative if high > low => (value - low) / (high - low),
        Scale::Relative => 0.0,
    };

    let colors = between_colors(&colors, Way::of(map));
    let colors: Vec<_> =
        colors.into_iter().map(|(value, srgb)| (fit(value, ends), from_srgb(srgb).to_array())).collect();
    let opacities = opacities.unwrap_or_else(|| {
        let whole = |value, opacity| [value, opacity, 0.5, 0.0];
        vec![whole(ends[0], 0.0), whole(ends[1], RAMP)]
    });
    let (Some(first), Some(last)) = (opacities.first(), opacities.last()) else { return Err("Points is empty".into()) };
    let ends = [first[0], last[0]];
    for opacity in &opacities {
        in_unit("an opacity, midpoint or sharpness", &opacity[1..])?;
    }
    let opacities = between_opacities(&opacities).into_iter();
    let extinctions: Vec<_> = opacities.map(|(value, opacity)| (fit(value, ends), extinction(opacity))).collect();
    TransferFunction::new(name, joined(&colors, &extinctions), values, Scale::Relative)
        .map_err(|error| error.to_string())
}

/// Extinction for a longest side of 1.
fn extinction(opacity: f64) -> f64 {
    -libm::log1p(-opacity.min(OPAQUE)) / UNIT
}

/// Rows of so many numbers; `None`: there are none of that name.
fn numbers<const N: usize>(map: &Map<String, Value>, key: &str) -> Result<Option<Vec<[f64; N]>>, String> {
    let Some(value) = map.get(key) else { return Ok(None) };
    let list = value.as_array().ok_or_else(|| format!("{key} is not a list"))?;
    if !list.len().is_multiple_of(N) {
        return Err(format!("{key} has {}, not {N} a point", counted(list.len() as u64, "number")));
    }
    if list.len() / N > MOST_POINTS {
        return Err(format!("{key} has more than {MOST_POINTS} points"));
    }
    let mut rows = vec![[0.0; N]; list.len() / N];
    for (at, (number, value)) in rows.as_flattened_mut().iter_mut().zip(list).enumerate() {
        *number = value.as_f64().ok_or_else(|| format!("{key}[{at}] is not a number"))?;
    }
    Ok(Some(rows))
}

/// Rows by their value, their first number; of several with one value the first and the last, which are a jump.
fn by_value<const N: usize>(mut rows: Vec<[f64; N]>) -> Vec<[f64; N]> {
    rows.sort_by(|a, b| a[0].partial_cmp(&b[0]).unwrap_or(std::cmp::Ordering::Equal));
    let all = rows.clone();
    let mut at = 0_usize;
    rows.retain(|row| {
        at += 1;
        let same = |other: Option<&[f64; N]>| other.is_some_and(|other| other[0] == row[0]);
        !(same(all.get(at.wrapping_sub(2))) && same(all.get(at)))
    });
    rows
}

/// An error for a number that is not from 0 to 1.
fn in_unit(what: &str, numbers: &[f64]) -> Result<(), String> {
    match numbers.iter().find(|number| !(0.0..=1.0).contains(*number)) {
        Some(number) => Err(format!("{what} of {number} is not from 0 to 1")),
        None => Ok(()),
    }
}

/// How colours go from point to point.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Way {
    Rgb,
    Hsv { wrap: bool },
    Lab,
    Diverging,
    Step,
}

impl Way {
    /// What a map says; what is not known is RGB.
    fn of(map: &Map<String, Value>) -> Self {
        let wrap = map.get("HSVWrap").is_some_and(|wrap| wrap.as_bool() == Some(true) || wrap.as_f64() == Some(1.0));
        match map.get("ColorSpace").and_then(Value::as_str).map(str::to_ascii_lowercase).as_deref() {
            Some("hsv") => Self::Hsv { wrap },
            Some("lab" | "labciede2000" | "cielab") => Self::Lab,
            Some("diverging") => Self::Diverging,
            Some("step") => Self::Step,
            _ => Self::Rgb,
        }
    }

    fn between(self, ends: [[f64; 3]; 2], part: f64) -> [f64; 3] {
        match self {
            Self::Rgb => [0, 1, 2].map(|k| ends[0][k] * (1.0 - part) + ends[1][k] * part),
            Self::Hsv { wrap } => between_hsv(ends, part, wrap),
            Self::Lab => between_lab(ends, part),
            Self::Diverging => between_diverging(ends, part),
            Self::Step => ends[1],
        }
    }
}

/// Colours as sRGB, in pieces that may be linear.
fn between_colors(points: &[[f64; 4]], way: Way) -> Vec<(f64, [f64; 3])> {
    let color = |point: &[f64; 4]| [point[1], point[2], point[3]];
    let pieces = if way == Way::Step { 1 } else { PIECES.div_ceil(points.len().saturating_sub(1).max(1)) };
    let mut colors = vec![(points[0][0], color(&points[0]))];
    for pair in points.windows(2) {
        let (ends, [low, high]) = ([color(&pair[0]), color(&pair[1])], [pair[0][0], pair[1][0]]);
        if way == Way::Step {
            // From the first end on it is the colour of the second.
            colors.extend([(low, ends[1]), (high, ends[1])]);
            continue;
        }
        let pieces = if low < high { pieces } else { 1 };
        colors.extend((1..pieces).map(|i| {
            let part = i as f64 / pieces as f64;
            (low * (1.0 - part) + high * part, way.between(ends, part))
        }));
        colors.push((high, ends[1]));
    }
    colors
}

/// Opacities in pieces of which each has nearly linear extinction. At the midpoint of a pair of points half the way is gone; a sharpness
/// of 1 is a step there, 0 is linear, and between them the way gets the steeper and the shorter.
fn between_opacities(points: &[[f64; 4]]) -> Vec<(f64, f64)> {
    let pieces = PIECES.div_ceil(points.len().saturating_sub(1).max(1)).max(4);
    let mut opacities = vec![(points[0][0], points[0][1])];
    for pair in points.windows(2) {
        let [[low, a, midpoint, sharpness], [high, b, ..]] = [pair[0], pair[1]];
        let midpoint = midpoint.clamp(1e-5, 1.0 - 1e-5);
        let value = |part: f64| low * (1.0 - part) + high * part;
        if a == b || low == high {
            // A jump, or nothing between.
        } else if sharpness > 0.99 {
            opacities.extend([(value(midpoint), a), (value(midpoint), b)]);
        } else {
            let half = 0.5 * (1.0 - sharpness);
            opacities.extend((0..=pieces).map(|i| {
                // How far the opacity has come, and where that is.
                let done = i as f64 / pieces as f64;
                let even = 0.5 + (2.0 * done - 1.0) * half;
                let part =
                    if even < 0.5 { 2.0 * even * midpoint } else { midpoint + (2.0 * even - 1.0) * (1.0 - midpoint) };
                (value(part), a * (1.0 - done) + b * done)
            }));
        }
        opacities.push((high, b));
    }
    opacities.dedup();
    opacities
}

/// A step for each label.
fn labels(map: &Map<String, Value>, name: String) -> Result<TransferFunction, String> {
    let colors = numbers::<3>(map, "IndexedColors")?.unwrap_or_default();
    if colors.is_empty() {
        return Err("IndexedColors is empty".into());
    }
    for color in &colors {
        in_unit("a colour", color)?;
    }
    let annotations = match map.get("Annotations") {
        None => &[][..],
        Some(Value::Array(list)) if list.len().is_multiple_of(2) => list,
        Some(_) => return Err("Annotations is not a list of values and texts".into()),
    };
    let mut values = Vec::new();
    for pair in annotations.chunks(2) {
        let value = match &pair[0] {
            Value::String(text) => number(text.trim()).filter(|value| value.is_finite()),
            other => other.as_f64(),
        };
        values.push(value.ok_or_else(|| format!("the annotation {} is for no number", quoted(&pair[0].to_string())))?);
    }
    if values.is_empty() {
        values = (0..colors.len()).map(|label| label as f64).collect();
    }
    // As in ParaView, colours start again when there are not enough.
    let colors = colors.iter().cycle().map(|&color| from_srgb(color).to_array());
    TransferFunction::steps(name, values.into_iter().zip(colors)).map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::TransferPoint;

    fn parse(text: &str) -> Result<TransferFunction, String> {
        read(Path::new("a.json"), "a".into(), text).map_err(|error| error.to_string())
    }

    /// What a value looks like.
    fn at(function: &TransferFunction, value: f64) -> TransferPoint {
        let points = &function.points;
        let next = points.partition_point(|point| point.value < value);
        let (Some(a), Some(&b)) = (next.checked_sub(1).map(|i| points[i]), points.get(next)) else {
            return points[next.min(points.len() - 1)];
        };
        let part = (value - a.value) / (b.value - a.value);
        let color = [0, 1, 2].map(|k| a.color[k] * (1.0 - part) as f32 + b.color[k] * part as f32);
        TransferPoint { value, color, extinction: a.extinction * (1.0 - part) + b.extinction * part }
    }

    fn near(color: [f32; 3], srgb: [f64; 3]) {
        let expected = from_srgb(srgb).to_array();
        assert!((0..3).all(|k| (color[k] - expected[k]).abs() < 0.006), "{color:?} for {expected:?}");
    }

    const COOL_TO_WARM: &str = r#"[{"ColorSpace": "Diverging", "Name": "Cool to Warm", "NanColor": [1, 1, 0],
        "RGBPoints": [0.0, 0.2, 0.3, 0.75, 0.4, 0.865, 0.865, 0.865, 1.0, 0.7, 0.02, 0.15]}]"#;

    #[test]
    fn maps_without_data_are_relative() {
        let function = parse(COOL_TO_WARM).unwrap();
        assert_eq!(
            (function.name.as_str(), function.values, function.lengths),
            ("Cool to Warm", Scale::Relative, Scale::Relative)
        );
        near(at(&function, 0.1).color, [0.355_982, 0.509_625, 0.913_781]);
        near(at(&function, 0.5).color, [0.935_26, 0.809_46, 0.740_223]);
        assert_eq!(at(&function, 0.0).extinction, 0.0);
        assert!((at(&function, 1.0).extinction - 22.314_355).abs() < 1e-5);
        // The opacities have ends of their own.
        let both =
            r#"{"RGBPoints": [-1, 0, 0, 0, 1, 1, 1, 1], "Points": [0, 0, 0.5, 0, 50, 0.5, 0.5, 0, 100, 1, 0.5, 0]}"#;
        let function = parse(both).unwrap();
        assert_eq!(function.values, Scale::Relative);
        near(at(&function, 0.5).color, [0.5; 3]);
        assert!((at(&function, 0.5).extinction - 69.314_718).abs() < 1e-5);
        assert!((at(&function, 1.0).extinction - 690.775_53).abs() < 1e-4);
    }

    #[test]
    fn other_maps_are_absolute() {
        let text = r#"{"Name": "CT", "ColorSpace": "RGB", "RGBPoints": [-1000, 0, 0, 0, 0, 1, 0, 0, 1000, 1, 1, 1],
            "Points": [-2000, 0, 0.5, 0, 1000, 0.75, 0.5, 0]}"#;
        let function = parse(text).unwrap();
        assert_eq!((function.values, function.lengths), (Scale::Absolute, Scale::Relative));
        near(at(&function, -500.0).color, [0.5, 0.0, 0.0]);
        for (value, opacity) in [(-2000.0, 0.0), (-500.0, 0.375), (700.0, 0.675), (2000.0, 0.75)] {
            let found = 1.0 - (-at(&function, value).extinction * 0.01).exp();
            assert!((found - opacity).abs() < 1e-3, "{value}: {found}");
        }
    }

    #[test]
    fn opacity_has_midpoints_and_sharpness() {
        let opacity = |points: &str, value| {
            let text = format!(r#"{{"RGBPoints": [0, 0, 0, 0, 10, 1, 1, 1], "Points": [{points}]}}"#);
            1.0 - (-at(&parse(&text).unwrap(), value).extinction * 0.01).exp()
        };
        let near = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-3, "{found} for {expected}");
        // As VTK has it.
        for (value, expected) in [(0.5, 0.166_667), (3.0, 0.5), (4.0, 0.557_143), (9.0, 0.842_857)] {
            near(opacity("0, 0.1, 0.3, 0, 10, 0.9, 0.5, 0", value), expected);
        }
        let step = "0, 0.1, 0.3, 1, 10, 0.9, 0.5, 0";
        near(opacity(step, 2.9), 0.1);
        near(opacity(step, 3.1), 0.9);
        let steep = "0, 0.1, 0.5, 0.5, 10, 0.9, 0.5, 0";
        near(opacity(steep, 2.0), 0.1);
        near(opacity(steep, 5.0), 0.5);
        near(opacity(steep, 8.0), 0.9);
    }

    #[test]
    fn colour_spaces() {
        let color = |space: &str, value| {
            let text = format!(r#"{{"ColorSpace": {space}, "RGBPoints": [0, 0, 0, 1, 0.5, 0, 0, 1, 1, 1, 0, 0]}}"#);
            at(&parse(&text).unwrap(), value).color
        };
        near(color(r#""RGB""#, 0.75), [0.5, 0.0, 0.5]);
        near(color(r#""Fancy""#, 0.75), [0.5, 0.0, 0.5]);
        near(color("7", 0.75), [0.5, 0.0, 0.5]);
        near(color(r#""HSV""#, 0.75), [0.0, 1.0, 0.0]);
        near(color(r#""HSV", "HSVWrap": 1"#, 0.75), [1.0, 0.0, 1.0]);
        near(color(r#""Lab""#, 0.75), between_lab([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]], 0.5));
        near(color(r#""Step""#, 0.51), [1.0, 0.0, 0.0]);
        near(color(r#""Step""#, 0.49), [0.0, 0.0, 1.0]);
    }

    #[test]
    fn labels_have_the_colours_of_their_annotations() {
        let text = r#"[{"Name": "organs", "Annotations": ["0", "nothing", "3", "liver", "4", "spleen"],
            "IndexedColors": [1, 1, 1, 1, 0, 0]}]"#;
        let function = parse(text).unwrap();
        assert_eq!(function.values, Scale::Absolute);
        near(at(&function, 3.0).color, [1.0, 0.0, 0.0]);
        near(at(&function, 4.0).color, [1.0; 3]);
        let extinctions = [0.0, 1.0, 2.4, 3.0, 4.4, 5.0].map(|value| at(&function, value).extinction > 0.0);
        assert_eq!(extinctions, [false, false, false, true, true, false]);
        let plain = parse(r#"{"IndexedColors": [1, 1, 1, 1, 0, 0]}"#).unwrap();
        near(at(&plain, 1.0).color, [1.0, 0.0, 0.0]);
    }

    #[test]
    fn order_and_jumps() {
        let text = r#"{"RGBPoints": [10, 1, 1, 1, 5, 0, 0, 0, 5, 0.3, 0.3, 0.3, 5, 1, 0, 0, 0, 0, 0, 0]}"#;
        let function = parse(text).unwrap();
        assert_eq!(function.values, Scale::Absolute);
        near(at(&function, 4.999).color, [0.0; 3]);
        near(at(&function, 5.001).color, [1.0, 0.0, 0.0]);
    }

    #[test]
    fn what_is_wrong_is_told_in_a_line() {
        let many = format!(r#"{{"RGBPoints": [{}0]}}"#, "0,".repeat(4 * 65_537 - 1));
        let deep = format!("{}1{}", "[".repeat(100_000), "]".repeat(100_000));
        for (text, expected) in [
            ("{", "a.json:1: this is not JSON: EOF"),
            ("[\n{\"RGBPoints\": [NaN]}]", "a.json:2: this is not JSON: expected value"),
            ("{\"RGBPoints\": [Infinity, 0, 0, 0]}", "a.json:1: this is not JSON"),
            ("{\"RGBPoints\": [1e999, 0, 0, 0]}", "a.json:1: this is not JSON: number out of range"),
            (&deep, "a.json:1: this is not JSON: recursion limit"),
            ("[]", "a.json: no colour map is in it"),
            ("[7, {\"Name\": \"x\"}]", "a.json: no colour map is in it"),
            (r#"{"RGBPoints": 7}"#, "a.json: RGBPoints is not a list"),
            (r#"{"RGBPoints": []}"#, "a.json: RGBPoints is empty"),
            (r#"{"RGBPoints": [0, 0, 0, 0, 1]}"#, "a.json: RGBPoints has 5 numbers, not 4 a point"),
            (r#"{"RGBPoints": [0, 0, "0", 0]}"#, "a.json: RGBPoints[2] is not a number"),
            (r#"{"RGBPoints": [0, 0, null, 0]}"#, "a.json: RGBPoints[2] is not a number"),
            (r#"{"RGBPoints": [0, 0, 255, 0]}"#, "a.json: a colour of 255 is not from 0 to 1"),
            (r#"{"RGBPoints": [0, 0, 0, 0], "Points": []}"#, "a.json: Points is empty"),
            (
                r#"{"RGBPoints": [0, 0, 0, 0], "Points": [0, 2, 0.5, 0]}"#,
                "a.json: an opacity, midpoint or sharpness of 2",
            ),
            (r#"{"IndexedColors": []}"#, "a.json: IndexedColors is empty"),
            (r#"{"IndexedColors": [1, 1]}"#, "a.json: IndexedColors has 2 numbers, not 3 a point"),
            (r#"{"IndexedColors": [1, 1, 1], "Annotations": ["1"]}"#, "a.json: Annotations is not a list"),
            (
                r#"{"IndexedColors": [1, 1, 1], "Annotations": ["air", "x"]}"#,
                "a.json: the annotation '\"air\"' is for no number",
            ),
            (&many, "a.json: RGBPoints has more than 65536 points"),
        ] {
            let error = parse(text).unwrap_err();
            assert!(error.starts_with(expected), "{error}");
            assert!(error.len() < 300 && !error.contains('\n'), "{error}");
        }
    }
}
