//! Pictures as JPEG files.

use std::io::{self, BufWriter, Write};

use image::ExtendedColorType;
use image::codecs::jpeg::JpegEncoder;

/// Little is to be seen of what is lost.
const QUALITY: u8 = 95;

/// Encodes pixels as [`rgba8`](crate::image::rgba8) packs them, row by row from the top.
pub(super) fn encode(out: impl Write, size: [usize; 2], pixels: impl Iterator<Item = u32>) -> io::Result<()> {
    let [Ok(width), Ok(height)] = size.map(u16::try_from) else {
        let problem =
            format!("{}x{} pixels are too many for a JPEG file, whose sides are at most 65535", size[0], size[1]);
        return Err(io::Error::new(io::ErrorKind::InvalidInput, problem));
    };
    let bytes: Vec<u8> = pixels.flat_map(|pixel| pixel.to_le_bytes().into_iter().take(3)).collect();
    let mut out = BufWriter::with_capacity(1 << 16, out);
    let mut encoder = JpegEncoder::new_with_quality(&mut out, QUALITY);
    let encoded = encoder.encode(&bytes, width.into(), height.into(), ExtendedColorType::Rgb8);
    encoded.map_err(|error| match error {
        image::ImageError::IoError(error) => error,
        other => io::Error::other(other),
    })?;
    out.into_inner().map_err(io::IntoInnerError::into_error)?.flush()
}
