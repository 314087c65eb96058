//! Subtrees that wait.

use crate::bvh::{Child, STACK};

/// A subtree that waits, and for whom.
#[derive(Clone, Copy)]
pub(super) struct Entry {
    pub(super) child: Child,
    /// Where it is entered at the earliest.
    pub(super) near: f32,
    /// The groups of a packet, or the rays of a word of it, that may meet it, a bit each; or one of the [`RaySets`].
    pub(super) rays: u64,
}

impl Entry {
    /// What a stack is cleared with, all zeros.
    pub(super) const NONE: Self = Self { child: Child::node(0), near: 0.0, rays: 0 };
}

/// Rays of a packet, a bit each.
pub(super) type RaySet = [u64; 4];

/// Rays of a packet that wait without their groups: sets of them, to which entries point.
#[derive(Clone, Copy)]
pub(super) struct RaySets {
    sets: [RaySet; Self::MOST],
    /// A bit a set that is in use.
    used: u32,
}

impl RaySets {
    /// How many may wait at once.
    const MOST: usize = 16;
    /// Marks rays of an entry that are the number of a set.
    const MARK: u64 = 1 << 63;

    /// No set is in use.
    pub(super) const NONE: Self = Self { sets: [[0; 4]; Self::MOST], used: 0 };

    /// Keeps a set, a bit a ray; what is to be the rays of the entry. `None` if too many wait, and of packets of more than 256 rays.
    #[inline(always)]
    pub(super) fn add(&mut self, rays: &[u64]) -> Option<u64> {
        let number = self.used.trailing_ones() as usize;
        self.sets.get_mut(number)?.get_mut(..rays.len())?.copy_from_slice(rays);
        self.used |= 1 << number;
        Some(Self::MARK | number as u64)
    }

    /// The set that the rays of an entry point to, if they do; it is kept no longer.
    #[inline(always)]
    pub(super) fn take(&mut self, rays: u64) -> Option<RaySet> {
        if rays & Self::MARK == 0 {
            return None;
        }
        let number = rays as usize % Self::MOST;
        self.used &= !(1 << number);
        Some(self.sets[number])
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
