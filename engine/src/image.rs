//! The picture that render threads fill.

use std::sync::atomic::{AtomicU32, Ordering};

/// Packs one RGBA8 pixel: red in the lowest byte.
pub const fn rgba8(red: u8, green: u8, blue: u8, alpha: u8) -> u32 {
    u32::from_le_bytes([red, green, blue, alpha])
}

/// RGBA8 pixels, row 0 on top.
#[derive(Debug)]
pub struct FrameBuffer {
    width: usize,
    pixels: Box<[AtomicU32]>,
}

/// The size is zero or too large.
#[derive(Debug)]
pub struct SizeError;

impl FrameBuffer {
    /// A transparent black picture.
    pub fn new(width: usize, height: usize) -> Result<Self, SizeError> {
        match width.checked_mul(height) {
            Some(1..=0x1000_0000) => {
                Ok(Self { width, pixels: (0..width * height).map(|_| AtomicU32::new(0)).collect() })
            }
            _ => Err(SizeError),
        }
    }

    /// Pixels in a row.
    pub const fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    pub const fn height(&self) -> usize {
        self.pixels.len() / self.width
    }

    /// Writes one pixel.
    #[inline]
    pub fn set(&self, x: usize, y: usize, color: u32) {
        assert!(x < self.width);
        self.pixels[y * self.width + x].store(color, Ordering::Relaxed);
    }

    /// The pixels, row by row from the top.
    pub fn pixels(&self) -> impl ExactSizeIterator<Item = u32> + '_ {
        self.pixels.iter().map(|pixel| pixel.load(Ordering::Relaxed))
    }

    /// The picture as bytes.
    pub fn to_rgba8(&self) -> Vec<u8> {
        self.pixels().flat_map(u32::to_le_bytes).collect()
    }
}
