//! The dynamically balanced stage that renders pictures with an image traverser.
//!
//! Source: Bigler, Stephens and Parker 2006, sections 5.2 and 5.4.

use super::{Fragment, FragmentRenderer, ImageTraverser};
use crate::image::FrameBuffer;
use crate::pipeline::fault::scope;
use crate::pipeline::{Balance, Frame, Plan, Stage};

/// A stage that renders with a traverser of its own and a function for fragments.
///
/// A program that exchanges its traverser by transaction keeps it in the state, and writes its own [`Stage`] around
/// [`traverse_frame`].
pub struct RenderStage<F> {
    traverser: Box<dyn ImageTraverser>,
    render: F,
}

impl<F> RenderStage<F> {
    /// `render` gets the frame, the fragment, and the buffer that it goes to.
    pub fn new<S>(traverser: Box<dyn ImageTraverser>, render: F) -> Self
    where
        F: Fn(&Frame<'_, S>, &Fragment, &FrameBuffer) + Send + Sync,
    {
        Self { traverser, render }
    }
}

impl<S, F> Stage<S> for RenderStage<F>
where
    F: Fn(&Frame<'_, S>, &Fragment, &FrameBuffer) + Send + Sync,
{
    fn name(&self) -> &str {
        "render"
    }

    fn balance(&self) -> Balance {
        Balance::Dynamic
    }

    fn begin(&mut self, _: &mut S, plan: &Plan<'_>) {
        scope(self.traverser.name(), || self.traverser.begin(plan.sizes, plan.threads, plan.changed));
    }

    fn run(&self, frame: &Frame<'_, S>) {
        traverse_frame(frame, &*self.traverser, &self.render);
    }
}

impl<F> std::fmt::Debug for RenderStage<F> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("RenderStage").field("traverser", &self.traverser.name()).finish_non_exhaustive()
    }
}

/// One thread's part of a frame: traverses its channels, and asks for another frame if that would refine this one. Returns whether it would.
pub fn traverse_frame<S>(
    frame: &Frame<'_, S>,
    traverser: &dyn ImageTraverser,
    render: &dyn Fn(&Frame<'_, S>, &Fragment, &FrameBuffer),
) -> bool {
    let more = scope(traverser.name(), || traverser.traverse(frame.thread, &Fragments { frame, render }));
    if more {
        frame.request_frame();
    }
    more
}

struct Fragments<'a, 'f, S> {
    frame: &'a Frame<'f, S>,
    render: &'a dyn Fn(&Frame<'_, S>, &Fragment, &FrameBuffer),
}

impl<S> FragmentRenderer for Fragments<'_, '_, S> {
    fn render(&self, fragment: &Fragment) {
        // The traverser numbers the channels that take part; what renders knows them by their own index.
        let view = &self.frame.channels()[fragment.channel];
        (self.render)(self.frame, &Fragment { channel: view.index, ..*fragment }, view.buffer);
    }

    fn keep(&self, &Fragment { channel, x0, y0, x1, y1, .. }: &Fragment) -> bool {
        let view = &self.frame.channels()[channel];
        let Some(previous) = view.previous else { return false };
        if !std::ptr::eq(previous, view.buffer) {
            view.buffer.copy_from(previous, x0, y0, x1, y1);
        }
        true
    }

    fn halted(&self) -> bool {
        self.frame.halted()
    }
}
