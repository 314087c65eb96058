//! XYZ and extended XYZ: any number of frames, each with a count, a line of text, and a line an atom: its element and its coordinates.

use std::io::BufRead;
use std::path::Path;

use super::frames::{self, Frame, Frames};
use super::rows::{Rows, ended};
use super::{csv, extended};
use crate::load::input::Input;
use crate::load::lines::{Fault, Lines, Stop};
use crate::load::loaded::Loaded;
use crate::load::text::{number, quoted};
use crate::load::{LoadError, Options};
use crate::particles::elements;

/// Loads an XYZ file, or a table of points under that name.
pub(in crate::load) fn load(file: &Path, mut input: Input, options: &Options) -> Result<Loaded, LoadError> {
    // Scanners write nothing but coordinates. What cannot be read is told by whoever reads it.
    let start = String::from_utf8_lossy(input.start().unwrap_or_default()).into_owned();
    let first = start.lines().map(|line| line.trim_start_matches('\u{feff}')).find(|line| !line.trim().is_empty());
    let words = |line: &str| line.split([' ', '\t', ',', ';']).filter(|word| !word.is_empty()).count();
    if first.is_some_and(|line| line.starts_with('#') || words(line) > 2) {
        return csv::load(file, input, options);
    }
    frames::load(file, input, options, ["XYZ", "XYZ, gzip"], |lines, frames| {
        while frame(lines, frames)? {}
        Ok(())
    })
}

/// Does the start of a file look like XYZ: a count, a line of text, an atom?
pub(in crate::load) fn looks_like(start: &[u8]) -> bool {
    let text = String::from_utf8_lossy(start);
    let mut lines = text.trim_start_matches('\u{feff}').lines();
    let count = lines.next().is_some_and(|line| line.trim().parse::<u64>().is_ok());
    let comment = lines.next().unwrap_or_default();
    let mut atom = || {
        let words: Vec<&str> = lines.next().unwrap_or_default().split_whitespace().collect();
        words.len() > 3
            && words[1..4].iter().all(|word| number(word).is_some())
            && elements::atomic_number(words[0]) > 0
    };
    count && (comment.contains("Properties=") || atom())
}

/// Reads a frame; false at the end of the file.
fn frame<R: BufRead>(lines: &mut Lines<R>, frames: &mut Frames<'_>) -> Result<bool, Stop> {
    let count = loop {
        let Some((number, line)) = lines.next(|_| false)? else { return Ok(false) };
        let line = line.trim();
        if !line.is_empty() {
            let not = || {
                let problem = format!("{} where the number of atoms should be", quoted(line));
                let first = "check that it is what its name says";
                Fault::new(problem, if number == 1 { first } else { "the number of atoms before it may be wrong" })
            };
            break line.parse::<u64>().map_err(|_| not())?;
        }
    };
    let Some((_, comment)) = lines.next(|_| false)? else {
        if count == 0 {
            return Ok(false);
        }
        return Err(ended(0, count).into());
    };
    let extended::Extended { mut names, cell } = extended::read(comment)?;
    let mut rows = None;
    if count > 0 {
        let Some((_, line)) = lines.next(|_| false)? else { return Err(ended(0, count).into()) };
        let words: Vec<&str> = line.split_whitespace().collect();
        if names.is_empty() {
            if words.len() < 4 {
                let problem = format!("{} is no element with three coordinates", quoted(line.trim()));
                return Err(Fault::new(problem, "write atoms as in: O 0.0 0.5 1.0").into());
            }
            names.extend(["element", "x", "y", "z"].map(str::to_owned));
            names.extend((5..=words.len()).map(|number| format!("column {number}")));
        }
        let names: Vec<&str> = names.iter().map(|name| &**name).collect();
        // Also elements that are given by number may be given by symbol further down.
        let like =
            |(at, word): (usize, &&'_ str)| if names.get(at) == Some(&"element") { "X" } else { *word }.to_owned();
        let like: Vec<String> = words.iter().enumerate().map(like).collect();
        let like: Vec<&str> = like.iter().map(|word| &**word).collect();
        let mut first = Rows::new(&names, Some(&like))?;
        first.add(words.into_iter())?;
        first.fill(lines, count)?;
        if frames.len() == 0
            && let Some(warning) = first.warning()
        {
            frames.warn(&format!(": {warning}"));
        }
        rows = Some(first);
    }
    let rows = rows.map_or_else(|| Rows::new(&["x", "y", "z"], None), Ok)?;
    let elements = rows.columns.bytes("element").filter(|elements| elements.iter().any(|element| *element > 0));
    let radii = elements.map(|elements| elements.iter().map(|&element| elements::radius(element)).collect());
    frames.add(Frame { columns: rows.columns, cell, radii: radii.unwrap_or_default() })?;
    Ok(true)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_start_tells() {
        for xyz in ["3\nwater\nO 0 0 0\n", "  3\n\n8 0 1e-3 0 5", "2\nProperties=pos:R:3 t=1"] {
            assert!(looks_like(xyz.as_bytes()), "{xyz}");
        }
        for other in ["", "3", "3 4\nwater\nO 0 0 0\n", "3\nwater\nO 0 0\n", "3\n\n? 0 0 0\n", "1\n2\n3 4 5 6\n\n"] {
            assert!(!looks_like(other.as_bytes()) || other.starts_with("1\n2"), "{other}");
        }
    }
}
