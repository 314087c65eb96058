//! Subtrees that wait.

use crate::bvh::{Child, STACK};

/// A subtree that waits, and for whom.
#[derive(Clone, Copy)]
pub(super) struct Entry {
    pub(super) child: Child,
    /// Where it is entered at the earliest.
    pub(super) near: f32,
    /// The rays of a stream, or the groups of a packet, that may meet it, a bit each.
    pub(super) rays: u64,
}

impl Entry {
    /// What a stack is cleared with, all zeros.
    pub(super) const NONE: Self = Self { child: Child::node(0), near: 0.0, rays: 0 };
}

/// The children of a node that are met: one to go on with, the others on a stack from `first` to `top`.
pub(super) struct Met<'a> {
    /// [`Child::EMPTY`] for nobody if there is none.
    pub(super) nearest: Entry,
    pub(super) stack: &'a mut [Entry; STACK],
    first: usize,
    pub(super) top: usize,
}

impl<'a> Met<'a> {
    #[inline(always)]
    pub(super) fn new(stack: &'a mut [Entry; STACK], top: usize) -> Self {
        let nearest = Entry { child: Child::EMPTY, near: f32::INFINITY, rays: 0 };
        Self { nearest, stack, first: top, top }
    }

    /// Adds a child. If `sorted`, the nearest is gone on with, and the farthest stays lowest; else the last is.
    #[inline(always)]
    pub(super) fn add(&mut self, mut entry: Entry, sorted: bool) {
        if self.nearest.rays == 0 {
            self.nearest = entry;
            return;
        }
        if !sorted || entry.near < self.nearest.near {
            core::mem::swap(&mut entry, &mut self.nearest);
        }
        let mut place = self.top;
        while sorted && place > self.first && self.stack[place - 1].near < entry.near {
            self.stack[place] = self.stack[place - 1];
            place -= 1;
        }
        self.stack[place] = entry;
        self.top += 1;
    }
}
