//! The progressive traverser: a coarse picture at once, refined frame by frame while nothing changes.
//!
//! Source: the progressive image traversers named in Bigler, Stephens and Parker 2006, section 5.4, as modular
//! alternatives. Departure: each pass writes its whole picture, so that it does not matter which buffer a frame has; it
//! costs a third more than rendering each pixel once.

use super::tiles::Tiles;
use super::{FragmentRenderer, ImageTraverser, TileSize};
use crate::balance::LoadBalancer;
use crate::image::Size;

/// Renders one pixel in `step` x `step`, and halves the step in each frame in which nothing changed. The last pass is
/// what [`Tiled`](super::Tiled) renders; after it the picture is kept.
#[derive(Debug)]
pub struct Progressive {
    tiles: Tiles,
    balancer: Box<dyn LoadBalancer>,
    coarsest: usize,
    /// Step of this frame. 0: the picture is finished.
    step: usize,
}

impl Progressive {
    /// The coarsest step of the default.
    pub const COARSEST: usize = 8;

    /// Begins with a step of `coarsest`, a power of two.
    ///
    /// # Panics
    /// When it is not a power of two.
    pub fn new(tile: TileSize, balancer: Box<dyn LoadBalancer>, coarsest: usize) -> Self {
        assert!(coarsest.is_power_of_two(), "the coarsest step must be a power of two, not {coarsest}");
        Self { tiles: Tiles::new(tile), balancer, coarsest, step: 0 }
    }
}

impl ImageTraverser for Progressive {
    fn name(&self) -> &'static str {
        "progressive traverser"
    }

    fn begin(&mut self, sizes: &[Size], threads: usize, changed: bool) {
        let resized = self.tiles.set_sizes(sizes);
        self.step = if changed || resized { self.coarsest } else { self.step / 2 };
        self.balancer.reset(self.tiles.count(), threads);
    }

    fn traverse(&self, thread: usize, renderer: &dyn FragmentRenderer) -> bool {
        while let Some(assignment) = self.balancer.next(thread) {
            for tile in assignment {
                if renderer.halted() {
                    return false;
                }
                let fragment = self.tiles.fragment(tile, self.step.max(1));
                if self.step > 0 || !renderer.keep(&fragment) {
                    renderer.render(&fragment);
                }
            }
        }
        self.step > 1
    }
}
