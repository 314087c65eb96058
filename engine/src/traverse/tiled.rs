//! The tiled traverser: every pixel of every frame, tile by tile.
//!
//! Source: Bigler, Stephens and Parker 2006, section 5.4.

use super::deal::Deal;
use super::{FragmentRenderer, ImageTraverser, TileSize};
use crate::balance::LoadBalancer;
use crate::image::Size;

/// Renders all tiles in each frame. A balancer that wants to know costs gets the dear tiles first, and in parts.
#[derive(Debug)]
pub struct Tiled(Deal);

impl Tiled {
    /// Tiles of a size (sides of 0 count as 1), shared by a balancer.
    pub fn new(tile: TileSize, balancer: Box<dyn LoadBalancer>) -> Self {
        Self(Deal::new(tile, balancer))
    }
}

impl ImageTraverser for Tiled {
    fn name(&self) -> &'static str {
        "tiled traverser"
    }

    fn begin(&mut self, sizes: &[Size], threads: usize, _: bool) {
        self.0.begin(sizes, threads);
    }

    fn traverse(&self, thread: usize, renderer: &dyn FragmentRenderer) -> bool {
        self.0.render(thread, renderer);
        false
    }
}
