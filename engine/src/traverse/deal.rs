//! Tiles dealt to threads through a load balancer, cut and ordered by what they cost if the balancer wants to know.
//!
//! The order of a frame is planned during the frame before it, by one thread before it begins to render, from what the
//! tiles cost in the frames before that: nobody waits for it at the barrier.

use std::ops::Range;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use super::costs::{Order, TileCosts};
use super::tiles::Tiles;
use super::{Fragment, FragmentRenderer, TileSize};
use crate::balance::LoadBalancer;
use crate::image::Size;

/// No part of a tile has shorter sides.
const LEAST_SIDE: usize = 4;

/// Who renders which part of the pictures of a frame.
#[derive(Debug)]
pub(crate) struct Deal {
    tiles: Tiles,
    threads: usize,
    costs: TileCosts,
    frame: Plan,
    /// The next frame's, when somebody has made it.
    next: Mutex<Plan>,
}

#[derive(Debug)]
struct Plan {
    balancer: Box<dyn LoadBalancer>,
    order: Order,
    made: bool,
}

impl Deal {
    pub(crate) fn new(tile: TileSize, balancer: Box<dyn LoadBalancer>) -> Self {
        let plan = |balancer| Plan { balancer, order: Order::default(), made: false };
        let next = Mutex::new(plan(balancer.another()));
        Self { tiles: Tiles::new(tile), threads: 0, costs: TileCosts::default(), frame: plan(balancer), next }
    }

    /// At the barrier: makes ready for a frame.
    pub(crate) fn begin(&mut self, sizes: &[Size], threads: usize) {
        let resized = self.tiles.set_sizes(sizes);
        let changed = resized || threads != self.threads;
        self.threads = threads;
        if resized {
            self.costs = TileCosts::default();
        }
        if !self.frame.balancer.wants_costs(threads) {
            self.frame.order = Order::default();
            return self.frame.balancer.reset(self.tiles.count(), threads);
        }
        if self.costs.is_empty() {
            self.costs = TileCosts::new(self.tiles.count(), self.tiles.cuts(LEAST_SIDE));
        }
        let next = self.next.get_mut().unwrap_or_else(PoisonError::into_inner);
        if changed || !next.made {
            next.make(&self.costs, threads);
        }
        next.made = false;
        std::mem::swap(&mut self.frame, next);
    }

    /// During the frame, before a thread takes anything: the last thread plans the next frame. Returns whether it did.
    pub(crate) fn plan(&self, thread: usize) -> bool {
        let mine = thread + 1 == self.threads && self.frame.balancer.wants_costs(self.threads);
        if mine {
            self.next.lock().unwrap_or_else(PoisonError::into_inner).make(&self.costs, self.threads);
        }
        mine
    }

    /// See [`LoadBalancer::next_touching`]: numbers for [`fragment`](Self::fragment).
    pub(crate) fn next(&self, thread: usize, touched: &mut dyn FnMut(usize)) -> Option<Range<usize>> {
        self.frame.balancer.next_touching(thread, touched)
    }

    pub(crate) fn fragment(&self, item: usize) -> Option<Fragment> {
        match self.frame.order.parts.get(item) {
            Some(&part) => self.tiles.part(part),
            None => Some(self.tiles.fragment(item, 1)),
        }
    }

    /// All tiles, uncut.
    pub(crate) fn whole_tiles(&self) -> impl Iterator<Item = Fragment> {
        (0..self.tiles.count()).map(|tile| self.tiles.fragment(tile, 1))
    }

    /// Notes what an item has cost.
    pub(crate) fn note(&self, item: usize, seconds: f32) {
        if let Some(&part) = self.frame.order.parts.get(item) {
            self.costs.note(part, seconds);
        }
    }

    /// A thread's part of the frame.
    pub(crate) fn render(&self, thread: usize, renderer: &dyn FragmentRenderer) {
        self.plan(thread);
        let timed = self.frame.balancer.wants_costs(self.threads);
        let mut start = Instant::now();
        while let Some(items) = self.next(thread, &mut |_| ()) {
            for item in items {
                if renderer.halted() {
                    return;
                }
                if let Some(fragment) = self.fragment(item) {
                    renderer.render(&fragment);
                }
                if timed {
                    let now = Instant::now();
                    self.note(item, (now - start).as_secs_f32());
                    start = now;
                }
            }
        }
    }
}

impl Plan {
    fn make(&mut self, costs: &TileCosts, threads: usize) {
        costs.plan(threads, &mut self.order);
        self.balancer.reset_with_costs(&self.order.costs, threads);
        self.made = true;
    }
}
