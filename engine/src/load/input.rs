//! Opening files: plain or gzip by content, and never more data than the file's own size justifies.

use std::fs::{self, File};
use std::io::{self, BufRead, BufReader, Read};
use std::path::Path;

use flate2::bufread::MultiGzDecoder;

use super::LoadError;

/// A gzip file may unpack to this much whatever its size...
const UNPACKED_BASE: u64 = 16 << 20;
/// ... and to this many times its size beyond that. Meshes as text shrink 3 to 10 times.
const UNPACKED_RATIO: u64 = 32;

/// An opened file, unpacked as it is read.
pub(super) struct Input {
    /// The unpacked bytes.
    pub(super) reader: Box<dyn BufRead>,
    /// Was it gzip?
    pub(super) gzip: bool,
}

/// Opens `file`, looking at its first bytes to see whether it is gzip.
pub(super) fn open(file: &Path) -> Result<Input, LoadError> {
    let handle = File::open(file).map_err(|e| unreadable(file, &e))?;
    let metadata = handle.metadata().map_err(|e| unreadable(file, &e))?;
    if metadata.is_dir() {
        return Err(LoadError::new(file, "is a directory", "name a file in it"));
    }
    let mut reader = BufReader::with_capacity(1 << 16, handle);
    let start = reader.fill_buf().map_err(|e| unreadable(file, &e))?;
    if !start.starts_with(&[0x1f, 0x8b]) {
        return Ok(Input { reader: Box::new(reader), gzip: false });
    }
    let limit = UNPACKED_BASE.saturating_add(metadata.len().saturating_mul(UNPACKED_RATIO));
    let unpacked = Capped { input: MultiGzDecoder::new(reader), left: limit, limit };
    Ok(Input { reader: Box::new(BufReader::with_capacity(1 << 16, unpacked)), gzip: true })
}

/// Is it a regular file? Files that are named inside other files must be: they could name a pipe or a device.
pub(super) fn is_regular(file: &Path) -> bool {
    fs::metadata(file).is_ok_and(|m| m.is_file())
}

fn unreadable(file: &Path, error: &io::Error) -> LoadError {
    match error.kind() {
        io::ErrorKind::NotFound => LoadError::new(file, "no such file", "check the path"),
        io::ErrorKind::PermissionDenied => LoadError::new(file, "permission denied", "make the file readable"),
        _ => LoadError::new(file, format!("cannot be read: {error}"), ""),
    }
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

/// Reads at most `limit` bytes, then fails with `FileTooLarge`.
struct Capped<R> {
    input: R,
    left: u64,
    limit: u64,
}

impl<R: Read> Read for Capped<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.input.read(buffer)?;
        match self.left.checked_sub(count as u64) {
            Some(left) => self.left = left,
            None => {
                let text = format!(
                    "unpacks to more than {} MiB, out of proportion to its size ({} MiB + {UNPACKED_RATIO} times)",
                    self.limit >> 20,
                    UNPACKED_BASE >> 20
                );
                return Err(io::Error::new(io::ErrorKind::FileTooLarge, text));
            }
        }
        Ok(count)
    }
}
