//! The tiled traverser: every pixel of every frame, tile by tile.
//!
//! Source: Bigler, Stephens and Parker 2006, section 5.4.

use super::tiles::Tiles;
use super::{FragmentRenderer, ImageTraverser, TileSize};
use crate::balance::LoadBalancer;
use crate::image::Size;

/// Renders all tiles in each frame.
#[derive(Debug)]
pub struct Tiled {
    tiles: Tiles,
    balancer: Box<dyn LoadBalancer>,
}

impl Tiled {
    /// Tiles of a size (sides of 0 count as 1), shared by a balancer.
    pub fn new(tile: TileSize, balancer: Box<dyn LoadBalancer>) -> Self {
        Self { tiles: Tiles::new(tile), balancer }
    }
}

impl ImageTraverser for Tiled {
    fn name(&self) -> &'static str {
        "tiled traverser"
    }

    fn begin(&mut self, sizes: &[Size], threads: usize, _: bool) {
        self.tiles.set_sizes(sizes);
        self.balancer.reset(self.tiles.count(), threads);
    }

    fn traverse(&self, thread: usize, renderer: &dyn FragmentRenderer) -> bool {
        while let Some(assignment) = self.balancer.next(thread) {
            for tile in assignment {
                if renderer.halted() {
                    return false;
                }
                renderer.render(&self.tiles.fragment(tile, 1));
            }
        }
        false
    }
}
