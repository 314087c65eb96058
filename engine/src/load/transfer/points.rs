//! The text format of transfer functions: a point a line. What it looks like is said at [`load_transfer`](super::load_transfer).

use std::path::Path;

use crate::color::from_srgb;
use crate::load::LoadError;
use crate::load::lines::Lines;
use crate::load::text::{counted, number, quoted};
use crate::volume::{MOST_POINTS, Scale, TransferFunction, TransferPoint};

/// A longer line is in no such file.
const LONGEST_LINE: usize = 1 << 12;
/// What to do about a file that is something else.
pub(super) const REMEDY: &str = "give a file that starts with 'mobula transfer 1', or a JSON colour map of ParaView";
/// What a line is.
const POINT: &str = "write: value red green blue extinction";

pub(super) fn read(file: &Path, name: String, text: &str) -> Result<TransferFunction, LoadError> {
    let mut lines = Lines::no_longer_than(LONGEST_LINE, text.as_bytes());
    let [mut values, mut lengths] = [None, None];
    let mut points: Vec<TransferPoint> = Vec::new();
    let mut started = false;
    loop {
        let next = lines.next(|_| false);
        let (line, text) = match next {
            Ok(Some((line, text))) => (line, text),
            Ok(None) => break,
            Err(stop) => return Err(stop.into_error(file, lines.number, false)),
        };
        let wrong = |problem: String, remedy: &str| LoadError::new(file, problem, remedy).at(line);
        let code = text.split('#').next().unwrap_or_default();
        let words: Vec<&str> = code.split_whitespace().collect();
        if !started {
            match words[..] {
                // Nothing but blanks may stand before.
                [] if text.trim().is_empty() => continue,
                ["mobula", "transfer", "1"] => started = true,
                ["mobula", "transfer", version] => {
                    let problem = format!("version {} of the format is not known", quoted(version));
                    return Err(wrong(problem, "write it as version 1"));
                }
                _ => return Err(wrong("this is no transfer function that Mobula knows".into(), REMEDY)),
            }
            continue;
        }
        match words[..] {
            [] => {}
            ["values", word] => scale(&mut values, word).map_err(|p| wrong(format!("values {p}"), SCALES))?,
            ["lengths", word] => scale(&mut lengths, word).map_err(|p| wrong(format!("lengths {p}"), SCALES))?,
            _ => {
                points.push(point(&words, points.last()).map_err(|problem| wrong(problem, POINT))?);
                if let [.., a, _, b] = points[..]
                    && a.value == b.value
                {
                    return Err(wrong(
                        "a third point of one value".into(),
                        "two of one value are a jump: leave one out",
                    ));
                }
                if points.len() > MOST_POINTS {
                    return Err(wrong(format!("more than {MOST_POINTS} points"), "leave some out"));
                }
            }
        }
    }
    let scale = |scale: Option<Scale>| scale.unwrap_or(Scale::Absolute);
    TransferFunction::new(name, points, scale(values), scale(lengths))
        .map_err(|error| LoadError::new(file, error.to_string(), POINT))
}

/// How a scale is written.
const SCALES: &str = "write absolute or relative, once";

/// What values or lengths are measured by.
fn scale(scale: &mut Option<Scale>, word: &str) -> Result<(), String> {
    let new = match word {
        "absolute" => Scale::Absolute,
        "relative" => Scale::Relative,
        _ => return Err(format!("are {}, which is not known", quoted(word))),
    };
    match scale.replace(new) {
        Some(_) => Err("are said twice".into()),
        None => Ok(()),
    }
}

/// The point of a line.
fn point(words: &[&str], before: Option<&TransferPoint>) -> Result<TransferPoint, String> {
    let mut numbers = [0.0; 5];
    if words.len() != numbers.len() && words.first().is_some_and(|word| number(word).is_some()) {
        return Err(format!("a point is 5 numbers, not {}", counted(words.len() as u64, "word")));
    }
    for (at, word) in words.iter().enumerate() {
        let value = number(word).ok_or_else(|| format!("{} is not a number", quoted(word)))?;
        if !value.is_finite() {
            return Err(format!("{} is not finite", quoted(word)));
        }
        *numbers.get_mut(at).ok_or("a point is 5 numbers")? = value;
    }
    if words.len() != numbers.len() {
        return Err(format!("a point is 5 numbers, not {}", counted(words.len() as u64, "word")));
    }
    let [value, red, green, blue, extinction] = numbers;
    if let Some(channel) = [red, green, blue].iter().find(|channel| !(0.0..=1.0).contains(*channel)) {
        return Err(format!("a colour of {channel} is not from 0 to 1"));
    }
    if extinction < 0.0 {
        return Err(format!("an extinction of {extinction} is negative"));
    }
    if before.is_some_and(|before| value < before.value) {
        return Err(format!("the values must ascend, but {value} follows a greater one"));
    }
    Ok(TransferPoint { value, color: from_srgb([red, green, blue]).to_array(), extinction })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<TransferFunction, String> {
        read(Path::new("a.txt"), "a".into(), text).map_err(|error| error.to_string())
    }

    #[test]
    fn functions_are_read() {
        let text = "\n mobula  transfer 1 # of bones\r\nlengths relative\r\n# value colour extinction\r\n\
            -100 0 0.5 1 0\r\n0 0 0.5 1 0 # clear\n0\t1 1 1 1e1\nvalues absolute\n1.5e3 1 1 1 25";
        let function = parse(text).unwrap();
        assert_eq!((function.values, function.lengths), (Scale::Absolute, Scale::Relative));
        let found: Vec<_> = function.points.iter().map(|point| (point.value, point.extinction)).collect();
        assert_eq!(found, [(-100.0, 0.0), (0.0, 0.0), (0.0, 10.0), (1500.0, 25.0)]);
        assert_eq!(function.points[2].color, [1.0; 3]);
        let [red, green, blue] = function.points[0].color;
        assert!(red == 0.0 && (green - 0.214_041).abs() < 1e-6 && blue == 1.0, "{green}");
    }

    #[test]
    fn what_is_wrong_is_told_with_its_line() {
        let many: String = (0..65_537).map(|i| format!("{i} 0 0 0 0\n")).collect();
        for (body, expected) in [
            ("", "a.txt: a transfer function needs at least one point"),
            ("0 0 0 0", "a.txt:2: a point is 5 numbers, not 4 words"),
            ("0 0 0 0 0 0", "a.txt:2: a point is 5 numbers, not 6 words"),
            ("\n0 0 0 0 x", "a.txt:3: 'x' is not a number"),
            ("gamma 2", "a.txt:2: 'gamma' is not a number"),
            ("0 0 0 0 nan", "a.txt:2: 'nan' is not finite"),
            ("inf 0 0 0 0", "a.txt:2: 'inf' is not finite"),
            ("1e999 0 0 0 0", "a.txt:2: '1e999' is not finite"),
            ("0 0 255 0 0", "a.txt:2: a colour of 255 is not from 0 to 1"),
            ("0 0 0 0 -1", "a.txt:2: an extinction of -1 is negative"),
            ("1 0 0 0 0\n0 0 0 0 0", "a.txt:3: the values must ascend"),
            ("1 0 0 0 0\n1 0 0 0 0\n1 0 0 0 0", "a.txt:4: a third point of one value"),
            ("values logarithmic", "a.txt:2: values are 'logarithmic', which is not known"),
            ("lengths relative\nlengths absolute", "a.txt:3: lengths are said twice"),
            ("values", "a.txt:2: 'values' is not a number"),
            ("0 0 0 0 \0", "a.txt:2: binary data"),
            (&"0".repeat(5000), "a.txt:2: a line of more than 4 KiB"),
            (&many, "a.txt:65538: more than 65536 points"),
        ] {
            let error = parse(&format!("mobula transfer 1\n{body}")).unwrap_err();
            assert!(error.starts_with(expected), "{error}");
            assert!(error.len() < 300 && !error.contains('\n'), "{error}");
        }
        assert!(parse("mobula transfer 2\n").unwrap_err().starts_with("a.txt:1: version '2'"));
        assert!(parse("mobula scene 1\n").unwrap_err().starts_with("a.txt:1: this is no transfer function"));
    }
}
