//! Text and colours over a picture: a sheet, partly transparent, that is laid over the rows of a picture as these are drawn.

use std::convert::Infallible;

use embedded_graphics::draw_target::DrawTarget;
use embedded_graphics::geometry::{OriginDimensions, Point, Size};
use embedded_graphics::mono_font::iso_8859_1::{FONT_4X6, FONT_5X8, FONT_7X13};
use embedded_graphics::mono_font::{MonoFont, MonoTextStyle};
use embedded_graphics::pixelcolor::{Rgb888, RgbColor};
use embedded_graphics::primitives::Rectangle;
use embedded_graphics::text::{Baseline, Text};
use embedded_graphics::{Drawable, Pixel};

/// The fonts that there are, the largest first.
#[cfg_attr(not(feature = "window"), allow(dead_code, reason = "legends have the first"))]
const FONTS: [MonoFont<'static>; 3] = [FONT_7X13, FONT_5X8, FONT_4X6];
const FONT: MonoFont<'static> = FONTS[0];
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
    corner: Corner,
    font: MonoFont<'static>,
}

/// Where a sheet lies on the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Corner {
    #[default]
    /// Above, on the left.
    UpperLeft,
    /// Above, on the right.
    UpperRight,
    /// Below, on the left.
    LowerLeft,
    /// Below, in the middle.
    Below,
    /// In the middle.
    Middle,
}

/// The size of a character of the largest font.
pub(super) const CHARACTER: [usize; 2] = size_of(&FONT);

const fn size_of(font: &MonoFont<'_>) -> [usize; 2] {
    [font.character_size.width as usize, font.character_size.height as usize]
}

/// The colours of text, bytes of sRGB.
#[cfg_attr(not(feature = "window"), allow(dead_code, reason = "legends are white"))]
pub(super) mod ink {
    pub(crate) const TEXT: [u8; 3] = [255; 3];
    pub(crate) const HEADING: [u8; 3] = [255, 214, 120];
    pub(crate) const KEY: [u8; 3] = [150, 210, 255];
    pub(crate) const BAR: [u8; 3] = [90, 170, 255];
    pub(crate) const EMPTY: [u8; 3] = [70; 3];
}

impl Sheet {
    /// Lines of text, for the upper left corner. Characters that the font lacks are question marks.
    pub fn of_text(text: &str) -> Self {
        Self::of_text_in(text, FONT, Corner::UpperLeft)
    }

    /// Lines of text in the largest font in which they fit into a picture of a size, if there is one, else in the smallest.
    #[cfg(feature = "window")]
    pub fn fitted(text: &str, picture: [usize; 2], corner: Corner) -> Self {
        let (longest, lines) = extent(text);
        let fits = |font: &&MonoFont<'static>| {
            let [most_characters, most_lines] = capacity(font, picture);
            longest <= most_characters && lines <= most_lines
        };
        Self::of_text_in(text, *FONTS.iter().find(fits).unwrap_or(&FONTS[2]), corner)
    }

    /// Lines of text in the middle, with a bar below that shows which part of something is done, if that is known.
    #[cfg(feature = "window")]
    pub fn of_progress(text: &str, share: Option<f64>, picture: [usize; 2]) -> Self {
        let (longest, lines) = extent(text);
        let most = capacity(&FONT, picture)[0].max(1);
        let width = longest.max(40).min(most) * CHARACTER[0];
        let mut sheet = Self { corner: Corner::Middle, ..Self::new([width, (lines + 1) * CHARACTER[1]], false) };
        sheet.write([0, 0], text);
        if let Some(share) = share {
            let top = lines * CHARACTER[1] + 3;
            sheet.fill([0, top], [width, CHARACTER[1] - 6], ink::EMPTY);
            sheet.fill([0, top], [(width as f64 * share.clamp(0.0, 1.0)) as usize, CHARACTER[1] - 6], ink::BAR);
        }
        sheet
    }

    /// How many characters of the largest font a line may have in a picture of a width.
    #[cfg(feature = "window")]
    pub fn most_characters(width: usize) -> usize {
        capacity(&FONT, [width, 0])[0]
    }

    fn of_text_in(text: &str, font: MonoFont<'static>, corner: Corner) -> Self {
        let (longest, lines) = extent(text);
        let mut sheet = Self::of_characters([longest, lines], font, corner);
        sheet.write([0, 0], text);
        sheet
    }

    /// An empty one with room for so many characters and lines.
    pub(super) fn of_characters([characters, lines]: [usize; 2], font: MonoFont<'static>, corner: Corner) -> Self {
        let [width, height] = size_of(&font);
        Self { font, corner, ..Self::new([characters * width, lines * height], false) }
    }

    /// An empty one of a size, for the lower left corner if `below`.
    pub(super) fn new([width, height]: [usize; 2], below: bool) -> Self {
        let (width, height) = (width + 2 * MARGIN, height + 2 * MARGIN);
        let corner = if below { Corner::LowerLeft } else { Corner::UpperLeft };
        Self { width, pixels: vec![0; width * height], corner, font: FONT }
    }

    /// Writes lines of text.
    pub(super) fn write(&mut self, at: [usize; 2], text: &str) {
        self.write_in(ink::TEXT, at, text);
    }

    fn write_in(&mut self, [r, g, b]: [u8; 3], at: [usize; 2], text: &str) {
        let font = self.font;
        let style = MonoTextStyle::new(&font, Rgb888::new(r, g, b));
        let Ok(_) = Text::with_baseline(text, self.point(at), style, Baseline::Top).draw(self);
    }

    /// Writes lines of text at a character and a line.
    #[cfg(feature = "window")]
    pub(super) fn write_at(&mut self, ink: [u8; 3], [character, line]: [usize; 2], text: &str) {
        let [width, height] = size_of(&self.font);
        self.write_in(ink, [character * width, line * height], text);
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

    /// Is a picture of a size large enough for all of it?
    pub fn fits(&self, [width, height]: [usize; 2]) -> bool {
        self.width <= width && self.height() <= height
    }

    /// Covers row `y` of a picture of pixels 0x00RRGGBB, in its corner, as large as is easy to read.
    pub fn cover(&self, [width, height]: [usize; 2], y: usize, row: &mut [u32]) {
        let scale = (height / 600).min(width / self.width).min(height / self.height()).clamp(1, 4);
        let [right, lower] =
            [[width, self.width], [height, self.height()]].map(|[all, mine]| all.saturating_sub(mine * scale));
        let (left, above) = match self.corner {
            Corner::UpperLeft => (0, 0),
            Corner::UpperRight => (right, 0),
            Corner::LowerLeft => (0, lower),
            Corner::Below => (right / 2, lower),
            Corner::Middle => (right / 2, lower / 2),
        };
        let Some(y) = y.checked_sub(above) else { return };
        let Some(written) = self.pixels.chunks_exact(self.width).nth(y / scale) else { return };
        for (pixel, written) in
            row[left.min(width)..].iter_mut().zip(written.iter().flat_map(|pixel| std::iter::repeat_n(pixel, scale)))
        {
            let darker = |shift: u32| ((*pixel >> shift & 255) * LEFT / 256) << shift;
            *pixel = if *written == 0 { darker(16) | darker(8) | darker(0) } else { written & 0x00ff_ffff };
        }
    }
}

/// Characters of the longest line, and lines.
fn extent(text: &str) -> (usize, usize) {
    (text.lines().map(|line| line.chars().count()).max().unwrap_or(0), text.lines().count())
}

/// How many characters and lines of a font a sheet may have in a picture of a size.
#[cfg(feature = "window")]
pub(super) fn capacity(font: &MonoFont<'_>, picture: [usize; 2]) -> [usize; 2] {
    let size = size_of(font);
    [0, 1].map(|axis| picture[axis].saturating_sub(2 * MARGIN) / size[axis])
}

/// The fonts, the largest first.
#[cfg(feature = "window")]
pub(super) fn fonts() -> [MonoFont<'static>; 3] {
    FONTS
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
        // At the right end, below.
        let mut row = vec![0x00ff_ffff; 100];
        Sheet { corner: Corner::UpperRight, ..sheet.clone() }.cover([100, 60], 0, &mut row);
        let covered: Vec<usize> = (0..100).filter(|&x| row[x] != 0x00ff_ffff).collect();
        assert_eq!((covered[0], covered.len()), (28, 72));
        Sheet::of_text("").cover([20, 10], 9, &mut [0; 20]);
    }
}
