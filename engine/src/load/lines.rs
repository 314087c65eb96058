//! Text line by line, with line numbers; and a reader that checks lines on their way to a parser that knows no line numbers.

use std::io::{self, BufRead, Read};
use std::mem;

use memchr::{memchr2, memchr3};

/// Longest line; a face of ten million vertices fits.
pub(super) const LONGEST_LINE: usize = 64 << 20;

/// What is wrong with a line, and what to do about it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Fault {
    pub(super) problem: String,
    pub(super) remedy: &'static str,
}

impl Fault {
    pub(super) fn new(problem: impl Into<String>, remedy: &'static str) -> Self {
        Self { problem: problem.into(), remedy }
    }
}

/// Why reading stopped.
#[derive(Debug)]
pub(super) enum Stop {
    /// A line is not what it must be.
    Fault(Fault),
    /// The input could not be read further.
    Io(io::Error),
}

impl From<Fault> for Stop {
    fn from(fault: Fault) -> Self {
        Self::Fault(fault)
    }
}

/// The lines of a text file.
pub(super) struct Lines<R> {
    input: R,
    /// The line last read, or of several that were joined the last, counted from 1.
    pub(super) number: u64,
    longest: usize,
    /// May zeros follow behind the text?
    padded: bool,
    raw: Vec<u8>,
    line: String,
}

impl<R: BufRead> Lines<R> {
    pub(super) fn new(input: R) -> Self {
        Self { padded: true, ..Self::no_longer_than(LONGEST_LINE, input) }
    }

    /// The rest of a text, of which so many lines were read before.
    pub(super) fn after(number: u64, input: R) -> Self {
        Self { number, ..Self::new(input) }
    }

    /// Lines of more than so many bytes are faults.
    pub(super) fn no_longer_than(longest: usize, input: R) -> Self {
        Self { input, number: 0, longest, padded: false, raw: Vec::new(), line: String::new() }
    }

    /// The next line, without its end, and its number. A backslash at the end joins a line to the next if `joins` says so of it.
    pub(super) fn next(&mut self, joins: impl Fn(&[u8]) -> bool) -> Result<Option<(u64, &mut String)>, Stop> {
        self.raw.clear();
        if !self.read_raw()? {
            return Ok(None);
        }
        let number = self.number;
        // A line that joins looks at what is joined only once.
        let mut from = 0;
        while let Some(end) = backslash(&self.raw) {
            if if from == 0 { !joins(&self.raw) } else { self.raw[from..].contains(&b'#') } {
                break;
            }
            self.raw.truncate(end);
            self.raw.push(b' ');
            from = self.raw.len();
            if !self.read_raw()? {
                break;
            }
        }
        if number == 1 && self.raw.starts_with(b"\xef\xbb\xbf") {
            self.raw.drain(..3);
        }
        // The two change places: no line is copied.
        match String::from_utf8(mem::take(&mut self.raw)) {
            Ok(line) => self.raw = mem::replace(&mut self.line, line).into_bytes(),
            // Names and comments in old encodings must not stop a mesh from loading.
            Err(error) => {
                self.raw = error.into_bytes();
                self.line.clear();
                self.line.push_str(&String::from_utf8_lossy(&self.raw));
            }
        }
        Ok(Some((number, &mut self.line)))
    }

    /// Appends the next line without its end and counts it; false at the end of the input. Lines end in LF, CR LF, or CR.
    fn read_raw(&mut self) -> Result<bool, Stop> {
        let mut some = false;
        loop {
            let buffer = match self.input.fill_buf() {
                Ok(buffer) => buffer,
                Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
                Err(error) => {
                    self.number += 1;
                    return Err(Stop::Io(error));
                }
            };
            if buffer.is_empty() {
                self.number += u64::from(some);
                return Ok(some);
            }
            some = true;
            // The first that is not part of the line, or the zero that is no text.
            let end = memchr3(b'\n', b'\r', 0, buffer);
            let part = &buffer[..end.unwrap_or(buffer.len())];
            if end.is_some_and(|end| buffer[end] == 0) {
                let text = part.len();
                self.raw.extend_from_slice(part);
                self.input.consume(text);
                self.number += 1;
                // Padding behind the text, as of blocks of a tape, says nothing.
                if self.padded && only_zeros(&mut self.input) {
                    return Ok(true);
                }
                return Err(Fault::new("binary data in a text file", "check that it is what its name says").into());
            }
            self.raw.extend_from_slice(part);
            let length = part.len();
            let returned = end.is_some_and(|end| buffer[end] == b'\r');
            self.input.consume(length + usize::from(end.is_some()));
            if returned && self.input.fill_buf().is_ok_and(|buffer| buffer.starts_with(b"\n")) {
                self.input.consume(1);
            }
            if self.raw.len() > self.longest {
                self.number += 1;
                let problem = format!("a line of more than {} KiB", self.longest >> 10);
                return Err(Fault::new(problem, "check that it is a text file").into());
            }
            if end.is_some() {
                self.number += 1;
                return Ok(true);
            }
        }
    }
}

impl Lines<&[u8]> {
    /// Hands lines with their numbers to `taken`, without a copy, until it refuses one, which is the next then. What it takes must hold
    /// neither zeros nor backslashes.
    pub(super) fn skip(&mut self, mut taken: impl FnMut(u64, &[u8]) -> bool) {
        while !self.input.is_empty() {
            let end = memchr2(b'\n', b'\r', self.input).unwrap_or(self.input.len());
            let (line, rest) = self.input.split_at(end);
            if line.len() > self.longest || !taken(self.number + 1, line) {
                return;
            }
            let end = [&b"\r\n"[..], b"\n", b"\r"].into_iter().find_map(|end| rest.strip_prefix(end));
            self.input = end.unwrap_or(rest);
            self.number += 1;
        }
    }
}

/// Where a backslash is that ends a line, but for blanks.
fn backslash(line: &[u8]) -> Option<usize> {
    let end = line.trim_ascii_end().len();
    line[..end].ends_with(b"\\").then(|| end - 1)
}

/// Reads zeros; is there nothing else?
fn only_zeros(input: &mut impl BufRead) -> bool {
    loop {
        match input.fill_buf() {
            Ok([]) => return true,
            Ok(buffer) if buffer.iter().all(|&byte| byte == 0) => {
                let count = buffer.len();
                input.consume(count);
            }
            _ => return false,
        }
    }
}

/// Looks at each line before a parser sees it.
pub(super) trait LineCheck {
    /// Rewrites line `number` (from 1) into a form that the parser knows, or empties it.
    ///
    /// # Errors
    /// If nothing further is to be read.
    fn check(&mut self, number: u64, line: &mut String) -> Result<(), Fault>;

    /// May a backslash at its end join this line to the next?
    fn joins(line: &[u8]) -> bool;
}

/// Passes on what `check` makes of the lines of `input`. After a failure, [`stop`](Self::stop) says why: the parser only sees the end.
pub(super) struct CheckedLines<R, C> {
    /// Where lines come from.
    pub(super) lines: Lines<R>,
    /// The check, with all that it has seen.
    pub(super) check: C,
    /// Why reading stopped before the end.
    pub(super) stop: Option<Stop>,
    line: String,
    sent: usize,
}

impl<R: BufRead, C: LineCheck> CheckedLines<R, C> {
    pub(super) fn new(input: R, check: C) -> Self {
        Self { lines: Lines::new(input), check, stop: None, line: String::new(), sent: 0 }
    }

    /// Reads, checks and stores the next line; an empty store afterwards means the end.
    fn next_line(&mut self) -> Result<(), Stop> {
        self.sent = 0;
        self.line.clear();
        while self.line.is_empty() {
            let Some((number, line)) = self.lines.next(C::joins)? else { return Ok(()) };
            self.check.check(number, line)?;
            self.line.push_str(line);
            if !self.line.is_empty() {
                self.line.push('\n');
            }
        }
        Ok(())
    }
}

impl<R: BufRead, C: LineCheck> BufRead for CheckedLines<R, C> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        if self.sent == self.line.len()
            && self.stop.is_none()
            && let Err(stop) = self.next_line()
        {
            self.stop = Some(stop);
            self.line.clear();
        }
        Ok(&self.line.as_bytes()[self.sent..])
    }

    fn consume(&mut self, amount: usize) {
        self.sent += amount;
    }
}

impl<R: BufRead, C: LineCheck> Read for CheckedLines<R, C> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.fill_buf()?.read(buffer)?;
        self.consume(count);
        Ok(count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(text: &[u8]) -> Result<Vec<(u64, String)>, (u64, Stop)> {
        let mut lines = Lines::new(text);
        let mut all = Vec::new();
        loop {
            match lines.next(|line| !line.contains(&b'#')) {
                Ok(Some((number, line))) => all.push((number, line.clone())),
                Ok(None) => return Ok(all),
                Err(stop) => return Err((lines.number, stop)),
            }
        }
    }

    #[test]
    fn lines_are_counted_and_joined() {
        let lines = all(b"one\r\ntwo\rthr\\ \nee\n\n# not \\\nfive\\").unwrap();
        let expected = [(1, "one"), (2, "two"), (3, "thr ee"), (5, ""), (6, "# not \\"), (7, "five ")];
        assert_eq!(lines, expected.map(|(number, line)| (number, line.to_owned())));
    }

    #[test]
    fn what_is_no_text_is_refused_where_it_stands() {
        assert!(matches!(all(b"one\n\ntw\0\n"), Err((3, Stop::Fault(_)))));
        assert_eq!(all(b"one\ntw\0\0").unwrap(), [(1, "one".to_owned()), (2, "tw".to_owned())], "padding");
        assert!(matches!(all(&vec![b'x'; LONGEST_LINE + 100_000]), Err((1, Stop::Fault(_)))));
    }

    #[test]
    fn checked_lines_are_passed_on() {
        /// Drops lines that start with `-`.
        struct Sample;
        impl LineCheck for Sample {
            fn check(&mut self, number: u64, line: &mut String) -> Result<(), Fault> {
                *line = if line.starts_with('-') { String::new() } else { format!("{number}{line}") };
                Ok(())
            }

            fn joins(_: &[u8]) -> bool {
                false
            }
        }
        let mut out = String::new();
        CheckedLines::new(&b"one\n-two\nthree"[..], Sample).read_to_string(&mut out).unwrap();
        assert_eq!(out, "1one\n3three\n");
    }
}
