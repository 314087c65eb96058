//! The deadline traverser: as good a picture as a frame's time allows, refined while nothing changes.
//!
//! Source: the deadline-driven image traversal of the interactive systems that Bigler, Stephens and Parker 2006 build on
//! (section 4, Star-Ray; frameless rendering in the acknowledgments).
//!
//! Each tile has a level: how far it has been refined since the last change. A frame refines the tiles of the lowest
//! level by one, those first whose pixels are oldest, and keeps all others. When its time is over it keeps the rest too.
//! After a change the first level is the finest that the time should suffice for, by what samples have cost so far.

use std::cmp::Reverse;
use std::sync::atomic::{AtomicU8, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use crossbeam_utils::CachePadded;

use super::costs::each_tile;
use super::tiles::Tiles;
use super::{FragmentRenderer, ImageTraverser, TileSize};
use crate::balance::LoadBalancer;
use crate::image::Size;

/// Renders within a time limit per frame. After its first fragment a thread begins none that it does not expect to finish in
/// time, so a frame is late by no more than one fragment; and however short the time is, the picture gets finished.
#[derive(Debug)]
pub struct Deadline {
    tiles: Tiles,
    balancer: Box<dyn LoadBalancer>,
    limit: Duration,
    threads: usize,
    start: Instant,
    frame: u64,
    /// Level that this frame brings the tiles of `order` to: a step of `COARSEST >> (pass)`.
    pass: u8,
    /// The tiles to be refined, oldest first, then those that are to be kept.
    order: Vec<usize>,
    pending: usize,
    /// Passes each tile has been through since the last change.
    levels: Vec<AtomicU8>,
    /// When each tile was last rendered: number of the frame.
    rendered: Vec<AtomicU64>,
    samples: CachePadded<AtomicU64>,
    nanoseconds: CachePadded<AtomicU64>,
}

/// Steps 16, 8, 4, 2, 1.
const PASSES: u8 = 5;
const COARSEST: usize = 1 << (PASSES - 1);

impl Deadline {
    /// Renders for `limit` in each frame at most.
    pub fn new(tile: TileSize, balancer: Box<dyn LoadBalancer>, limit: Duration) -> Self {
        Self {
            tiles: Tiles::new(tile),
            balancer,
            limit,
            threads: 1,
            start: Instant::now(),
            frame: 0,
            pass: 0,
            order: Vec::new(),
            pending: 0,
            levels: Vec::new(),
            rendered: Vec::new(),
            samples: CachePadded::default(),
            nanoseconds: CachePadded::default(),
        }
    }

    /// The finest pass for which the time of a frame should suffice.
    fn first_pass(&self) -> u8 {
        let samples = self.samples.load(Ordering::Relaxed);
        if samples == 0 {
            return 0;
        }
        let cost = self.nanoseconds.load(Ordering::Relaxed) as f64 / samples as f64;
        let affordable = self.limit.as_nanos() as f64 * self.threads as f64 / cost;
        let pixels = self.tiles.pixels() as f64;
        let fits = |pass: &u8| pixels / ((COARSEST >> pass) as f64).powi(2) <= affordable;
        (0..PASSES).rev().find(fits).unwrap_or(0)
    }

    /// Forgets half of what samples cost, so that the estimate follows the scene.
    fn forget_costs(&self) {
        for total in [&self.samples, &self.nanoseconds] {
            total.store(total.load(Ordering::Relaxed) / 2, Ordering::Relaxed);
        }
    }
}

// Relaxed throughout: the barrier orders `begin` and the frames around it, and each tile has one thread per frame.
impl ImageTraverser for Deadline {
    fn name(&self) -> &'static str {
        "deadline traverser"
    }

    fn begin(&mut self, sizes: &[Size], threads: usize, changed: bool) {
        (self.start, self.threads) = (Instant::now(), threads);
        self.frame += 1;
        if self.tiles.set_sizes(sizes) {
            self.order = each_tile(self.tiles.count(), |tile| tile);
            self.levels = each_tile(self.tiles.count(), |_| AtomicU8::new(0));
            self.rendered = each_tile(self.tiles.count(), |_| AtomicU64::new(0));
        }
        if changed {
            let first = self.first_pass();
            self.levels.iter_mut().for_each(|level| *level.get_mut() = first);
            self.forget_costs();
        }
        self.pass = self.levels.iter_mut().map(|level| *level.get_mut()).min().unwrap_or(PASSES);
        self.order.clear();
        self.order.extend(0..self.tiles.count());
        let key = |&tile: &usize| {
            let pending = self.levels[tile].load(Ordering::Relaxed) == self.pass && self.pass < PASSES;
            (Reverse(pending), self.rendered[tile].load(Ordering::Relaxed))
        };
        self.pending = self.order.iter().filter(|tile| key(tile).0.0).count();
        self.order.sort_by_key(key);
        self.balancer.reset(self.order.len(), threads);
    }

    fn traverse(&self, thread: usize, renderer: &dyn FragmentRenderer) -> bool {
        let step = COARSEST >> self.pass.min(PASSES - 1);
        let (mut longest, mut in_time, mut unfinished) = (None, true, self.pass + 1 < PASSES);
        while let Some(assignment) = self.balancer.next(thread) {
            for place in assignment {
                if renderer.halted() {
                    return false;
                }
                let tile = self.order[place];
                let fragment = self.tiles.fragment(tile, step);
                let pending = place < self.pending;
                let start = Instant::now();
                in_time = in_time && longest.is_none_or(|longest| start - self.start + longest < self.limit);
                if !pending || !in_time {
                    let kept = renderer.keep(&fragment);
                    unfinished |= pending || !kept;
                    if !kept {
                        // Nothing to keep: the tile has to begin again.
                        self.levels[tile].store(0, Ordering::Relaxed);
                    }
                    continue;
                }
                renderer.render(&fragment);
                let took = start.elapsed();
                longest = longest.max(Some(took));
                self.levels[tile].store(self.pass + 1, Ordering::Relaxed);
                self.rendered[tile].store(self.frame, Ordering::Relaxed);
                self.samples.fetch_add(fragment.samples() as u64, Ordering::Relaxed);
                self.nanoseconds.fetch_add(took.as_nanos() as u64, Ordering::Relaxed);
            }
        }
        unfinished
    }
}
