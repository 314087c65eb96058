//! What the parts of tiles cost in earlier frames, and in which parts, in which order, to render them next.
//!
//! Source: frame-to-frame coherence of costs, as load balancers of interactive ray tracers have used it since Parker et
//! al. 1999. What is dear comes first; what is cheap keeps its place, since neighbours share what they meet. A part of a tile costs more
//! a ray than the whole, as its packets have fewer rays: so a tile is cut in quarters, and they in quarters, only where it could end after
//! all others. What still remains to be done for each thread when it is begun says that (guided self-scheduling, Polychronopoulos and Kuck
//! 1987, over costs): on two threads nothing is cut, on 512 what is dearest, and the last of the others.

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

/// A part is cut when it costs more than this fraction of what is left for each thread when it is begun, itself among it.
const OF_REST: f32 = 0.6;

/// No part is cut that costs less than this fraction of a thread's share of the frame.
const OF_SHARE: f32 = 1.0 / 16.0;

/// So many times what a part costs its quarters do together, where that is not known.
const QUARTERED: f32 = 1.1;

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
    // What is still to be ordered, kept so that planning allocates nothing.
    classes: [Vec<(Part, f32)>; CLASSES],
}

impl Part {
    const fn whole(tile: usize) -> Self {
        Self(tile as u32 * 32)
    }

    pub(super) const fn tile(self) -> usize {
        self.0 as usize / 32
    }

    /// How often the tile was cut for it.
    const fn cuts(self) -> u32 {
        match self.0 % 32 {
            WHOLE => 0,
            QUARTERS..SIXTEENTHS => 1,
            _ => 2,
        }
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

    /// The four that it is cut into.
    fn quarters(self) -> [Self; 4] {
        let (tile, part) = (self.0 / 32 * 32, self.0 % 32);
        let first = if part == WHOLE { QUARTERS } else { SIXTEENTHS + 4 * (part - QUARTERS) };
        [0, 1, 2, 3].map(|n| Self(tile + first + n))
    }
}

impl TileCosts {
    /// For so many tiles that can be cut so often. Each is taken to cost the same.
    pub(super) fn new(tiles: usize, cuts: u32) -> Self {
        let unknown = |_| std::array::from_fn(|_| AtomicU32::new(1.0_f32.to_bits()));
        Self { tiles: each_tile(tiles, unknown), cuts: cuts.min(2) }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.tiles.is_empty()
    }

    /// Notes what a part has cost, in any unit.
    pub(super) fn note(&self, part: Part, cost: f32) {
        self.set(part, cost);
        let (tile, place) = (part.0 / 32 * 32, part.0 % 32);
        if place >= SIXTEENTHS {
            self.set(Part(tile + QUARTERS + (place - SIXTEENTHS) / 4), f32::NAN);
        }
        if place != WHOLE {
            self.set(Part(tile + WHOLE), f32::NAN);
        }
    }

    fn set(&self, part: Part, cost: f32) {
        self.tiles[part.tile()][part.0 as usize % 32].store(cost.to_bits(), Ordering::Relaxed);
    }

    /// The cost of a part, or of those that it was last rendered in.
    fn cost(&self, part: Part) -> f32 {
        let cost = f32::from_bits(self.tiles[part.tile()][part.0 as usize % 32].load(Ordering::Relaxed));
        if cost.is_nan() && part.cuts() < 2 { part.quarters().map(|part| self.cost(part)).iter().sum() } else { cost }
    }

    /// Plans a frame for so many threads.
    pub(super) fn plan(&self, threads: usize, order: &mut Order) {
        let whole = || (0..self.tiles.len()).map(|tile| (Part::whole(tile), self.cost(Part::whole(tile))));
        let mut left: f32 = whole().map(|(_, cost)| cost).sum();
        // One thread shares with nobody: nothing is cut or moved.
        let share = if threads == 1 { f32::INFINITY } else { left / threads as f32 };
        // The exponent of a float is its logarithm, rounded down.
        let halvings = |cost: f32| ((share / cost.max(f32::MIN_POSITIVE)).to_bits() >> 23).saturating_sub(127) as usize;
        let class = |cost: f32| halvings(cost).min(CLASSES - 1);
        let Order { parts, costs, classes } = order;
        parts.clear();
        costs.clear();
        classes.iter_mut().for_each(Vec::clear);
        whole().for_each(|piece| classes[class(piece.1)].push(piece));
        for now in 0..CLASSES {
            let mut next = 0;
            while let Some(&(part, cost)) = classes[now].get(next) {
                next += 1;
                let most = (OF_REST * left / threads as f32).max(OF_SHARE * share);
                if cost <= most || part.cuts() == self.cuts {
                    parts.push(part);
                    costs.push(cost);
                    left -= cost;
                    continue;
                }
                // As dear beside each other as they were the last time that they were rendered.
                let quarters = part.quarters().map(|quarter| (quarter, self.cost(quarter)));
                let sum: f32 = quarters.iter().map(|(_, cost)| cost).sum();
                for (quarter, of_sum) in quarters {
                    let cost = cost * QUARTERED * of_sum / sum;
                    // The next frame may be planned when only some of them have been rendered.
                    self.set(quarter, cost);
                    classes[class(cost).max(now)].push((quarter, cost));
                }
                left += cost * (QUARTERED - 1.0);
            }
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
