//! Subtrees that wait.

use crate::bvh::{Child, STACK};

/// A subtree that waits, and for whom.
#[derive(Clone, Copy)]
pub(super) struct Entry {
    pub(super) child: Child,
    /// Where it is entered at the earliest.
    pub(super) near: f32,
    /// The rays of a stream, or the groups of a packet, that may meet it, a bit each; or [`FewNumbers`].
    pub(super) rays: u64,
}

impl Entry {
    /// What a stack is cleared with, all zeros.
    pub(super) const NONE: Self = Self { child: Child::node(0), near: 0.0, rays: 0 };
}

/// A few rays of a packet by their numbers, in the place of its groups: bit 63 says so, three bits how many they are, and ten bits each
/// which.
#[derive(Clone, Copy)]
pub(super) struct FewNumbers(u64);

impl FewNumbers {
    /// How many rays there may be.
    pub(super) const MOST: usize = 6;
    const MARK: u64 = 1 << 63;

    /// Those of a mask, `MOST` at most.
    #[inline(always)]
    pub(super) fn of(words: &[u64]) -> u64 {
        let (mut numbers, mut count) = (0, 0);
        for (word, &lanes) in words.iter().enumerate() {
            let mut lanes = lanes;
            while lanes != 0 {
                numbers = numbers << 10 | (64 * word as u64 + u64::from(lanes.trailing_zeros()));
                lanes &= lanes - 1;
                count += 1;
            }
        }
        Self::MARK | count << 60 | numbers
    }

    /// What [`of`](Self::of) made, if the rays of an entry are that.
    #[inline(always)]
    pub(super) fn in_entry(rays: u64) -> Option<Self> {
        (rays & Self::MARK != 0).then_some(Self(rays))
    }
}

impl Iterator for FewNumbers {
    type Item = usize;

    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        let (count, numbers) = (self.0 >> 60 & 7, self.0 & ((1 << 60) - 1));
        let number = numbers & 1023;
        self.0 = count.saturating_sub(1) << 60 | numbers >> 10;
        (count > 0).then_some(number as usize)
    }
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
        self.wait(entry, sorted);
    }

    /// Adds a child that waits even if it is the nearest: its memory was asked for only now.
    #[inline(always)]
    pub(super) fn wait(&mut self, entry: Entry, sorted: bool) {
        let mut place = self.top;
        while sorted && place > self.first && self.stack[place - 1].near < entry.near {
            self.stack[place] = self.stack[place - 1];
            place -= 1;
        }
        self.stack[place] = entry;
        self.top += 1;
    }
}
