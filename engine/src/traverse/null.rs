//! The null traverser: renders nothing, for measuring what the pipeline itself costs.

use super::{FragmentRenderer, ImageTraverser};
use crate::image::Size;

/// Hands out no fragment at all.
#[derive(Clone, Copy, Debug, Default)]
pub struct NullTraverser;

impl ImageTraverser for NullTraverser {
    fn name(&self) -> &'static str {
        "null traverser"
    }

    fn begin(&mut self, _: &[Size], _: usize, _: bool) {}

    fn traverse(&self, _: usize, _: &dyn FragmentRenderer) -> bool {
        false
    }
}
