//! Opening files: plain or gzip by content, UTF-8 or UTF-16, and never more data than what was read justifies.

use std::cell::Cell;
use std::fs::{self, File};
use std::io::{self, BufRead, BufReader, Read};
use std::mem;
use std::path::Path;
use std::rc::Rc;

use flate2::bufread::GzDecoder;

use super::LoadError;
use crate::progress::Progress;

/// A gzip file may unpack to this much whatever its size...
const UNPACKED_BASE: u64 = 1 << 20;
/// ... and to this many times its length, or what was read of it, beyond that. Meshes as text shrink 3 to 10 times.
const UNPACKED_RATIO: u64 = 32;
/// How much of a file is looked at before it is read.
pub(super) const START: usize = 512;

/// An opened file, unpacked as it is read.
pub(super) struct Input {
    /// The unpacked bytes, as UTF-8 if they are text.
    pub(super) reader: Box<dyn BufRead>,
    /// Was it gzip?
    pub(super) gzip: bool,
    /// How many bytes there are where that is known: in regular files that are not packed.
    pub(super) length: Option<u64>,
    /// It may unpack to this much whatever its size.
    allowed: Rc<Cell<u64>>,
    /// Bytes behind the gzip data, once they were met.
    trailing: Rc<Cell<bool>>,
}

impl Input {
    /// The first bytes, which are not taken. A pipe is waited for.
    pub(super) fn start(&mut self) -> io::Result<&[u8]> {
        let start = self.reader.fill_buf()?;
        Ok(&start[..start.len().min(START)])
    }

    /// So many bytes are expected from here on: no limit is put on what they were packed to.
    pub(super) fn allow(&self, bytes: u64) {
        self.allowed.set(self.allowed.get().max(bytes.saturating_add(UNPACKED_BASE)));
    }

    /// What people should know, once all is read.
    pub(super) fn warning(&self, file: &Path) -> Option<String> {
        let warning = || format!("{}: what follows the gzip data is left out", file.display());
        self.trailing.get().then(warning)
    }
}

/// Opens `file`, looking at its first bytes to see whether it is gzip or UTF-16. `-` is the standard input. What is read of a file
/// counts as progress.
pub(super) fn open(file: &Path, progress: &Progress) -> Result<Input, LoadError> {
    let mut input = open_bytes(file, progress, Packed::AsItStarts)?;
    let start =
        input.reader.fill_buf().map_err(|e| if input.gzip { damaged(file, &e) } else { unreadable(file, &e) })?;
    if let Some(big_endian) = utf16(start) {
        input.reader = Box::new(BufReader::with_capacity(
            1 << 16,
            Utf16 { input: input.reader, big_endian, high: None, out: Vec::new(), sent: 0 },
        ));
        input.length = None;
    }
    Ok(input)
}

/// Whether a file is unpacked as it is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Packed {
    /// If it starts like gzip.
    AsItStarts,
    /// Never.
    No,
}

/// As [`open`], of bytes that are no text.
pub(super) fn open_bytes(file: &Path, progress: &Progress, packed: Packed) -> Result<Input, LoadError> {
    let mut length = None;
    let handle: Box<dyn Read> = if file == Path::new("-") {
        Box::new(io::stdin())
    } else {
        let handle = File::open(file).map_err(|e| unreadable(file, &e))?;
        let metadata = handle.metadata().map_err(|e| unreadable(file, &e))?;
        if metadata.is_dir() {
            return Err(LoadError::new(file, "is a directory", "name a file in it"));
        }
        progress.expect(metadata.len());
        length = metadata.is_file().then_some(metadata.len());
        Box::new(Watched { input: handle, progress: progress.clone() })
    };
    let (allowed, trailing) = (Rc::new(Cell::new(UNPACKED_BASE)), Rc::new(Cell::new(false)));
    let mut reader = ahead(handle);
    let start = reader.fill_buf().map_err(|e| unreadable(file, &e))?;
    if packed == Packed::No || !start.starts_with(&GZIP) {
        return Ok(Input { reader: Box::new(reader), gzip: false, length, allowed, trailing });
    }
    let packed = Rc::new(Cell::new(0));
    let counted = BufReader::with_capacity(1 << 16, Counted { input: reader, count: packed.clone() });
    let members = Members { state: Member::Unpacking(GzDecoder::new(counted)), trailing: trailing.clone() };
    let capped = Capped { input: members, packed, length: length.unwrap_or(0), allowed: allowed.clone(), unpacked: 0 };
    // What is damaged from the start is told by whoever reads it.
    Ok(Input { reader: Box::new(ahead(Box::new(capped))), gzip: true, length: None, allowed, trailing })
}

/// What gzip data unpacks to, without a limit: for those who know how much they want.
pub(super) fn gunzip(packed: Box<dyn BufRead>) -> Box<dyn Read> {
    Box::new(Members { state: Member::Unpacking(GzDecoder::new(packed)), trailing: Rc::default() })
}

/// A reader whose buffer holds the whole start of a file, also of one that comes in small pieces, as from a pipe.
fn ahead(input: Box<dyn Read>) -> BufReader<Box<dyn Read>> {
    let mut start = Vec::new();
    let mut input = input;
    let failed = (&mut input).take(START as u64).read_to_end(&mut start).err();
    let start: Box<dyn Read> = Box::new(io::Cursor::new(start));
    let rest: Box<dyn Read> = match failed {
        // What came before is read first, then the error.
        Some(error) => Box::new(Failing(Some(error))),
        None => input,
    };
    BufReader::with_capacity(1 << 16, Box::new(start.chain(rest)))
}

/// Fails once, then ends.
struct Failing(Option<io::Error>);

impl Read for Failing {
    fn read(&mut self, _: &mut [u8]) -> io::Result<usize> {
        self.0.take().map_or(Ok(0), Err)
    }
}

/// Is it a regular file? Files that are named inside other files must be: they could name a pipe or a device.
pub(super) fn is_regular(file: &Path) -> bool {
    fs::metadata(file).is_ok_and(|m| m.is_file())
}

pub(super) fn unreadable(file: &Path, error: &io::Error) -> LoadError {
    match error.kind() {
        io::ErrorKind::NotFound => LoadError::new(file, "no such file", "check the path"),
        io::ErrorKind::PermissionDenied => LoadError::new(file, "permission denied", "make the file readable"),
        _ => LoadError::new(file, format!("cannot be read: {error}"), ""),
    }
}

fn damaged(file: &Path, error: &io::Error) -> LoadError {
    let (problem, remedy) = explain(error, true);
    LoadError::new(file, problem, remedy).at(1)
}

/// What an error while reading means, in words: problem and remedy.
pub(super) fn explain(error: &io::Error, gzip: bool) -> (String, &'static str) {
    match error.kind() {
        io::ErrorKind::UnexpectedEof if gzip => {
            ("the gzip data ends too early".into(), "the file is truncated: fetch or pack it again")
        }
        io::ErrorKind::InvalidInput | io::ErrorKind::InvalidData if gzip => {
            (format!("the gzip data is damaged ({error})"), "fetch or pack the file again")
        }
        io::ErrorKind::FileTooLarge => (error.to_string(), "unpack it with gunzip first if it is really that large"),
        _ => (format!("cannot be read: {error}"), "check the disk"),
    }
}

/// Reads what is left, which says whether packed data is whole; is there anything but white space?
pub(super) fn drain(reader: &mut dyn BufRead) -> io::Result<bool> {
    let mut something = false;
    loop {
        let bytes = match reader.fill_buf() {
            Ok([]) => return Ok(something),
            Ok(bytes) => bytes,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
            Err(error) => return Err(error),
        };
        something |= !bytes.iter().all(|byte| byte.is_ascii_whitespace() || *byte == 0);
        let count = bytes.len();
        reader.consume(count);
    }
}

/// How gzip data starts.
pub(super) const GZIP: [u8; 2] = [0x1f, 0x8b];

/// The members of a gzip file one after the other, as gunzip reads them: what follows the last and is no gzip data is left out.
struct Members<R> {
    state: Member<R>,
    trailing: Rc<Cell<bool>>,
}

enum Member<R> {
    Unpacking(GzDecoder<R>),
    End,
}

impl<R: BufRead> Read for Members<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        while let Member::Unpacking(decoder) = &mut self.state {
            let count = decoder.read(buffer)?;
            if count > 0 || buffer.is_empty() {
                return Ok(count);
            }
            let Member::Unpacking(decoder) = mem::replace(&mut self.state, Member::End) else { break };
            let mut rest = decoder.into_inner();
            let next = rest.fill_buf()?;
            // A buffer may end between the two bytes; then one of them will do.
            if next.starts_with(&GZIP[..next.len().min(2)]) && !next.is_empty() {
                self.state = Member::Unpacking(GzDecoder::new(rest));
            } else {
                self.trailing.set(!next.is_empty());
            }
        }
        Ok(0)
    }
}

/// Counts the bytes that are read as progress.
struct Watched<R> {
    input: R,
    progress: Progress,
}

impl<R: Read> Read for Watched<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.input.read(buffer)?;
        self.progress.advance(count as u64);
        Ok(count)
    }
}

/// Counts the bytes that are read.
struct Counted<R> {
    input: R,
    count: Rc<Cell<u64>>,
}

impl<R: Read> Read for Counted<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.input.read(buffer)?;
        self.count.set(self.count.get() + count as u64);
        Ok(count)
    }
}

/// Fails with `FileTooLarge` when more is unpacked than the file's length, or else what was read of it, justifies.
struct Capped<R> {
    input: R,
    packed: Rc<Cell<u64>>,
    length: u64,
    allowed: Rc<Cell<u64>>,
    unpacked: u64,
}

impl<R: Read> Read for Capped<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.input.read(buffer)?;
        self.unpacked += count as u64;
        let by_size = UNPACKED_BASE.saturating_add(self.packed.get().max(self.length).saturating_mul(UNPACKED_RATIO));
        let limit = by_size.max(self.allowed.get());
        if self.unpacked > limit {
            let text = format!(
                "unpacks to more than {} MiB, out of proportion to its size ({} MiB + {UNPACKED_RATIO} times)",
                limit >> 20,
                UNPACKED_BASE >> 20
            );
            return Err(io::Error::new(io::ErrorKind::FileTooLarge, text));
        }
        Ok(count)
    }
}

/// Is it UTF-16, which a byte order mark or every other byte being zero tells, and is it big-endian?
fn utf16(start: &[u8]) -> Option<bool> {
    match *start {
        [0xff, 0xfe, 0, 0, ..] => None,
        [0xff, 0xfe, ..] | [1..=255, 0, 1..=255, 0, ..] => Some(false),
        [0xfe, 0xff, ..] | [0, 1..=255, 0, 1..=255, ..] => Some(true),
        _ => None,
    }
}

/// UTF-16 as UTF-8; what is no character becomes U+FFFD.
struct Utf16<R> {
    input: R,
    big_endian: bool,
    /// The first half of a pair.
    high: Option<u16>,
    out: Vec<u8>,
    sent: usize,
}

impl<R: BufRead> Utf16<R> {
    /// Turns some more units into bytes.
    fn more(&mut self) -> io::Result<()> {
        self.out.clear();
        self.sent = 0;
        let mut bytes = Vec::new();
        (&mut self.input).take(1 << 14).read_to_end(&mut bytes)?;
        let (units, odd) = bytes.as_chunks::<2>();
        let unit = |&pair: &[u8; 2]| if self.big_endian { u16::from_be_bytes(pair) } else { u16::from_le_bytes(pair) };
        let mut units: Vec<u16> = self.high.take().into_iter().chain(units.iter().map(unit)).collect();
        // A pair may be cut in two, but not at the end of the file.
        if bytes.len() == 1 << 14 && units.last().is_some_and(|unit| (0xd800..0xdc00).contains(unit)) {
            self.high = units.pop();
        }
        let characters = char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER));
        let text: String = characters.chain((!odd.is_empty()).then_some(char::REPLACEMENT_CHARACTER)).collect();
        self.out = text.into_bytes();
        Ok(())
    }
}

impl<R: BufRead> Read for Utf16<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.sent == self.out.len() {
            self.more()?;
        }
        let count = buffer.len().min(self.out.len() - self.sent);
        buffer[..count].copy_from_slice(&self.out[self.sent..self.sent + count]);
        self.sent += count;
        Ok(count)
    }
}
