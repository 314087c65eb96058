//! Text and colours over a picture: a sheet, partly transparent, that is laid over the rows of a picture as these are drawn.

use std::convert::Infallible;

use embedded_graphics::draw_target::DrawTarget;
use embedded_graphics::geometry::{OriginDimensions, Point, Size};
use embedded_graphics::mono_font::iso_8859_1::FONT_7X13;
use embedded_graphics::mono_font::{MonoFont, MonoTextStyle};
use embedded_graphics::pixelcolor::{Rgb888, RgbColor, WebColors};
use embedded_graphics::primitives::Rectangle;
use embedded_graphics::text::{Baseline, Text};
use embedded_graphics::{Drawable, Pixel};

const FONT: MonoFont<'_> = FONT_7X13;
/// Around the text.
const MARGIN: usize = 8;
/// How much of the picture is left where there is nothing but the sheet, of 256.
const LEFT: u32 = 80;

/// A sheet with text and colours.
#[derive(Clone, Debug)]
pub struct Sheet {
    width: usize,
    /// What is drawn, as 0x01RRGGBB; 0 where nothing is.
    pixels: Vec<u32>,
    /// Does it lie at the lower end of the picture? Else at the upper.
    below: bool,
}

/// The size of a character.
pub(super) const CHARACTER: [usize; 2] = [FONT.character_size.width as usize, FONT.character_size.height as usize];

impl Sheet {
    /// Lines of text, for the upper left corner. Characters that the font lacks are question marks.
    pub fn of_text(text: &str) -> Self {
        let longest = text.lines().map(|line| line.chars().count()).max().unwrap_or(0);
        let mut sheet = Self::new([longest * CHARACTER[0], text.lines().count() * CHARACTER[1]], false);
        sheet.write([0, 0], text);
        sheet
    }

    /// An empty one of a size, for the lower left corner if `below`.
    pub(super) fn new([width, height]: [usize; 2], below: bool) -> Self {
        let (width, height) = (width + 2 * MARGIN, height + 2 * MARGIN);
        Self { width, pixels: vec![0; width * height], below }
    }

    /// Writes lines of text.
    pub(super) fn write(&mut self, at: [usize; 2], text: &str) {
        let style = MonoTextStyle::new(&FONT, Rgb888::CSS_WHITE);
        let Ok(_) = Text::with_baseline(text, self.point(at), style, Baseline::Top).draw(self);
    }

    /// Fills a rectangle with a colour, bytes of sRGB.
    pub(super) fn fill(&mut self, at: [usize; 2], size: [usize; 2], [r, g, b]: [u8; 3]) {
        let area = Rectangle::new(self.point(at), Size::new(size[0] as u32, size[1] as u32));
        let Ok(()) = self.fill_solid(&area, Rgb888::new(r, g, b));
    }

    fn point(&self, [x, y]: [usize; 2]) -> Point {
        Point::new((x + MARGIN) as i32, (y + MARGIN) as i32)
    }

    fn height(&self) -> usize {
        self.pixels.len() / self.width
    }

    /// Covers row `y` of a picture of pixels 0x00RRGGBB, in its corner, as large as is easy to read.
    pub fn cover(&self, [width, height]: [usize; 2], y: usize, row: &mut [u32]) {
        let scale = (height / 600).min(width / self.width).clamp(1, 4);
        let above = if self.below { height.saturating_sub(self.height() * scale) } else { 0 };
        let Some(y) = y.checked_sub(above) else { return };
        let Some(written) = self.pixels.chunks_exact(self.width).nth(y / scale) else { return };
        for (pixel, written) in row.iter_mut().zip(written.iter().flat_map(|pixel| std::iter::repeat_n(pixel, scale))) {
            let darker = |shift: u32| ((*pixel >> shift & 255) * LEFT / 256) << shift;
            *pixel = if *written == 0 { darker(16) | darker(8) | darker(0) } else { written & 0x00ff_ffff };
        }
    }
}

impl OriginDimensions for Sheet {
    fn size(&self) -> Size {
        Size::new(self.width as u32, self.height() as u32)
    }
}

impl DrawTarget for Sheet {
    type Color = Rgb888;
    type Error = Infallible;

    fn draw_iter<I: IntoIterator<Item = Pixel<Rgb888>>>(&mut self, pixels: I) -> Result<(), Infallible> {
        for Pixel(at, color) in pixels {
            let (Ok(x), Ok(y)) = (usize::try_from(at.x), usize::try_from(at.y)) else { continue };
            if x < self.width && y < self.height() {
                self.pixels[y * self.width + x] = u32::from_be_bytes([1, color.r(), color.g(), color.b()]);
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_white_on_what_is_left_of_the_picture() {
        let sheet = Sheet::of_text("Hi\nthere, \u{3b1}");
        assert_eq!((sheet.width, sheet.height()), (8 * 7 + 16, 2 * 13 + 16));
        let mut rows = vec![vec![0x0064_3200; 100]; 60];
        for (y, row) in rows.iter_mut().enumerate() {
            sheet.cover([100, 60], y, row);
        }
        let count = |color: u32| rows.iter().flatten().filter(|pixel| **pixel == color).count();
        assert!(count(0x00ff_ffff) > 60, "the letters");
        assert_eq!(count(0x00ff_ffff) + count(0x001f_0f00), 72 * 42, "the sheet");
        assert_eq!(count(0x0064_3200), 100 * 60 - 72 * 42, "the rest of the picture");
        // On a large picture it is larger; on a small one, some of it is missing.
        let mut row = vec![0x00ff_ffff; 400];
        sheet.cover([400, 1200], 0, &mut row);
        assert_eq!(row.iter().filter(|pixel| **pixel != 0x00ff_ffff).count(), 2 * 72);
        sheet.cover([20, 10], 9, &mut [0; 20]);
        Sheet::of_text("").cover([20, 10], 9, &mut [0; 20]);
    }
}
