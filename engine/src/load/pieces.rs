//! Text in pieces that can be read apart: cut where a line ends that nothing joins to the next.

use std::io::{self, BufRead, Read};

use super::lines::LONGEST_LINE;

/// Bytes of a piece, or some more: few enough that all that are read at the same time take little memory.
const SIZE: usize = 1 << 17;

/// Some lines.
#[derive(Debug, Default)]
pub(super) struct Piece {
    pub(super) text: Vec<u8>,
    /// Why the next line could not be read.
    pub(super) failed: Option<io::Error>,
}

/// The pieces of a text, one after the other.
pub(super) struct Pieces<R> {
    input: R,
    size: usize,
    /// What was read behind the last cut.
    rest: Vec<u8>,
    /// Is all read?
    end: bool,
}

impl<R: BufRead> Pieces<R> {
    pub(super) fn new(input: R) -> Self {
        Self::of_size(SIZE, input)
    }

    /// Pieces of so many bytes, or some more.
    pub(super) fn of_size(size: usize, input: R) -> Self {
        Self { input, size, rest: Vec::new(), end: false }
    }
}

impl<R: BufRead> Iterator for Pieces<R> {
    type Item = Piece;

    fn next(&mut self) -> Option<Piece> {
        let mut text = Vec::with_capacity(2 * self.size);
        text.append(&mut self.rest);
        let mut failed = None;
        while !self.end {
            let from = text.len();
            match (&mut self.input).take(self.size as u64).read_to_end(&mut text) {
                Ok(count) => self.end = count < self.size,
                Err(error) => {
                    // Of the last line the end may be missing.
                    text.truncate(cut(&text, 0).unwrap_or(0));
                    (failed, self.end) = (Some(error), true);
                }
            }
            if self.end {
                break;
            }
            if let Some(cut) = cut(&text, from) {
                self.rest = text.split_off(cut);
                break;
            }
            // Longer than any line, however many are joined: whoever reads it finds out.
            if text.len() > 2 * LONGEST_LINE {
                break;
            }
        }
        (!text.is_empty() || failed.is_some()).then_some(Piece { text, failed })
    }
}

/// The last place behind `from` where a line begins that is surely not joined to the one before.
fn cut(text: &[u8], from: usize) -> Option<usize> {
    // Whether the last byte of all ends a line depends on the next, if it is a return.
    let ends =
        |&at: &usize| text[at] == b'\n' || text[at] == b'\r' && text.get(at + 1).is_some_and(|&next| next != b'\n');
    (from..text.len()).rev().filter(ends).find(|&at| !is_joined(&text[..at])).map(|at| at + 1)
}

/// Does the last line, without its end, end in a backslash, but for blanks?
fn is_joined(text: &[u8]) -> bool {
    let text = text.strip_suffix(b"\r").unwrap_or(text);
    let last = text.iter().rfind(|byte| !matches!(byte, b' ' | b'\t' | b'\x0c'));
    last == Some(&b'\\')
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pieces(text: &[u8]) -> Vec<Vec<u8>> {
        Pieces::new(text).map(|piece| piece.text).collect()
    }

    #[test]
    fn pieces_are_cut_where_lines_end() {
        assert!(pieces(b"").is_empty());
        assert_eq!(pieces(b"v 1 2 3"), [b"v 1 2 3"]);
        for (line, end) in
            [("v 1 2 3\n", "\n"), ("v 1 2 3\r\n", "\r\n"), ("v 1 2 3\r", "\r"), ("a \\ \r\n b\r\n", "b\r\n")]
        {
            let text = line.repeat(3 * SIZE / line.len() + 10);
            let pieces = pieces(text.as_bytes());
            assert!(pieces.len() > 2 && pieces.iter().all(|piece| piece.ends_with(end.as_bytes())), "{line:?}");
            assert!(pieces.iter().all(|piece| piece.starts_with(&line.as_bytes()[..1])), "{line:?}");
            assert!(pieces.concat() == text.as_bytes(), "{line:?}");
        }
        // Nowhere to cut.
        assert_eq!(pieces("\\\n".repeat(SIZE).as_bytes()).len(), 1);
    }

    #[test]
    fn lines_before_a_failure_are_there() {
        let mut pieces = Pieces::new(io::BufReader::new(b"one\ntwo\nthr".chain(Broken)));
        let piece = pieces.next().unwrap();
        assert!(piece.text == b"one\ntwo\n" && piece.failed.is_some() && pieces.next().is_none());
    }

    struct Broken;

    impl Read for Broken {
        fn read(&mut self, _: &mut [u8]) -> io::Result<usize> {
            Err(io::ErrorKind::BrokenPipe.into())
        }
    }
}
