//! Tiles: the pictures of all channels cut into rectangles and numbered through.

use super::Fragment;
use super::costs::Part;
use crate::image::Size;

/// Sides of a tile in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TileSize {
    /// Columns, at least 1.
    pub width: usize,
    /// Rows, at least 1.
    pub height: usize,
}

impl Default for TileSize {
    fn default() -> Self {
        Self { width: 16, height: 16 }
    }
}

/// The tiles of the channels, row by row, channel by channel.
#[derive(Clone, Debug)]
pub(super) struct Tiles {
    tile: TileSize,
    sizes: Vec<Size>,
    /// Number of the first tile of each channel, and of the first behind the last.
    first: Vec<usize>,
}

impl Tiles {
    pub(super) fn new(tile: TileSize) -> Self {
        let tile = TileSize { width: tile.width.max(1), height: tile.height.max(1) };
        Self { tile, sizes: Vec::new(), first: vec![0] }
    }

    /// Takes new sizes. Returns whether they differ from those before.
    pub(super) fn set_sizes(&mut self, sizes: &[Size]) -> bool {
        if self.sizes == sizes {
            return false;
        }
        self.sizes = sizes.to_vec();
        self.first.clear();
        self.first.push(0);
        for size in sizes {
            let tiles = size.width().div_ceil(self.tile.width) * size.height().div_ceil(self.tile.height);
            self.first.push(self.count() + tiles);
        }
        true
    }

    pub(super) fn count(&self) -> usize {
        self.first[self.first.len() - 1]
    }

    pub(super) fn pixels(&self) -> usize {
        self.sizes.iter().map(|size| size.pixels()).sum()
    }

    /// Tile `number`, to be rendered with a step.
    pub(super) fn fragment(&self, number: usize, step: usize) -> Fragment {
        let channel = self.first.partition_point(|&first| first <= number) - 1;
        let (size, place) = (self.sizes[channel], number - self.first[channel]);
        let across = size.width().div_ceil(self.tile.width);
        let (x0, y0) = (place % across * self.tile.width, place / across * self.tile.height);
        let (x1, y1) = ((x0 + self.tile.width).min(size.width()), (y0 + self.tile.height).min(size.height()));
        Fragment { channel, x0, y0, x1, y1, step }
    }

    /// Part of a tile; none where it lies outside the picture.
    pub(super) fn part(&self, part: Part) -> Option<Fragment> {
        let tile = self.fragment(part.tile(), 1);
        let (cuts, [x, y]) = part.place();
        let (width, height) = (self.tile.width / cuts, self.tile.height / cuts);
        let (x0, y0) = (tile.x0 + x * width, tile.y0 + y * height);
        let (x1, y1) = (tile.x1.min(x0 + width), tile.y1.min(y0 + height));
        (x0 < x1 && y0 < y1).then_some(Fragment { x0, y0, x1, y1, ..tile })
    }

    /// How often a tile can be cut in four equal parts with sides of `least` or more.
    pub(super) fn cuts(&self, least: usize) -> u32 {
        let even = |side: usize, cuts: u32| side.is_multiple_of(1 << cuts) && side >> cuts >= least;
        (1..=2).rev().find(|&cuts| even(self.tile.width, cuts) && even(self.tile.height, cuts)).unwrap_or(0)
    }
}
