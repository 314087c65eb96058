//! Pictures as PPM files: a line of text, and then bytes (Netpbm's format P6).

use std::io::{self, BufWriter, Write};

/// Encodes pixels as [`rgba8`](crate::image::rgba8) packs them, row by row from the top.
pub(super) fn encode(out: impl Write, size: [usize; 2], mut pixels: impl Iterator<Item = u32>) -> io::Result<()> {
    let mut out = BufWriter::with_capacity(1 << 16, out);
    write!(out, "P6\n{} {}\n255\n", size[0], size[1])?;
    pixels.try_for_each(|pixel| out.write_all(&pixel.to_le_bytes()[..3]))?;
    out.into_inner().map_err(io::IntoInnerError::into_error)?.flush()
}
