//! What the parts of tiles cost in earlier frames, and in which parts, in which order, to render them next.
//!
//! Source: frame-to-frame coherence of costs, as load balancers of interactive ray tracers have used it since Parker et
//! al. 1999. A tile is rendered whole, or in quarters, or in quarters of quarters, by what it costs beside a thread's share
//! of the frame: on two threads hardly any is cut, on 512 most are. What is dear comes first; what is cheap keeps its place,
//! since neighbours share what they meet.

use std::sync::atomic::{AtomicU32, Ordering};

use crate::pipeline::fault;

/// A part of a tile: the tile's number times 32, plus [`WHOLE`], one of four quarters from 1 on, or one of 16 sixteenths
/// from 5 on, four of each quarter after the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Part(u32);

const WHOLE: u32 = 0;
const QUARTERS: u32 = 1;
const SIXTEENTHS: u32 = 5;
const PARTS: usize = 21;

/// A tile is cut when it costs more than this part of a thread's share, a quarter when it costs more than that: packets of
/// few rays cost more a ray.
const CUT: [f32; 2] = [1.0 / 16.0, 1.0 / 3.0];

/// Classes of cost, each half of the one before; the last one is everything below a thread's share over `2^CLASSES`.
const CLASSES: usize = 9;

/// What each part of each tile cost when it was last rendered; NaN: it was last rendered in smaller parts.
// Relaxed throughout: each is written by one thread a frame, and whoever reads an older one plans a little worse.
#[derive(Debug, Default)]
pub(super) struct TileCosts {
    tiles: Vec<[AtomicU32; PARTS]>,
    /// How often a tile can be cut in four: 0 to 2.
    cuts: u32,
}

/// Parts in the order in which they are to be rendered, and what each is expected to cost.
#[derive(Debug, Default)]
pub(super) struct Order {
    pub(super) parts: Vec<Part>,
    pub(super) costs: Vec<f32>,
    // What is sorted, kept so that planning allocates nothing.
    unsorted: Vec<(Part, f32)>,
}

impl Part {
    pub(super) fn tile(self) -> usize {
        self.0 as usize / 32
    }

    /// In how many columns and rows of such parts the tile is cut, and which of them this one is.
    pub(super) fn place(self) -> (usize, [usize; 2]) {
        let quarter = |n: u32| [n as usize % 2, n as usize / 2];
        match self.0 % 32 {
            WHOLE => (1, [0, 0]),
            part @ QUARTERS..SIXTEENTHS => (2, quarter(part - QUARTERS)),
            part => {
                let ([x, y], [inner_x, inner_y]) = (quarter((part - SIXTEENTHS) / 4), quarter((part - SIXTEENTHS) % 4));
                (4, [2 * x + inner_x, 2 * y + inner_y])
            }
        }
    }
}

impl TileCosts {
    /// For so many tiles that can be cut so often. Each is taken to cost the same.
    pub(super) fn new(tiles: usize, cuts: u32) -> Self {
        let unknown = |_| std::array::from_fn(|_| AtomicU32::new(1.0_f32.to_bits()));
        Self { tiles: each_tile(tiles, unknown), cuts: cuts.min(2) }
    }

    /// Notes what a part has cost, in any unit.
    pub(super) fn note(&self, part: Part, cost: f32) {
        let tile = &self.tiles[part.tile()];
        let set = |part: u32, cost: f32| tile[part as usize].store(cost.to_bits(), Ordering::Relaxed);
        let part = part.0 % 32;
        set(part, cost);
        if part >= SIXTEENTHS {
            set(QUARTERS + (part - SIXTEENTHS) / 4, f32::NAN);
        }
        if part != WHOLE {
            set(WHOLE, f32::NAN);
        }
    }

    fn get(&self, tile: usize, part: u32) -> f32 {
        f32::from_bits(self.tiles[tile][part as usize].load(Ordering::Relaxed))
    }

    /// The cost of a part, or of those that it was last rendered in.
    fn cost(&self, tile: usize, part: u32) -> f32 {
        let cost = self.get(tile, part);
        if cost.is_nan() && part < SIXTEENTHS { smaller(part).map(|part| self.cost(tile, part)).sum() } else { cost }
    }

    /// Plans a frame for so many threads.
    pub(super) fn plan(&self, threads: usize, order: &mut Order) {
        let total: f32 = (0..self.tiles.len()).map(|tile| self.cost(tile, WHOLE)).sum();
        // One thread shares with nobody: nothing is cut or moved.
        let share = if threads == 1 { f32::INFINITY } else { total / threads as f32 };
        order.unsorted.clear();
        for tile in 0..self.tiles.len() {
            self.add(tile, WHOLE, self.cost(tile, WHOLE), true, share, &mut order.unsorted);
        }
        // A counting sort by class, which leaves each class in the order of its tiles.
        let class = |cost: f32| ((share / cost.max(f32::MIN_POSITIVE)).log2().max(0.0) as usize).min(CLASSES - 1);
        let mut starts = [0; CLASSES];
        order.unsorted.iter().for_each(|&(_, cost)| starts[class(cost)] += 1);
        let mut start = 0;
        for place in &mut starts {
            start += std::mem::replace(place, start);
        }
        order.parts.resize(start, Part(0));
        order.costs.resize(start, 0.0);
        for &(part, cost) in &order.unsorted {
            let place = &mut starts[class(cost)];
            (order.parts[*place], order.costs[*place]) = (part, cost);
            *place += 1;
        }
    }

    /// Adds a part, or what it is cut into. Where `known` is false, `cost` is a guess that is better than what is noted.
    fn add(&self, tile: usize, part: u32, cost: f32, known: bool, share: f32, parts: &mut Vec<(Part, f32)>) {
        let cuts = u32::from(part >= QUARTERS) + u32::from(part >= SIXTEENTHS);
        if cuts >= self.cuts || cost <= CUT[cuts as usize] * share {
            return parts.push((Part(tile as u32 * 32 + part), cost));
        }
        // What was rendered whole the last time is taken to cost the same everywhere.
        let known = known && self.get(tile, part).is_nan();
        for part in smaller(part) {
            let cost = if known { self.cost(tile, part) } else { cost / 4.0 };
            self.add(tile, part, cost, known, share, parts);
        }
    }
}

/// Something for each of so many tiles. Ends the run where there is no memory for it.
pub(super) fn each_tile<T>(tiles: usize, make: impl Fn(usize) -> T) -> Vec<T> {
    let mut list = Vec::new();
    if list.try_reserve_exact(tiles).is_err() {
        fault::fail(format_args!("there is no memory for a picture of {tiles} tiles"));
    }
    list.extend((0..tiles).map(make));
    list
}

/// The four that a part is cut into.
fn smaller(part: u32) -> std::ops::Range<u32> {
    let first = if part == WHOLE { QUARTERS } else { SIXTEENTHS + 4 * (part - QUARTERS) };
    first..first + 4
}
