//! Voxels out of bytes or text, as many as a header says.

use std::io::{BufRead, ErrorKind, Read};

use super::filling::{Filling, Refused};
use super::header::Header;
use super::source::Source;
use crate::load::LoadError;
use crate::load::text::{counted, number, quoted};

/// The longest word that may be a number: all digits of the least `f64` above 0 are some more than a thousand.
const LONGEST_NUMBER: usize = 2048;

/// So many bytes or more stay in the file, and are read where they are looked at: they may be more than there is memory.
const MAPPED: u64 = 1 << 28;

impl Refused {
    fn into_error(self, source: &Source, header: &Header) -> LoadError {
        let described = header.layout.describe(header.kind);
        LoadError::new(source.file(), format!("{self}: {described}"), "cut the grid, or make its voxels smaller")
    }
}

/// The error where there are too few voxels.
fn missing(source: &Source, header: &Header, bytes: u64) -> LoadError {
    let described = header.layout.describe(header.kind);
    let problem = format!("{} of voxels missing: {described}", counted(bytes, "byte"));
    LoadError::new(source.file(), problem, "the file is truncated, or its header wrong")
}

/// Makes sure that there may be so many bytes, before any is read.
pub(super) fn expect(source: &Source, header: &Header, bytes: u64) -> Result<(), LoadError> {
    match source.left() {
        Some(left) if left < bytes => Err(missing(source, header, bytes - left)),
        _ => Ok(()),
    }
}

/// Reads so many bytes of voxels.
pub(super) fn binary(
    source: &mut Source,
    header: &Header,
    filling: &mut dyn Filling,
    bytes: u64,
) -> Result<(), LoadError> {
    expect(source, header, bytes)?;
    let as_here = header.big_endian == cfg!(target_endian = "big") || header.kind.bytes() == 1;
    if bytes >= MAPPED
        && as_here
        && let Some((map, range)) = source.map(bytes)
        && filling.map(&map, range)
    {
        source.pass(bytes);
        return Ok(());
    }
    if source.left().is_some() && bytes == header.layout.bytes(header.kind) {
        filling.reserve().map_err(|refused| refused.into_error(source, header))?;
    }
    let mut buffer = vec![0; (1 << 16).min(bytes as usize)];
    let mut rest = bytes;
    while rest > 0 {
        let wanted = rest.min(buffer.len() as u64) as usize;
        let mut count = 0;
        while count < wanted {
            match source.read(&mut buffer[count..wanted]) {
                Ok(0) => return Err(missing(source, header, rest - count as u64)),
                Ok(more) => count += more,
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(source.error(&error)),
            }
        }
        rest -= wanted as u64;
        let added = filling.add_bytes(&buffer[..wanted], header.big_endian);
        added.map_err(|refused| refused.into_error(source, header))?;
    }
    Ok(())
}

/// Reads so many voxels that are written as text, with white space or commas between them.
pub(super) fn text(
    source: &mut Source,
    header: &Header,
    filling: &mut dyn Filling,
    count: u64,
) -> Result<(), LoadError> {
    // Each takes a digit and what parts it from the next.
    if source.left().is_some_and(|left| left.saturating_add(1) / 2 < count) {
        return Err(too_few(source, header));
    }
    let mut word = Vec::new();
    for _ in 0..count {
        next_word(source, &mut word)?;
        if word.is_empty() {
            return Err(too_few(source, header));
        }
        let text = String::from_utf8_lossy(&word);
        let fault = |problem: &str, remedy: &str| {
            Err(LoadError::new(source.file(), format!("voxel {} {problem}", quoted(&text)), remedy))
        };
        let Some(number) = number(&text).filter(|_| word.len() <= LONGEST_NUMBER) else {
            return fault("is not a number", "check how it was written");
        };
        match filling.add_number(number) {
            Ok(()) => {}
            Err(Refused::Value(kind)) => return fault(&format!("is no value of type {kind}"), "change the type"),
            Err(refused) => return Err(refused.into_error(source, header)),
        }
    }
    // What parts the last from the end of the file is nothing that is left out.
    while let Some(&byte) = source.peek()?.first()
        && parts(byte)
    {
        source.consume(1);
    }
    Ok(())
}

fn too_few(source: &Source, header: &Header) -> LoadError {
    let described = header.layout.describe(header.kind);
    LoadError::new(
        source.file(),
        format!("voxels are missing: {described}"),
        "the file is truncated, or its header wrong",
    )
}

/// Does it part numbers?
fn parts(byte: u8) -> bool {
    byte.is_ascii_whitespace() || byte == b','
}

/// The next word, or the first bytes of one that is too long; empty at the end of the file.
fn next_word(source: &mut Source, word: &mut Vec<u8>) -> Result<(), LoadError> {
    word.clear();
    loop {
        let bytes = source.peek()?;
        if bytes.is_empty() {
            return Ok(());
        }
        let skipped = if word.is_empty() { bytes.iter().take_while(|&&byte| parts(byte)).count() } else { 0 };
        let rest = &bytes[skipped..];
        let length = rest.iter().position(|&byte| parts(byte)).unwrap_or(rest.len());
        word.extend_from_slice(&rest[..length.min(LONGEST_NUMBER + 1)]);
        let ended = length < rest.len() || word.len() > LONGEST_NUMBER;
        source.consume(skipped + length);
        if ended && !word.is_empty() {
            return Ok(());
        }
    }
}
