//! Image traversers: in which pieces, and in which order, the pictures of a frame are rendered.
//!
//! Source: Bigler, Stephens and Parker 2006, section 5.4. A traverser cuts the pictures of all channels into fragments
//! and shares them among the threads through a load balancer. It is called once per thread and frame, a fragment
//! renderer once per fragment.

mod costs;
mod deadline;
mod deal;
mod kind;
mod null;
mod progressive;
mod render_stage;
#[cfg(test)]
mod tests;
mod tiled;
mod tiles;

pub use deadline::Deadline;
pub(crate) use deal::Deal;
pub use kind::{TraverserKind, UnknownTraverser};
pub use null::NullTraverser;
pub use progressive::Progressive;
pub use render_stage::{RenderStage, traverse_frame};
pub use tiled::Tiled;
pub use tiles::TileSize;

use crate::image::Size;

/// A rectangle of one channel's picture: columns `x0..x1` of rows `y0..y1`, never empty, always inside the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Fragment {
    /// Index of the channel.
    pub channel: usize,
    /// First column.
    pub x0: usize,
    /// First row.
    pub y0: usize,
    /// First column behind it.
    pub x1: usize,
    /// First row behind it.
    pub y1: usize,
    /// 1: every pixel. Larger: sample the pixels whose column and row, counted from (x0, y0), are multiples of it, and
    /// fill the square below and to the right of each with its colour.
    pub step: usize,
}

impl Fragment {
    /// Pixels covered.
    pub fn pixels(&self) -> usize {
        (self.x1 - self.x0) * (self.y1 - self.y0)
    }

    /// Pixels that have to be sampled.
    pub fn samples(&self) -> usize {
        (self.x1 - self.x0).div_ceil(self.step) * (self.y1 - self.y0).div_ceil(self.step)
    }
}

/// Renders fragments: what a traverser calls.
pub trait FragmentRenderer {
    /// Renders a fragment into the frame's buffer.
    fn render(&self, fragment: &Fragment);

    /// Puts the previous frame's pixels in the place of a fragment that needs no rendering now. False if there is no
    /// previous frame to take them from.
    fn keep(&self, fragment: &Fragment) -> bool {
        let _ = fragment;
        false
    }

    /// Whether the frame was given up, so that going on is in vain.
    fn halted(&self) -> bool {
        false
    }
}

/// Takes the pictures of a frame apart.
pub trait ImageTraverser: Send + Sync {
    /// What it is called in errors.
    fn name(&self) -> &'static str;

    /// Called at the barrier before each frame, with the channels' sizes. `changed`: the pictures of the frame before
    /// are out of date.
    fn begin(&mut self, sizes: &[Size], threads: usize, changed: bool);

    /// Called by each thread during the frame. Returns whether a later frame, with nothing changed, would look better.
    fn traverse(&self, thread: usize, renderer: &dyn FragmentRenderer) -> bool;
}
