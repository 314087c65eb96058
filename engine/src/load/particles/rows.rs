//! Lines of text into columns: numbers, symbols of elements, and what is neither.

use std::io::BufRead;

use super::columns::{Columns, Storage};
use super::names;
use crate::load::lines::{Fault, Lines, Stop};
use crate::load::text::{counted, number, quoted};
use crate::particles::elements;

/// What to do with a word of each line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Word {
    /// It is a number of a column.
    Number(usize),
    /// It is a chemical element.
    Element(usize),
    /// It is text, which is left out.
    Text,
}

/// A table whose lines have one word for each column.
#[derive(Debug)]
pub(super) struct Rows {
    words: Vec<Word>,
    pub(super) columns: Columns,
    /// Columns of text, which are left out.
    pub(super) left_out: Vec<String>,
    /// May a comma stand for the point of a decimal fraction?
    pub(super) decimal_comma: bool,
}

impl Rows {
    /// A table with columns of these names. The first line says which are of text; without one all are of numbers.
    pub(super) fn new(all: &[&str], first: Option<&[&str]>) -> Result<Self, Fault> {
        let (mut words, mut wanted, mut left_out) = (Vec::new(), Vec::new(), Vec::new());
        for (at, name) in all.iter().enumerate() {
            let word = first.and_then(|first| first.get(at)).map_or("", |word| word.trim());
            let is_text = !word.is_empty() && number(word).is_none() && number(&word.replace(',', ".")).is_none();
            let name = if name.is_empty() { format!("column {}", at + 1) } else { (*name).to_owned() };
            let lower = name.to_ascii_lowercase();
            let symbol = ["species", "symbol", "atom", "type"].contains(&&*lower) && is_text;
            let element = lower == "element" || symbol && !all.iter().any(|name| name.eq_ignore_ascii_case("element"));
            // Text in a column of coordinates is a mistake, which is told of where it stands.
            if is_text && !element && !names::is_axis(&name) {
                words.push(Word::Text);
                left_out.push(name);
                continue;
            }
            let is_symbol = is_text && element;
            words.push(if is_symbol { Word::Element(wanted.len()) } else { Word::Number(wanted.len()) });
            let name = if is_symbol { "element".to_owned() } else { name };
            let storage = if is_symbol || names::is_kind(&name) { Storage::U8 } else { Storage::F64 };
            wanted.push((name, storage));
        }
        Ok(Self { words, columns: Columns::new(wanted)?, left_out, decimal_comma: false })
    }

    /// Adds a line.
    pub(super) fn add<'w>(&mut self, line: impl Iterator<Item = &'w str>) -> Result<(), Fault> {
        let mut count = 0;
        self.columns.make_room()?;
        for word in line {
            match self.words.get(count) {
                Some(&Word::Number(column)) => {
                    let number = match number(word) {
                        Some(number) => number,
                        // Nothing was measured.
                        None if word.is_empty() || ["NA", "N/A", "null"].contains(&word) => f64::NAN,
                        None => self.odd_number(word)?,
                    };
                    self.columns.push(column, number);
                }
                Some(&Word::Element(column)) => self.columns.push(column, elements::atomic_number(word).into()),
                Some(Word::Text) => {}
                // Behind a separator at the end of a line.
                None if word.is_empty() && count == self.words.len() => continue,
                None => {}
            }
            count += 1;
        }
        if count != self.words.len() {
            let problem = format!("a particle has {}, not {}", counted(count as u64, "value"), self.words.len());
            return Err(Fault::new(problem, "check how it was written"));
        }
        Ok(())
    }

    fn odd_number(&self, word: &str) -> Result<f64, Fault> {
        let with_point = || number(&word.replacen(',', ".", 1));
        let number = if self.decimal_comma { with_point() } else { None };
        number.ok_or_else(|| {
            Fault::new(format!("{} is not a number", quoted(word)), "write numbers such as 0.25 or 1e-3")
        })
    }

    /// Adds lines until there are as many particles as there should be, with white space between words.
    pub(super) fn fill<R: BufRead>(&mut self, lines: &mut Lines<R>, count: u64) -> Result<(), Stop> {
        for number in self.columns.len() as u64..count {
            let Some((_, line)) = lines.next(|_| false)? else { return Err(ended(number, count).into()) };
            self.add(line.split_whitespace())?;
        }
        Ok(())
    }

    /// What people should know of columns that are left out.
    pub(super) fn warning(&self) -> Option<String> {
        let all = quoted(&self.left_out.join(", "));
        match self.left_out.len() {
            0 => None,
            1 => Some(format!("column {all} is text, which is left out")),
            _ => Some(format!("columns {all} are text, which is left out")),
        }
    }
}

/// The fault where particles are missing.
pub(super) fn ended(number: u64, count: u64) -> Fault {
    let problem = format!("the file ends after {number} of {}", counted(count, "particle"));
    Fault::new(problem, "the file is truncated, or its count wrong")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::particles::Values;

    #[test]
    fn words_become_numbers_elements_or_nothing() {
        let first = ["Water", "O", "1", "2.5", "3", "7"];
        let mut rows = Rows::new(&["residue", "element", "x", "y", "z", "type"], Some(&first)).unwrap();
        rows.add(first.into_iter()).unwrap();
        rows.add(["Water", "HW", "nan", "1.5D+03", "0", "8"].into_iter()).unwrap();
        assert_eq!(rows.warning().unwrap(), "column 'residue' is text, which is left out");
        assert_eq!(rows.columns.position(1)[1], 1500.0);
        let (names, values) = rows.columns.into_others();
        assert_eq!(
            (names, values),
            (vec!["element".to_owned(), "type".to_owned()], vec![Values::U8(vec![8, 1]), Values::U8(vec![7, 8])])
        );
    }

    #[test]
    fn lines_are_checked() {
        let mut rows = Rows::new(&["x", "y", "z"], None).unwrap();
        let mut add = |line: &str| rows.add(line.split(';')).map_err(|fault| fault.problem);
        assert_eq!(add("1;2;3"), Ok(()));
        assert_eq!(add("1;2;3;"), Ok(()));
        assert_eq!(add("1;;3"), Ok(()));
        assert_eq!(add("1;2").unwrap_err(), "a particle has 2 values, not 3");
        assert_eq!(add("1;2;3;4").unwrap_err(), "a particle has 4 values, not 3");
        assert_eq!(add("1;two;3").unwrap_err(), "'two' is not a number");
        assert_eq!(add("1;2,5;3").unwrap_err(), "'2,5' is not a number");
        rows.decimal_comma = true;
        assert!(rows.add("1;2,5;3".split(';')).is_ok());
    }
}
