//! The rows of the elements of a PLY file, one after the other: scalars, and one list of those that a row has.

use std::io::BufRead;
use std::path::Path;

use super::header::{Element, Encoding, Header, Property};
use crate::load::LoadError;
use crate::load::binary::{decode, fill};
use crate::load::input;
use crate::load::lines::{Fault, Lines, Stop};
use crate::load::text::{counted, number, quoted};

/// Reads rows, in the order in which the header names their elements.
pub(super) struct Rows<'a> {
    file: &'a Path,
    source: Source<'a>,
    gzip: bool,
    /// How many bytes are left, where that is known.
    left: Option<u64>,
    buffer: Vec<u8>,
}

enum Source<'a> {
    Text(Lines<&'a mut dyn BufRead>),
    Binary(&'a mut dyn BufRead, bool),
}

/// What a row has.
#[derive(Clone, Debug, Default)]
pub(super) struct Row {
    /// A number for each property; zero where that is a list.
    pub(super) scalars: Vec<f64>,
    /// The list that was asked for.
    pub(super) list: Vec<f64>,
}

/// Why there is no row.
enum Trouble {
    /// The file ends.
    End,
    Stop(Stop),
}

impl<S: Into<Stop>> From<S> for Trouble {
    fn from(stop: S) -> Self {
        Self::Stop(stop.into())
    }
}

impl<'a> Rows<'a> {
    /// The rows behind a header.
    pub(super) fn new(
        file: &'a Path,
        reader: &'a mut dyn BufRead,
        header: &Header,
        gzip: bool,
        left: Option<u64>,
    ) -> Result<Self, LoadError> {
        let text = header.encoding == Encoding::Text;
        let least = |element: &Element| {
            let bytes = |property: &Property| match property.list {
                _ if text => 2,
                Some(count) => count.bytes() as u64,
                None => property.kind.bytes() as u64,
            };
            element.count.saturating_mul(element.properties.iter().map(bytes).sum())
        };
        if let Some(left) = left {
            for element in &header.elements {
                // The last line may have no end.
                if least(element) > left.saturating_add(1) {
                    let what = rows_of(element);
                    let problem = format!("{what} need at least {} bytes, but there are only {left}", least(element));
                    let remedy = "the file is truncated, or its count wrong";
                    return Err(LoadError::new(file, problem, remedy).at(element.line));
                }
            }
        }
        let source = match header.encoding {
            Encoding::Binary { big_endian } => Source::Binary(reader, big_endian),
            Encoding::Text => {
                let mut lines = Lines::new(reader);
                lines.number = header.lines;
                Source::Text(lines)
            }
        };
        Ok(Self { file, source, gzip, left, buffer: Vec::new() })
    }

    /// The file's name.
    pub(super) fn file(&self) -> &'a Path {
        self.file
    }

    /// May so many rows be stored before they are read? There are as many bytes as the header says.
    pub(super) fn is_sure(&self) -> bool {
        self.left.is_some() && matches!(self.source, Source::Binary(..))
    }

    /// Reads row `number` of an element, with the list of a property.
    pub(super) fn next(
        &mut self,
        element: &Element,
        number: u64,
        list: Option<usize>,
        row: &mut Row,
    ) -> Result<(), LoadError> {
        row.scalars.clear();
        row.list.clear();
        let Self { source, buffer, .. } = self;
        let read = match source {
            Source::Text(lines) => text(lines, element, list, row),
            Source::Binary(reader, big_endian) => binary(*reader, *big_endian, element, list, row, buffer),
        };
        read.map_err(|trouble| match trouble {
            Trouble::End => {
                let problem = format!("the file ends after {number} of {}", rows_of(element));
                self.fault(Fault::new(problem, "the file is truncated, or its count wrong"), element, None)
            }
            Trouble::Stop(Stop::Fault(fault)) => self.fault(fault, element, Some(number)),
            Trouble::Stop(Stop::Io(error)) => {
                let (problem, remedy) = input::explain(&error, self.gzip);
                LoadError::new(self.file, problem, remedy)
            }
        })
    }

    /// Passes over all rows of an element.
    pub(super) fn skip(&mut self, element: &Element) -> Result<(), LoadError> {
        if element.properties.is_empty() {
            return Ok(());
        }
        let mut row = Row::default();
        (0..element.count).try_for_each(|number| self.next(element, number, None, &mut row))
    }

    /// The error of a row: at its line, or by its number where there are no lines.
    pub(super) fn fault(&self, fault: Fault, element: &Element, row: Option<u64>) -> LoadError {
        match (&self.source, row) {
            (Source::Text(lines), _) => LoadError::new(self.file, fault.problem, fault.remedy).at(lines.number),
            (Source::Binary(..), Some(row)) => {
                let problem = format!("{} {row}: {}", quoted(&element.name), fault.problem);
                LoadError::new(self.file, problem, fault.remedy)
            }
            (Source::Binary(..), None) => LoadError::new(self.file, fault.problem, fault.remedy),
        }
    }
}

/// So many rows of an element.
fn rows_of(element: &Element) -> String {
    format!("{} of {}", counted(element.count, "row"), quoted(&element.name))
}

/// Reads a row as a line of text.
fn text<R: BufRead>(
    lines: &mut Lines<R>,
    element: &Element,
    list: Option<usize>,
    row: &mut Row,
) -> Result<(), Trouble> {
    let line = loop {
        let (_, line) = lines.next(|_| false)?.ok_or(Trouble::End)?;
        if !line.trim().is_empty() {
            break line;
        }
    };
    let mut words = line.split_ascii_whitespace();
    let mut next = || {
        let missing = || Fault::new("numbers are missing", "check how it was written");
        let word = words.next().ok_or_else(missing)?;
        let not = || Fault::new(format!("{} is not a number", quoted(word)), "write numbers such as 0.25 or 1e-3");
        number(word).ok_or_else(not)
    };
    for (at, property) in element.properties.iter().enumerate() {
        let first = next()?;
        if property.list.is_none() {
            row.scalars.push(first);
            continue;
        }
        row.scalars.push(0.0);
        for _ in 0..length(first)? {
            let value = next()?;
            if list == Some(at) {
                row.list.push(value);
            }
        }
    }
    if let Some(word) = words.next() {
        let problem = format!("{} is behind the last number of the row", quoted(word));
        return Err(Fault::new(problem, "check how it was written").into());
    }
    Ok(())
}

/// The length of a list.
fn length(number: f64) -> Result<u64, Fault> {
    if number >= 0.0 && number.fract() == 0.0 && number <= f64::from(u32::MAX) {
        return Ok(number as u64);
    }
    Err(Fault::new(format!("{number} is no length of a list"), "check how it was written"))
}

/// Reads a row of bytes.
fn binary(
    reader: &mut dyn BufRead,
    big_endian: bool,
    element: &Element,
    list: Option<usize>,
    row: &mut Row,
    buffer: &mut Vec<u8>,
) -> Result<(), Trouble> {
    // All scalars up to the next list at once.
    let mut rest = &element.properties[..];
    while !rest.is_empty() {
        let scalars = rest.iter().take_while(|property| property.list.is_none()).count();
        let (now, then) = rest.split_at(scalars);
        take(reader, buffer, now.iter().map(|property| property.kind.bytes()).sum())?;
        let mut at = 0;
        for property in now {
            row.scalars.push(decode(property.kind, big_endian, &buffer[at..]));
            at += property.kind.bytes();
        }
        rest = then;
        if let Some((property, then)) = rest.split_first()
            && let Some(count) = property.list
        {
            take(reader, buffer, count.bytes())?;
            let mut left = length(decode(count, big_endian, buffer))?;
            let wanted = list == Some(row.scalars.len());
            row.scalars.push(0.0);
            let each = property.kind.bytes();
            while left > 0 {
                let some = left.min(4096);
                take(reader, buffer, some as usize * each)?;
                if wanted {
                    row.list.extend(buffer.chunks_exact(each).map(|bytes| decode(property.kind, big_endian, bytes)));
                }
                left -= some;
            }
            rest = then;
        }
    }
    Ok(())
}

/// So many bytes.
fn take(reader: &mut dyn BufRead, buffer: &mut Vec<u8>, count: usize) -> Result<(), Trouble> {
    buffer.resize(count, 0);
    match fill(reader, buffer) {
        Ok(filled) if filled < count => Err(Trouble::End),
        Ok(_) => Ok(()),
        Err(error) => Err(Trouble::Stop(Stop::Io(error))),
    }
}
