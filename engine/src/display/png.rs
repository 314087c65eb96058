//! Pictures as PNG files: 8 bits a channel, sRGB, the same bytes for the same picture.
//!
//! A file is written beside its final place and renamed when it is complete, so that nobody ever sees half of one.

use std::error::Error;
use std::ffi::OsString;
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

use crate::image::FrameBuffer;
use crate::pipeline::{Display, Picture, Shown};

/// A picture that could not be written.
#[derive(Debug, thiserror::Error)]
#[error("{}: cannot be written: {problem}; {}", file.display(), remedy(problem))]
pub struct PngError {
    /// The file as it was named.
    pub file: PathBuf,
    /// What the system said.
    pub problem: io::Error,
}

fn remedy(problem: &io::Error) -> &'static str {
    match problem.kind() {
        io::ErrorKind::NotFound => "make the folder first",
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => "free some space or choose another folder",
        io::ErrorKind::IsADirectory => "add a file name",
        _ => "choose another folder",
    }
}

/// Writes a picture, without its alpha. Either the whole file is there afterwards, or what was there before.
///
/// # Errors
/// If it cannot be written; the error names the file.
pub fn write_png(file: &Path, picture: &FrameBuffer) -> Result<(), PngError> {
    let (size, pixels) = (picture.size(), picture.pixels());
    write_pixels(file, [size.width(), size.height()], pixels)
}

/// As [`write_png`], from pixels as [`rgba8`](crate::image::rgba8) packs them, row by row from the top.
///
/// # Errors
/// If it cannot be written; the error names the file.
pub fn write_pixels(
    file: &Path,
    size: [usize; 2],
    pixels: impl ExactSizeIterator<Item = u32>,
) -> Result<(), PngError> {
    let write = || {
        // Devices and pipes are written to; renaming would replace them. Links are followed.
        let target = match fs::metadata(file) {
            Ok(there) if there.is_dir() => return Err(io::ErrorKind::IsADirectory.into()),
            Ok(there) if !there.is_file() => return encode(OpenOptions::new().write(true).open(file)?, size, pixels),
            Ok(_) => fs::canonicalize(file)?,
            Err(_) => file.to_owned(),
        };
        let (temporary, handle) = create_beside(&target)?;
        let written = encode(handle, size, pixels).and_then(|()| fs::rename(&temporary, &target));
        if written.is_err() {
            let _ = fs::remove_file(&temporary);
        }
        written
    };
    write().map_err(|problem| PngError { file: file.to_owned(), problem })
}

/// A new file in the folder of `target`, with a name of its own.
fn create_beside(target: &Path) -> io::Result<(PathBuf, File)> {
    static NEXT: AtomicU32 = AtomicU32::new(0);
    let name = target.file_name().ok_or(io::ErrorKind::InvalidFilename)?;
    loop {
        let mut temporary = OsString::from(".");
        temporary.push(name);
        // Relaxed: only the numbers must differ.
        temporary.push(format!(".{}-{}.tmp", std::process::id(), NEXT.fetch_add(1, Ordering::Relaxed)));
        let path = target.with_file_name(temporary);
        match OpenOptions::new().write(true).create_new(true).open(&path) {
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            Err(error) => return Err(error),
            Ok(handle) => return Ok((path, handle)),
        }
    }
}

fn encode(handle: File, size: [usize; 2], pixels: impl Iterator<Item = u32>) -> io::Result<()> {
    let mut out = BufWriter::with_capacity(1 << 16, handle);
    let mut encoder = png::Encoder::new(&mut out, size[0] as u32, size[1] as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    let mut writer = encoder.write_header().map_err(plain)?;
    let mut body = writer.stream_writer().map_err(plain)?;
    let mut row = Vec::with_capacity(size[0] * 3);
    let mut pixels = pixels;
    for _ in 0..size[1] {
        row.clear();
        row.extend(pixels.by_ref().take(size[0]).flat_map(|pixel| {
            let [red, green, blue, _] = pixel.to_le_bytes();
            [red, green, blue]
        }));
        body.write_all(&row)?;
    }
    body.finish().map_err(plain)?;
    writer.finish().map_err(plain)?;
    out.into_inner().map_err(io::IntoInnerError::into_error)?.flush()
}

/// The system's error inside the encoder's, so that its kind is not lost.
fn plain(error: png::EncodingError) -> io::Error {
    match error {
        png::EncodingError::IoError(error) => error,
        other => io::Error::other(other),
    }
}

/// Writes pictures to one file: each in place of the one before, or a single frame only.
#[derive(Clone, Debug)]
pub struct PngDisplay {
    file: PathBuf,
    only: Option<u64>,
}

impl PngDisplay {
    /// Writes every frame.
    pub fn new(file: impl Into<PathBuf>) -> Self {
        Self { file: file.into(), only: None }
    }

    /// Writes one frame only, by its number.
    #[must_use]
    pub fn only(self, frame: u64) -> Self {
        Self { only: Some(frame), ..self }
    }
}

impl Display for PngDisplay {
    fn name(&self) -> &str {
        "PNG display"
    }

    fn show(&mut self, picture: &Picture<'_>) -> Result<Shown, Box<dyn Error + Send + Sync>> {
        if self.only.is_none_or(|frame| frame == picture.frame) {
            write_png(&self.file, picture.buffer)?;
        }
        Ok(Shown::Continue)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::rgba8;

    fn picture() -> FrameBuffer {
        let picture = FrameBuffer::new(5, 3).unwrap();
        for y in 0..3 {
            for x in 0..5 {
                picture.set(x, y, rgba8(x as u8, y as u8, 200, 17));
            }
        }
        picture
    }

    fn folder(test: &str) -> PathBuf {
        let path = std::env::temp_dir().join(format!("mobula-png-{test}-{}", std::process::id()));
        fs::create_dir_all(&path).unwrap();
        path
    }

    #[test]
    fn pixels_come_back_and_bytes_are_the_same() {
        let folder = folder("back");
        let file = folder.join("a.png");
        write_png(&file, &picture()).unwrap();
        let first = fs::read(&file).unwrap();
        write_png(&file, &picture()).unwrap();
        assert_eq!(first, fs::read(&file).unwrap());
        let mut reader = png::Decoder::new(io::Cursor::new(&first)).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut pixels).unwrap();
        assert_eq!((info.width, info.height, info.color_type), (5, 3, png::ColorType::Rgb));
        assert_eq!(pixels[(5 + 4) * 3..][..3], [4, 1, 200]);
        assert!(reader.info().srgb.is_some());
        let left: Vec<_> = fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        assert_eq!(left, ["a.png"]);
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn errors_name_the_file() {
        let folder = folder("errors");
        let missing = folder.join("none").join("a.png");
        let text = write_png(&missing, &picture()).unwrap_err().to_string();
        assert!(text.starts_with(&missing.display().to_string()) && text.ends_with("; make the folder first"), "{text}");
        let text = write_png(&folder, &picture()).unwrap_err().to_string();
        assert!(text.ends_with("; add a file name"), "{text}");
        fs::remove_dir_all(folder).unwrap();
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_disk_is_an_error_and_a_device_stays_one() {
        let full = Path::new("/dev/full");
        if full.exists() {
            let text = write_png(full, &picture()).unwrap_err().to_string();
            assert!(text.starts_with("/dev/full: ") && text.ends_with("; free some space or choose another folder"));
        }
        write_png(Path::new("/dev/null"), &picture()).unwrap();
        assert!(!fs::metadata("/dev/null").unwrap().is_file());
    }
}
