//! The bytes of a file with voxels: what is skipped, unpacked, and known of how many there are.

use std::collections::HashSet;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};
use std::ops::Range;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

use flate2::bufread::ZlibDecoder;
use memmap2::Mmap;

use crate::load::input::{self, GZIP, Input, Packed};
use crate::load::text::{counted, quoted};
use crate::load::{LoadError, Options};

/// The bytes of a file.
pub(super) struct Source {
    file: PathBuf,
    reader: Box<dyn BufRead>,
    /// How many bytes are left, where that is known.
    left: Option<u64>,
    /// Are they unpacked while they are read?
    packed: bool,
}

/// How voxels are packed inside a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Packing {
    Gzip,
    Zlib,
}

impl Source {
    /// What is left of a file.
    pub(super) fn of(file: &Path, input: &mut Input) -> Self {
        let reader = std::mem::replace(&mut input.reader, Box::new(io::empty()));
        Self { file: file.to_owned(), reader, left: input.length, packed: input.gzip }
    }

    /// The file that a header at `header` calls `name`: a regular file in the same folder or below.
    pub(super) fn beside(header: &Path, name: &str, options: &Options) -> Result<Self, LoadError> {
        let name = name.trim().replace('\\', "/");
        let path = Path::new(&name);
        let below = path.components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir));
        if name.is_empty() || !below || name.contains('\0') || name.as_bytes().get(1) == Some(&b':') {
            let problem = format!("its voxels are in the file {}, which is not below its own folder", quoted(&name));
            return Err(LoadError::new(header, problem, "put the file beside it, and name it without a folder"));
        }
        let file = header.parent().unwrap_or(Path::new("")).join(path);
        if !input::is_regular(&file) {
            let problem = format!("its voxels are in the file {}, which is not there", quoted(&name));
            return Err(LoadError::new(header, problem, "put the file beside it"));
        }
        let mut input = input::open_bytes(&file, &options.progress, Packed::No)?;
        Ok(Self::of(&file, &mut input))
    }

    /// The file's name.
    pub(super) fn file(&self) -> &Path {
        &self.file
    }

    /// How many bytes are left, where that is known.
    pub(super) fn left(&self) -> Option<u64> {
        self.left
    }

    /// Are the bytes unpacked while they are read?
    pub(super) fn is_packed(&self) -> bool {
        self.packed
    }

    /// The next bytes, which are not taken.
    pub(super) fn peek(&mut self) -> Result<&[u8], LoadError> {
        // A buffer is filled twice where the first time says why it cannot be: the borrow ends with the error.
        if let Err(error) = self.reader.fill_buf() {
            return Err(self.error(&error));
        }
        Ok(self.reader.fill_buf().unwrap_or_default())
    }

    /// What an error while reading means.
    pub(super) fn error(&self, error: &io::Error) -> LoadError {
        let (problem, remedy) = input::explain(error, self.packed);
        LoadError::new(&self.file, problem, remedy)
    }

    /// Skips lines.
    pub(super) fn skip_lines(&mut self, count: u64) -> Result<(), LoadError> {
        for line in 0..count {
            loop {
                let bytes = self.peek()?;
                if bytes.is_empty() {
                    let problem = format!("{count} lines before the voxels are to be skipped, but it has only {line}");
                    return Err(LoadError::new(&self.file, problem, "check the header"));
                }
                let end = bytes.iter().position(|&byte| byte == b'\n');
                let skipped = end.map_or(bytes.len(), |end| end + 1);
                self.consume(skipped);
                if end.is_some() {
                    break;
                }
            }
        }
        Ok(())
    }

    /// Skips bytes.
    pub(super) fn skip_bytes(&mut self, count: u64) -> Result<(), LoadError> {
        let mut rest = count;
        while rest > 0 && self.left.is_none_or(|left| left >= rest) {
            let length = self.peek()?.len();
            let skipped = rest.min(length as u64);
            self.consume(skipped as usize);
            rest -= skipped;
            if length == 0 {
                break;
            }
        }
        if rest > 0 {
            let problem = format!("{count} bytes before the voxels are to be skipped, but it has fewer");
            return Err(LoadError::new(&self.file, problem, "check the header"));
        }
        Ok(())
    }

    /// The file, mapped, and where the next bytes are in it; `None` if they are not in a file as they are, or it cannot be mapped.
    pub(super) fn map(&self, bytes: u64) -> Option<(Arc<Mmap>, Range<usize>)> {
        let left = self.left.filter(|&left| !self.packed && left >= bytes && input::is_regular(&self.file))?;
        let file = File::open(&self.file).ok()?;
        let start = file.metadata().ok()?.len().checked_sub(left)?;
        // SAFETY: nothing here writes to the file. Who changes it while it is shown sees other voxels, which may be any; who cuts it
        // ends this process, as with any file that is mapped.
        let map = unsafe { Mmap::map(&file) }.ok()?;
        let range = usize::try_from(start).ok()?..usize::try_from(start + bytes).ok()?;
        Some((Arc::new(map), range))
    }

    /// Passes by bytes that need not be read, of those that are left: what follows can be told of, but not read.
    pub(super) fn pass(&mut self, bytes: u64) {
        let left = self.left.unwrap_or(0).saturating_sub(bytes);
        (self.left, self.reader) = (Some(left), Box::new(BufReader::with_capacity(16, io::repeat(0).take(left))));
    }

    /// What the rest unpacks to. Nothing limits it: take no more than what is wanted.
    pub(super) fn unpack(self, packing: Packing) -> Self {
        let Self { file, reader, .. } = self;
        let unpacked: Box<dyn Read> = match packing {
            Packing::Gzip => input::gunzip(reader),
            Packing::Zlib => Box::new(ZlibDecoder::new(reader)),
        };
        Self { file, reader: Box::new(BufReader::with_capacity(1 << 16, unpacked)), left: None, packed: true }
    }

    /// As [`unpack`](Self::unpack), packed in the way that the bytes look like.
    pub(super) fn unpack_any(mut self) -> Result<Self, LoadError> {
        let gzip = self.peek()?.starts_with(&GZIP);
        Ok(self.unpack(if gzip { Packing::Gzip } else { Packing::Zlib }))
    }

    /// What people should know if there is more than was wanted.
    pub(super) fn rest(&mut self) -> Result<Option<String>, LoadError> {
        let more = !self.peek()?.is_empty();
        let bytes = self.left.map_or("what is".to_owned(), |left| counted(left, "byte"));
        Ok(more.then(|| format!("{}: {bytes} behind the voxels left out", self.file.display())))
    }
}

impl Read for Source {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.reader.read(buffer)?;
        self.left = self.left.map(|left| left.saturating_sub(count as u64));
        Ok(count)
    }
}

impl BufRead for Source {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        self.reader.fill_buf()
    }

    fn consume(&mut self, count: usize) {
        self.reader.consume(count);
        self.left = self.left.map(|left| left.saturating_sub(count as u64));
    }
}

/// The names of a series of files: `slice%03d.raw` with the numbers from `first` to `last`.
pub(super) fn numbered(pattern: &str, [first, last, step]: [i64; 3]) -> Option<Vec<String>> {
    let (before, after) = pattern.split_once('%')?;
    let (width, after) = after.split_once(['d', 'i', 'u'])?;
    let zeros = width.starts_with('0');
    let width: usize = if width.is_empty() { 0 } else { width.parse().ok()? };
    let count = last.checked_sub(first)?.checked_div(step).filter(|&count| (0..MOST_FILES as i64).contains(&count))?;
    if width > 20 || after.contains('%') {
        return None;
    }
    let number = |i: i64| if zeros { format!("{i:0width$}") } else { format!("{i:width$}") };
    Some((0..=count).map(|i| format!("{before}{}{after}", number(first + i * step))).collect())
}

/// A file that is named twice: its bytes would be as many voxels as the header likes.
pub(super) fn repeated(names: &[String]) -> Option<&str> {
    let mut seen = HashSet::new();
    let plain = |name: &str| name.split(['/', '\\']).filter(|part| !matches!(*part, "" | ".")).collect::<PathBuf>();
    names.iter().find(|name| !seen.insert(plain(name.trim()))).map(String::as_str)
}

/// The most files that a header may name.
pub(super) const MOST_FILES: usize = 1 << 16;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_named_once() {
        assert_eq!(repeated(&["a", "b", "b/a"].map(str::to_owned)), None);
        assert_eq!(repeated(&["b/a", "a", ".\\b//./a "].map(str::to_owned)), Some(".\\b//./a "));
    }

    #[test]
    fn names_of_series() {
        let names = |pattern, range| numbered(pattern, range);
        assert_eq!(names("a%03d.raw", [8, 12, 2]).unwrap(), ["a008.raw", "a010.raw", "a012.raw"]);
        assert_eq!(names("%d", [1, -1, -1]).unwrap(), ["1", "0", "-1"]);
        for (pattern, range) in [
            ("a.raw", [1, 2, 1]),
            ("a%d%d", [1, 2, 1]),
            ("a%s", [1, 2, 1]),
            ("a%99d", [1, 2, 1]),
            ("a%d", [1, 2, 0]),
            ("a%d", [2, 1, 1]),
            ("a%d", [0, i64::MAX, 1]),
            ("a%d", [i64::MIN, i64::MAX, 1]),
            ("a%d", [i64::MIN, 0, -1]),
        ] {
            assert_eq!(names(pattern, range), None, "{pattern} {range:?}");
        }
    }
}
