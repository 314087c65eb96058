//! Picture sizes that have been checked, and the frame buffer that many threads write at once.
//!
//! Source: Bigler, Stephens and Parker 2006, section 5.2 (one frame buffer per pipeline stage).

use std::sync::OnceLock;
use std::sync::atomic::{AtomicU32, Ordering};

use crate::layers::Layers;

/// The most pixels one picture may have: 2^28, which is 1 GiB of RGBA8.
pub const MAX_PIXELS: u64 = 1 << 28;

/// Why a picture size was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SizeError {
    /// One side is zero.
    #[error("a picture of {width}x{height} has no pixels: both sides must be at least 1")]
    Empty {
        /// The width asked for.
        width: usize,
        /// The height asked for.
        height: usize,
    },
    /// More than [`MAX_PIXELS`] pixels.
    #[error("a picture of {width}x{height} is too large: at most {MAX_PIXELS} pixels (16384x16384)")]
    TooLarge {
        /// The width asked for.
        width: usize,
        /// The height asked for.
        height: usize,
    },
    /// The system has no memory for it.
    #[error("there is no memory for a picture of {width}x{height}: it takes {} MiB", (width * height).div_ceil(1 << 18))]
    NoMemory {
        /// The width asked for.
        width: usize,
        /// The height asked for.
        height: usize,
    },
}

/// The size of a picture in pixels: never empty, never more than [`MAX_PIXELS`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Size {
    width: u32,
    height: u32,
}

impl Size {
    /// Checks a size. Errors when a side is zero or the picture would exceed [`MAX_PIXELS`].
    pub fn new(width: usize, height: usize) -> Result<Self, SizeError> {
        if width == 0 || height == 0 {
            return Err(SizeError::Empty { width, height });
        }
        match (width as u64).checked_mul(height as u64) {
            Some(pixels) if pixels <= MAX_PIXELS => Ok(Self { width: width as u32, height: height as u32 }),
            _ => Err(SizeError::TooLarge { width, height }),
        }
    }

    /// One pixel.
    pub const SMALLEST: Self = Self { width: 1, height: 1 };

    /// Pixels in a row.
    pub const fn width(self) -> usize {
        self.width as usize
    }

    /// Rows.
    pub const fn height(self) -> usize {
        self.height as usize
    }

    /// Pixels in all.
    pub const fn pixels(self) -> usize {
        self.width as usize * self.height as usize
    }
}

impl std::fmt::Display for Size {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}x{}", self.width, self.height)
    }
}

/// Packs one RGBA8 pixel as the frame buffer holds it: red in the lowest byte.
pub const fn rgba8(red: u8, green: u8, blue: u8, alpha: u8) -> u32 {
    u32::from_le_bytes([red, green, blue, alpha])
}

/// A picture of RGBA8 pixels, row 0 on top, that render threads fill through a shared reference.
///
/// Pixels are relaxed atomics: on every common processor a relaxed store is a plain store, so this costs nothing, needs
/// no `unsafe`, and two threads that (wrongly) write one pixel get one of the two colours. The barrier at the end of
/// the frame is what orders the writes before the display's reads.
#[derive(Debug)]
pub struct FrameBuffer {
    size: Size,
    pixels: Box<[AtomicU32]>,
    /// Made when they are first asked for: most pictures have none.
    layers: OnceLock<Option<Layers>>,
}

impl FrameBuffer {
    /// A transparent black picture. Errors as [`Size::new`] does, and where there is no memory for it.
    pub fn new(width: usize, height: usize) -> Result<Self, SizeError> {
        Self::try_with_size(Size::new(width, height)?)
    }

    /// A transparent black picture of a size that was checked before.
    ///
    /// # Panics
    /// Where there is no memory for it.
    pub fn with_size(size: Size) -> Self {
        Self::try_with_size(size).unwrap_or_else(|error| panic!("{error}"))
    }

    /// A transparent black picture of a size that was checked before. Errors where there is no memory for it.
    pub fn try_with_size(size: Size) -> Result<Self, SizeError> {
        let mut pixels = Vec::new();
        let reserved = pixels.try_reserve_exact(size.pixels());
        reserved.map_err(|_| SizeError::NoMemory { width: size.width(), height: size.height() })?;
        pixels.extend((0..size.pixels()).map(|_| AtomicU32::new(0)));
        Ok(Self { size, pixels: pixels.into_boxed_slice(), layers: OnceLock::new() })
    }

    /// The size.
    pub const fn size(&self) -> Size {
        self.size
    }

    /// Linear colours and what is behind each pixel, if anybody wanted them.
    #[inline]
    pub fn layers(&self) -> Option<&Layers> {
        self.layers.get()?.as_ref()
    }

    /// As [`layers`](Self::layers); there are some from now on. `None` where there is no memory for them.
    pub fn with_layers(&self) -> Option<&Layers> {
        self.layers.get_or_init(|| Layers::new(self.width(), self.height())).as_ref()
    }

    /// Pixels in a row.
    pub const fn width(&self) -> usize {
        self.size.width()
    }

    /// Rows.
    pub const fn height(&self) -> usize {
        self.size.height()
    }

    /// Writes consecutive pixels of row `y`, the first at column `x`.
    ///
    /// # Panics
    /// When they do not lie inside the picture.
    #[inline]
    pub fn set_row(&self, x: usize, y: usize, colours: &[u32]) {
        for (pixel, &colour) in self.row_part(x, y, colours.len()).iter().zip(colours) {
            // Relaxed: ordered before the display by the pipeline's barrier.
            pixel.store(colour, Ordering::Relaxed);
        }
    }

    /// Writes pixels wherever they are, by column and row; the shorter list ends it.
    ///
    /// # Panics
    /// When one does not lie inside the picture.
    #[inline]
    pub fn set_each(&self, places: &[[u32; 2]], colours: &[u32]) {
        let width = self.width();
        for (&[x, y], &colour) in places.iter().zip(colours) {
            assert!((x as usize) < width, "column {x} is outside a {} picture", self.size);
            // Relaxed: ordered before the display by the pipeline's barrier.
            self.pixels[y as usize * width + x as usize].store(colour, Ordering::Relaxed);
        }
    }

    /// Writes one pixel.
    ///
    /// # Panics
    /// When it does not lie inside the picture.
    #[inline]
    pub fn set(&self, x: usize, y: usize, colour: u32) {
        self.set_row(x, y, &[colour]);
    }

    /// Reads one pixel.
    ///
    /// # Panics
    /// When it does not lie inside the picture.
    #[inline]
    pub fn get(&self, x: usize, y: usize) -> u32 {
        self.row_part(x, y, 1)[0].load(Ordering::Relaxed)
    }

    /// Fills the rectangle `x0..x1` by `y0..y1`; what lies outside the picture is left out.
    pub fn fill(&self, x0: usize, y0: usize, x1: usize, y1: usize, colour: u32) {
        let (x1, y1) = (x1.min(self.width()), y1.min(self.height()));
        for y in y0..y1 {
            for pixel in self.row_part(x0.min(x1), y, x1.saturating_sub(x0)) {
                pixel.store(colour, Ordering::Relaxed);
            }
        }
    }

    /// Copies the rectangle `x0..x1` by `y0..y1` from another picture; only pixels that both pictures have are copied, with their
    /// layers.
    pub fn copy_from(&self, other: &Self, x0: usize, y0: usize, x1: usize, y1: usize) {
        let (x1, y1) = (x1.min(self.width()).min(other.width()), y1.min(self.height()).min(other.height()));
        for y in y0..y1 {
            let (start, count) = (x0.min(x1), x1.saturating_sub(x0));
            for (to, from) in self.row_part(start, y, count).iter().zip(other.row_part(start, y, count)) {
                to.store(from.load(Ordering::Relaxed), Ordering::Relaxed);
            }
        }
        if let Some(layers) = other.layers()
            && let Some(own) = self.with_layers()
        {
            own.copy_from(layers, x0, y0, x1, y1);
        }
    }

    /// The pixels, row by row from the top, as [`rgba8`] packs them.
    pub fn pixels(&self) -> impl ExactSizeIterator<Item = u32> + '_ {
        self.pixels.iter().map(|pixel| pixel.load(Ordering::Relaxed))
    }

    /// The picture as bytes: red, green, blue, alpha of each pixel, row by row from the top.
    pub fn to_rgba8(&self) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(self.size.pixels() * 4);
        for pixel in self.pixels() {
            bytes.extend_from_slice(&pixel.to_le_bytes());
        }
        bytes
    }

    #[inline]
    fn row_part(&self, x: usize, y: usize, count: usize) -> &[AtomicU32] {
        let (width, height) = (self.width(), self.height());
        assert!(
            y < height && x <= width && count <= width - x,
            "pixels {x}..{} of row {y} are outside a {} picture",
            x.saturating_add(count),
            self.size
        );
        &self.pixels[y * width + x..][..count]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_checked() {
        assert!(matches!(Size::new(0, 5), Err(SizeError::Empty { .. })));
        assert!(matches!(FrameBuffer::new(100_000, 100_000), Err(SizeError::TooLarge { .. })));
        assert!(matches!(Size::new(usize::MAX, usize::MAX), Err(SizeError::TooLarge { .. })));
        assert!(matches!(Size::new(usize::MAX, 1), Err(SizeError::TooLarge { .. })));
        assert_eq!(Size::new(16384, 16384).unwrap().pixels() as u64, MAX_PIXELS);
    }

    #[test]
    fn rows_land_where_they_should() {
        let picture = FrameBuffer::new(3, 2).unwrap();
        picture.set_row(1, 1, &[rgba8(1, 2, 3, 4), rgba8(5, 6, 7, 8)]);
        let bytes = picture.to_rgba8();
        assert_eq!(&bytes[16..], &[1, 2, 3, 4, 5, 6, 7, 8]);
        assert!(bytes[..16].iter().all(|&byte| byte == 0));
        let copy = FrameBuffer::new(2, 2).unwrap();
        copy.copy_from(&picture, 0, 0, 9, 9);
        assert_eq!(copy.get(1, 1), rgba8(1, 2, 3, 4));
        copy.fill(1, 0, 9, 9, 7);
        assert_eq!(copy.pixels().collect::<Vec<_>>(), [0, 7, 0, 7]);
    }

    #[test]
    #[should_panic(expected = "outside a 3x2 picture")]
    fn a_row_past_the_edge_is_refused() {
        FrameBuffer::new(3, 2).unwrap().set_row(2, 0, &[0, 0]);
    }
}
