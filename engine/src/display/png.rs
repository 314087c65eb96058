//! Pictures as PNG files: 8 bits a channel, sRGB, the same bytes for the same picture.
//!
//! They are whole or not there, as [`output`] says.

use std::io::{self, BufWriter, Write};
use std::path::Path;

use flate2::Compression;
use flate2::write::ZlibEncoder;

use super::error::PictureError;
use crate::image::FrameBuffer;
use crate::output;

/// Writes a picture, without its alpha. Either the whole file is there afterwards, or what was there before.
///
/// # Errors
/// If it cannot be written; the error names the file.
pub fn write_png(file: &Path, picture: &FrameBuffer) -> Result<(), PictureError> {
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
) -> Result<(), PictureError> {
    output::write(file, |handle| encode(handle, size, pixels)).map_err(|problem| PictureError::new(file, problem))
}

/// Rows shorter than this, in pixels, are not filtered: to filter and compress each for itself costs more than it has pixels.
const NARROW: usize = 64;
/// Nor are rows longer than this: the filter keeps several of them.
const WIDE: usize = 1 << 20;

/// Encodes pixels as [`rgba8`](crate::image::rgba8) packs them, row by row from the top.
pub(super) fn encode(out: impl Write, size: [usize; 2], pixels: impl Iterator<Item = u32>) -> io::Result<()> {
    let mut out = BufWriter::with_capacity(1 << 16, out);
    let mut encoder = png::Encoder::new(&mut out, size[0] as u32, size[1] as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    let mut writer = encoder.write_header().map_err(plain)?;
    let pixels = pixels.map(|pixel| {
        let [red, green, blue, _] = pixel.to_le_bytes();
        [red, green, blue]
    });
    if (NARROW..=WIDE).contains(&size[0]) {
        filtered(&mut writer, size, pixels)?;
    } else {
        unfiltered(&mut writer, size, pixels)?;
    }
    writer.finish().map_err(plain)?;
    out.into_inner().map_err(io::IntoInnerError::into_error)?.flush()
}

fn filtered<W: Write>(
    writer: &mut png::Writer<W>,
    size: [usize; 2],
    mut pixels: impl Iterator<Item = [u8; 3]>,
) -> io::Result<()> {
    let mut body = writer.stream_writer().map_err(plain)?;
    let mut row = Vec::with_capacity(size[0] * 3);
    for _ in 0..size[1] {
        row.clear();
        row.extend(pixels.by_ref().take(size[0]).flatten());
        body.write_all(&row)?;
    }
    body.finish().map_err(plain)
}

/// Compresses many rows at once, or one in parts; each begins with the number of its filter, which is none.
fn unfiltered<W: Write>(
    writer: &mut png::Writer<W>,
    size: [usize; 2],
    mut pixels: impl Iterator<Item = [u8; 3]>,
) -> io::Result<()> {
    let chunks = BufWriter::with_capacity(1 << 16, DataChunks(writer));
    let mut body = BufWriter::with_capacity(1 << 16, ZlibEncoder::new(chunks, Compression::default()));
    for _ in 0..size[1] {
        body.write_all(&[0])?;
        pixels.by_ref().take(size[0]).try_for_each(|pixel| body.write_all(&pixel))?;
    }
    let compressed = body.into_inner().map_err(io::IntoInnerError::into_error)?;
    compressed.finish()?.flush()
}

/// Where compressed rows go: one chunk of image data a call.
struct DataChunks<'a, W: Write>(&'a mut png::Writer<W>);

impl<W: Write> Write for DataChunks<'_, W> {
    fn write(&mut self, data: &[u8]) -> io::Result<usize> {
        self.0.write_chunk(png::chunk::IDAT, data).map_err(plain)?;
        Ok(data.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// The system's error inside the encoder's, so that its kind is not lost.
fn plain(error: png::EncodingError) -> io::Error {
    match error {
        png::EncodingError::IoError(error) => error,
        other => io::Error::other(other),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::rgba8;
    use std::fs::{self, File};
    use std::path::PathBuf;
    use std::time::Instant;

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
    fn all_shapes_come_back() {
        let folder = folder("shapes");
        for (width, height) in [(1, 1), (1, 70_000), (63, 3), (64, 3), (WIDE, 1), (WIDE + 1, 2)] {
            let color = |place: usize| (place as u32).wrapping_mul(2_654_435_761) & 0xffffff;
            let file = folder.join("a.png");
            write_pixels(&file, [width, height], (0..width * height).map(color)).unwrap();
            let mut reader = png::Decoder::new(io::BufReader::new(File::open(&file).unwrap())).read_info().unwrap();
            let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
            reader.next_frame(&mut pixels).unwrap();
            assert_eq!(pixels.len(), width * height * 3);
            let right = |(place, pixel): (usize, &[u8])| pixel == &color(place).to_le_bytes()[..3];
            assert!(pixels.chunks_exact(3).enumerate().all(right), "{width}x{height}");
        }
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn a_high_picture_costs_what_a_wide_one_costs() {
        let folder = folder("high");
        let seconds = |size: [usize; 2]| {
            let start = Instant::now();
            write_pixels(&folder.join("a.png"), size, (0..400_000).map(|place: u32| place / 7)).unwrap();
            start.elapsed().as_secs_f64()
        };
        let least = |size| (0..5).map(|_| seconds(size)).fold(f64::INFINITY, f64::min);
        let (high, wide) = (least([1, 400_000]), least([400_000, 1]));
        assert!(high < 4.0 * wide, "{high} s, {wide} s");
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn errors_name_the_file() {
        let folder = folder("errors");
        let missing = folder.join("none").join("a.png");
        let text = write_png(&missing, &picture()).unwrap_err().to_string();
        assert!(
            text.starts_with(&missing.display().to_string()) && text.ends_with("; make the folder first"),
            "{text}"
        );
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
