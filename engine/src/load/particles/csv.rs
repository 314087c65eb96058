//! CSV, and tables with other separators: semicolons, tabs or blanks. The first line names the columns; without such a line the first
//! three are the coordinates.

use std::path::Path;

use super::frames::{self, Frame, Frames, TextLines};
use super::rows::Rows;
use super::{names, periodic};
use crate::load::input::Input;
use crate::load::lines::{Fault, Stop};
use crate::load::loaded::Loaded;
use crate::load::text::number;
use crate::load::{LoadError, Options};

/// What parts words: the separator of a table; `None`: blanks.
type Separator = Option<char>;

/// Loads a table.
pub(in crate::load) fn load(file: &Path, input: Input, options: &Options) -> Result<Loaded, LoadError> {
    let names = ["table of particles", "table of particles, gzip"];
    frames::load(file, input, options, names, read)
}

/// Does the start of a file look like a table with names of coordinates?
pub(in crate::load) fn looks_like(start: &[u8]) -> bool {
    let text = String::from_utf8_lossy(start);
    let mut lines = text.trim_start_matches('\u{feff}').lines().filter(|line| !line.trim().is_empty());
    let first = lines.by_ref().take(32).find(|line| is_header(line) || !line.starts_with('#'));
    first.is_some_and(is_header)
}

fn is_header(line: &str) -> bool {
    let line = line.trim_start_matches('#').trim();
    names::axes(&split(line, separator(line)).collect::<Vec<_>>()).is_some()
}

fn separator(line: &str) -> Separator {
    ['\t', ';', ','].into_iter().find(|&separator| line.contains(separator))
}

fn read(lines: &mut TextLines<'_>, frames: &mut Frames<'_>) -> Result<(), Stop> {
    let (mut head, mut cell, mut rows) = (None, None, None::<Rows>);
    while let Some((_, line)) = lines.next(|_| false)? {
        let line = line.trim_matches([' ', '\r']);
        if line.trim().is_empty() {
            continue;
        }
        if let Some(comment) = line.strip_prefix('#') {
            cell = cell.or_else(|| periodic::of_comment(comment));
            if head.is_none() && is_header(comment) {
                let comment = comment.trim();
                head = Some(named(comment, separator(comment))?);
            }
            continue;
        }
        let Some((separator, all)) = &head else {
            let separator = separator(line);
            let words: Vec<&str> = split(line, separator).collect();
            if words.len() >= 3 && words.iter().all(|word| number(word).is_some()) {
                let all: Vec<String> = (0..words.len()).map(unnamed).collect();
                let all: Vec<&str> = all.iter().map(|name| &**name).collect();
                let mut first = Rows::new(&all, Some(&words))?;
                first.add(words.into_iter())?;
                let all = all.into_iter().map(str::to_owned).collect();
                (head, rows) = (Some((separator, all)), Some(first));
                frames.warn(": no line names its columns; the first three are taken for x, y and z");
            } else {
                head = Some(named(line, separator)?);
            }
            continue;
        };
        // A comment may name columns with blanks between names, whatever is between numbers.
        let separator = separator.or_else(|| separator_of_numbers(line));
        let rows = match &mut rows {
            Some(rows) => rows,
            None => {
                let words: Vec<&str> = split(line, separator).collect();
                let all: Vec<&str> = all.iter().map(|name| &**name).collect();
                let mut first = Rows::new(&all, Some(&words))?;
                first.decimal_comma = separator.is_some_and(|separator| separator != ',');
                rows.insert(first)
            }
        };
        rows.add(split(line, separator))?;
    }
    let rows = match (rows, head) {
        (Some(rows), _) => rows,
        (None, Some((_, all))) => Rows::new(&all.iter().map(|name| &**name).collect::<Vec<_>>(), None)?,
        (None, None) => return Err(Fault::new("the file is empty", "name a file with particles in it").into()),
    };
    if let Some(warning) = rows.warning() {
        frames.warn(&format!(": {warning}"));
    }
    frames.add(Frame { columns: rows.columns, cell, radii: Vec::new() })?;
    Ok(())
}

/// Names of columns, checked where they stand, and what parts them.
fn named(line: &str, separator: Separator) -> Result<(Separator, Vec<String>), Fault> {
    let mut names: Vec<&str> = split(line, separator).collect();
    if names.len() > 3 && names.last().is_some_and(|name| name.is_empty()) {
        // Behind a separator at the end of the line.
        names.pop();
    }
    Rows::new(&names, None)?;
    Ok((separator, names.into_iter().map(str::to_owned).collect()))
}

fn separator_of_numbers(line: &str) -> Separator {
    [';', ','].into_iter().find(|&separator| line.contains(separator))
}

/// The name of a column that has none.
fn unnamed(at: usize) -> String {
    ["x", "y", "z"].get(at).map_or_else(|| format!("column {}", at + 1), |name| (*name).to_owned())
}

/// The words of a line, without quotes around them.
fn split(line: &str, separator: Separator) -> impl Iterator<Item = &str> {
    let mut rest = Some(line);
    std::iter::from_fn(move || {
        let Some(separator) = separator else {
            let line = rest?.trim_start();
            if line.is_empty() {
                return None;
            }
            let (word, after) = line.split_at(line.find(char::is_whitespace).unwrap_or(line.len()));
            rest = Some(after);
            return Some(word.trim_matches('"'));
        };
        let line = rest?;
        let quoted = line.trim_start().strip_prefix('"').and_then(|inner| {
            let (word, after) = inner.split_once('"')?;
            let after = after.trim_start_matches(' ');
            (after.is_empty() || after.starts_with(separator)).then_some((word, after))
        });
        let (word, after) = match quoted {
            Some((word, after)) => (word, after.strip_prefix(separator)),
            None => line.split_once(separator).map_or((line, None), |(word, after)| (word, Some(after))),
        };
        rest = after;
        Some(word.trim())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_split() {
        let words = |line: &'static str, separator| split(line, separator).collect::<Vec<_>>();
        assert_eq!(words("a, b ,,c,", Some(',')), ["a", "b", "", "c", ""]);
        assert_eq!(words("\"a,b\" ,\"c\"d,\"", Some(',')), ["a,b", "\"c\"d", "\""]);
        assert_eq!(words("  a \t \"b\"  ", None), ["a", "b"]);
        assert_eq!(words("", Some(';')), [""]);
    }

    #[test]
    fn tables_are_told_from_other_text() {
        for table in [
            "x,y,z\n",
            "id;X (mm);Y;Z\n1;2;3;4",
            "# made by a program\n# x y z r\n1 2 3 4",
            "\u{feff}\"Points:0\",\"Points:1\",\"Points:2\"",
        ] {
            assert!(looks_like(table.as_bytes()), "{table}");
        }
        for other in ["", "1,2,3\n", "a,b,c\n", "# x y\n1 2\n", "v 1 2 3"] {
            assert!(!looks_like(other.as_bytes()), "{other}");
        }
    }
}
