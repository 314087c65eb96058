//! A reader that checks text line by line on its way to a parser that knows no line numbers.

use std::io::{self, BufRead, Read};

/// Longest line; a face of 200 000 vertices fits.
const LONGEST_LINE: u64 = 4 << 20;

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

/// Looks at each line before the parser sees it.
pub(super) trait LineCheck {
    /// Accepts line `number` (from 1), rewrites it into a form that the parser knows, empties it, or refuses it.
    fn check(&mut self, number: u64, line: &mut String) -> Result<(), Fault>;
}

/// Why reading stopped.
#[derive(Debug)]
pub(super) enum Stop {
    /// The check refused the line.
    Fault(Fault),
    /// The input could not be read further.
    Io(io::Error),
}

/// Passes on the lines of `input` that `check` accepts. After a failure, [`stop`](Self::stop) says why and
/// [`number`](Self::number) where: the parser only sees a read error.
pub(super) struct CheckedLines<R, C> {
    input: R,
    /// The check, with all that it has seen.
    pub(super) check: C,
    /// The line last read, counted from 1.
    pub(super) number: u64,
    /// Why reading stopped before the end.
    pub(super) stop: Option<Stop>,
    raw: Vec<u8>,
    line: String,
    sent: usize,
}

impl<R: BufRead, C: LineCheck> CheckedLines<R, C> {
    pub(super) fn new(input: R, check: C) -> Self {
        Self { input, check, number: 0, stop: None, raw: Vec::new(), line: String::new(), sent: 0 }
    }

    /// Reads, checks and stores the next line; an empty store afterwards means the end.
    fn next_line(&mut self) -> Result<(), Stop> {
        self.sent = 0;
        self.line.clear();
        while self.line.is_empty() {
            self.raw.clear();
            if !self.read_raw()? {
                return Ok(());
            }
            self.number += 1;
            let number = self.number;
            // A backslash at the end of a line joins it to the next.
            while self.raw.ends_with(b"\\") {
                self.raw.pop();
                self.raw.push(b' ');
                if !self.read_raw()? {
                    break;
                }
                self.number += 1;
            }
            if self.raw.contains(&0) {
                let fault = Fault::new("binary data in a text file", "check that it is what its name says");
                return Err(Stop::Fault(fault));
            }
            if number == 1 && self.raw.starts_with(b"\xef\xbb\xbf") {
                self.raw.drain(..3);
            }
            // Names and comments in old encodings must not stop a mesh from loading.
            self.line.push_str(&String::from_utf8_lossy(&self.raw));
            if let Err(fault) = self.check.check(number, &mut self.line) {
                self.number = number;
                return Err(Stop::Fault(fault));
            }
            if !self.line.is_empty() {
                self.line.push('\n');
            }
        }
        Ok(())
    }

    /// Appends the next line without its end; false at the end of the input.
    fn read_raw(&mut self) -> Result<bool, Stop> {
        let before = self.raw.len();
        let left = LONGEST_LINE.saturating_sub(before as u64);
        let count = self.input.by_ref().take(left).read_until(b'\n', &mut self.raw).map_err(Stop::Io)?;
        if self.raw.ends_with(b"\n") {
            self.raw.pop();
            if self.raw.ends_with(b"\r") {
                self.raw.pop();
            }
        } else if count as u64 == left {
            // The line was not counted yet.
            self.number += 1;
            let problem = format!("a line of more than {} MiB", LONGEST_LINE >> 20);
            return Err(Stop::Fault(Fault::new(problem, "check that it is a text file")));
        }
        Ok(count > 0)
    }
}

impl<R: BufRead, C: LineCheck> BufRead for CheckedLines<R, C> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        if self.stop.is_some() {
            return Err(io::Error::other("stopped"));
        }
        if self.sent == self.line.len()
            && let Err(stop) = self.next_line()
        {
            self.stop = Some(stop);
            return Err(io::Error::other("stopped"));
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

    /// Keeps every line but those that start with `-`, refuses those with `!`.
    struct Sample;

    impl LineCheck for Sample {
        fn check(&mut self, _: u64, line: &mut String) -> Result<(), Fault> {
            if line.starts_with('-') {
                line.clear();
            }
            if line.starts_with('!') { Err(Fault::new("refused", "")) } else { Ok(()) }
        }
    }

    fn read(text: &[u8]) -> (io::Result<String>, u64) {
        let mut lines = CheckedLines::new(text, Sample);
        let mut out = String::new();
        let result = lines.read_to_string(&mut out).map(|_| out);
        (result, lines.number)
    }

    #[test]
    fn lines_are_counted_joined_and_dropped() {
        let (out, number) = read(b"one\r\n-two\nthr\\\nee\n\nfive");
        assert_eq!(out.unwrap(), "one\nthr ee\nfive\n");
        assert_eq!(number, 6);
    }

    #[test]
    fn a_refused_line_is_numbered() {
        let (out, number) = read(b"one\n-\n!\nfour\n");
        assert!(out.is_err());
        assert_eq!(number, 3);
    }

    #[test]
    fn a_line_without_end_is_refused() {
        let (out, number) = read(&[b'x'; (LONGEST_LINE + 10) as usize]);
        assert!(out.is_err());
        assert_eq!(number, 1);
    }
}
