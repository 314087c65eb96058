//! Surfaces of equal value as walks see them: nodes that such a surface passes through, and how rays meet it in a brick.

use core::ops::Range;

use mobula_simd::{F32Lanes, I32Lanes, MaskLanes, Task, Token};

use super::brick::{Brick, CELLS};
use super::field::Field;
use super::layout::Layout;
use crate::Rays;
use crate::bvh::{Child, Node, Tree};
use crate::kernel::boxes::Planes;
use crate::kernel::frusta::{Frusta, NodeDistances};
use crate::kernel::groups::{GROUPS, group_size};
use crate::kernel::iso_cell::iso_cell;
use crate::kernel::margin::{Frame, PAD};
use crate::kernel::single::SingleRay;
use crate::leaf::Leaf;
use crate::sink::{SingleHit, Sink};
use crate::vector::{load3, splat3};

/// The surfaces of some iso values in a field: the id of what is hit is the number of the iso value. Rays are in units of cells:
/// sample (i, j, k) is at (i, j, k).
#[derive(Clone, Copy)]
pub struct IsoTree<'a> {
    field: &'a dyn Field,
    values: &'a [f32],
}

impl<'a> IsoTree<'a> {
    /// The surfaces where the field has one of these values. What is at least as great is on one side, what is less on the other; NaN
    /// is nowhere.
    pub fn new(field: &'a dyn Field, values: &'a [f32]) -> Self {
        Self { field, values }
    }

    fn layout(&self) -> &Layout {
        self.field.layout()
    }
}

impl core::fmt::Debug for IsoTree<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("IsoTree").field("values", &self.values).finish_non_exhaustive()
    }
}

impl Tree for IsoTree<'_> {
    type Leaves = Self;

    fn leaves(&self) -> &Self {
        self
    }

    fn frame(&self) -> &Frame {
        self.layout().frame()
    }

    fn root(&self) -> Child {
        self.layout().root()
    }

    #[inline(never)]
    fn node<'a>(&'a self, index: usize, room: &'a mut Node) -> Option<&'a Node> {
        let layout = self.layout();
        let (level, at) = layout.node(index);
        let below = level.checked_sub(1)?;
        let [low, high] = self.field.ranges(below, at);
        let frame = layout.frame();
        for axis in 0..3 {
            let (size, cells) = (CELLS[axis] << below, layout.cells(axis));
            for half in 0..2 {
                let first = (2 * at[axis] + half) * size;
                let [a, b] = [first.min(cells), (first + size).min(cells)].map(|x| x as f32 - frame.center[axis]);
                let margin = a.abs().max(b.abs()) * PAD;
                for slot in (0..8).filter(|slot| slot >> axis & 1 == half) {
                    (room.planes[axis][slot], room.planes[axis + 3][slot]) = (a - margin, b + margin);
                }
            }
        }
        for slot in 0..8 {
            let passes = self.values.iter().any(|&value| low[slot] < value && value <= high[slot]);
            room.child[slot] = Child::EMPTY;
            if passes {
                room.child[slot] = layout.child(below, [0, 1, 2].map(|axis| 2 * at[axis] + (slot >> axis & 1)));
            } else {
                (room.planes[0][slot], room.planes[3][slot]) = (f32::INFINITY, f32::NEG_INFINITY);
            }
        }
        Some(room)
    }

    fn prefetch(&self, _child: Child) {}

    fn leaf(&self, i: usize) -> Option<Child> {
        self.layout().nth_brick(i)
    }
}

/// A brick with the samples that rays are tested against.
struct Loaded {
    brick: Brick,
    /// Its first cell along each axis, and how many there are.
    first: [usize; 3],
    cells: [usize; 3],
}

impl IsoTree<'_> {
    #[inline(always)]
    fn load(&self, leaf: Range<usize>) -> Option<Loaded> {
        let layout = self.layout();
        let at = layout.brick(leaf.start)?;
        let first = [0, 1, 2].map(|axis| at[axis] * CELLS[axis]);
        let cells = [0, 1, 2].map(|axis| CELLS[axis].min(layout.cells(axis) - first[axis]));
        let mut loaded = Loaded { brick: Brick::EMPTY, first, cells };
        self.field.load(at, &mut loaded.brick);
        Some(loaded)
    }
}

impl Loaded {
    /// The rows of cells that rays in a direction meet first come first.
    #[inline(always)]
    fn rows(&self, [_, y, z]: [f32; 3]) -> impl Iterator<Item = [usize; 2]> {
        let [_, height, depth] = self.cells;
        let order = |i: usize, count: usize, backward: bool| if backward { count - 1 - i } else { i };
        (0..height * depth).map(move |i| [order(i % height, height, y < 0.0), order(i / height, depth, z < 0.0)])
    }

    /// Which cells of a row the surface passes through, a bit each.
    #[inline(always)]
    fn passed<T: Token>(&self, token: T, [j, k]: [usize; 2], value: f32) -> u32 {
        let token = token.narrow();
        let value = token.splat(value);
        let mut passed = 0;
        let mut at = 0;
        while at < CELLS[0] {
            let (mut low, mut high) = (token.splat(f32::INFINITY), token.splat(f32::NEG_INFINITY));
            let mut sound = token.mask(u32::MAX);
            for corner in 0..8 {
                let (values, start) = self.brick.corners(j, k, corner);
                let here = token.load(values, start + at);
                (low, high) = (here.min(low), here.max(high));
                if !self.brick.finite {
                    sound = sound & here.eq(here);
                }
            }
            passed |= (sound & low.lt(value) & value.le(high)).bits() << at;
            at += <T::Narrow as Token>::LANES;
        }
        passed & ((1 << self.cells[0]) - 1)
    }

    /// The corners of a cell, less the iso value.
    #[inline(always)]
    fn cell<T: Token>(&self, token: T, [j, k]: [usize; 2], i: usize, value: f32) -> [T::F32; 8] {
        let mut corners = [token.splat(0.0); 8];
        for (corner, out) in corners.iter_mut().enumerate() {
            let (values, start) = self.brick.corners(j, k, corner);
            *out = token.splat(values[start + i] - value);
        }
        corners
    }

    /// The low corner of a cell.
    #[inline(always)]
    fn low(&self, [j, k]: [usize; 2], i: usize) -> [f32; 3] {
        [(self.first[0] + i) as f32, (self.first[1] + j) as f32, (self.first[2] + k) as f32]
    }

    /// Boxes around the cells of a row, in the frame, widened.
    #[inline(always)]
    fn boxes(&self, [j, k]: [usize; 2], frame: &Frame, planes: &mut Planes) {
        let rows = [None, Some(j), Some(k)];
        for axis in 0..3 {
            for i in 0..8 {
                let a = (self.first[axis] + rows[axis].unwrap_or(i)) as f32 - frame.center[axis];
                let margin = (a.abs() + 1.0) * PAD;
                (planes[axis][i], planes[axis + 3][i]) = (a - margin, a + 1.0 + margin);
            }
        }
    }
}

/// The rays from `at`, in lanes.
struct Lanes<T: Token> {
    origin: [T::F32; 3],
    direction: [T::F32; 3],
    inverse: [T::F32; 3],
    t_min: T::F32,
}

impl<T: Token> Lanes<T> {
    #[inline(always)]
    fn new<const N: usize>(token: T, rays: &Rays<N>, at: usize) -> Self {
        Self {
            origin: load3(token, rays.origins(), at),
            direction: load3(token, rays.directions(), at),
            inverse: load3(token, rays.inverse_columns(), at),
            t_min: token.load(&rays.t_min()[..], at),
        }
    }

    /// Tests the rays `among` of a packet against a cell, and records what they hit. Says whether the interval of any changed.
    #[expect(clippy::too_many_arguments, reason = "a cell, rays, and what becomes of hits")]
    #[inline(always)]
    fn meet<const N: usize, S: Sink<N>>(
        &self,
        token: T,
        corners: &[T::F32; 8],
        low: [T::F32; 3],
        rays: &mut Rays<N>,
        at: usize,
        among: T::Mask,
        sink: &mut S,
        id: u32,
    ) -> bool {
        let Self { origin, direction, inverse, mut t_min } = *self;
        let (mut among, mut changed) = (among, false);
        loop {
            let t_max = token.load(&rays.t_max[..], at);
            let (hit, t) = iso_cell(token, among, corners, low, origin, direction, inverse, t_min, t_max);
            if !hit.any() {
                return changed;
            }
            changed |= sink.record(token, rays, at, hit, t, id);
            if !S::ANY {
                return changed;
            }
            // A ray that goes on through the surface may meet it again in this cell.
            (among, t_min) = (hit, t.select(hit, t_min));
        }
    }
}

/// A packet in a brick. A task, so that it is compiled once for all that walks do.
struct PacketInBrick<'a, 'b, const N: usize, S> {
    tree: &'a IsoTree<'b>,
    leaf: Range<usize>,
    frusta: &'a Frusta,
    rays: &'a mut Rays<N>,
    sink: &'a mut S,
    groups: u32,
}

impl<const N: usize, S: Sink<N>> Task for PacketInBrick<'_, '_, N, S> {
    type Output = u32;

    #[inline(always)]
    fn run<T: Token>(self, token: T) -> u32 {
        let Self { tree, leaf, frusta, rays, sink, groups } = self;
        let Some(loaded) = tree.load(leaf) else { return 0 };
        rays.inverse_directions(token);
        let size = group_size(N);
        let (_, heading) = rays.ray(groups.trailing_zeros() as usize % GROUPS * size);
        let mut planes: Planes = [[0.0; 8]; 6];
        let mut changed = 0;
        for (id, &value) in tree.values.iter().enumerate() {
            for row in loaded.rows(heading.to_array()) {
                let mut cells = loaded.passed(token, row, value);
                if cells == 0 {
                    continue;
                }
                loaded.boxes(row, tree.frame(), &mut planes);
                let mut distances = NodeDistances::NONE;
                cells &= frusta.boxes(token, &planes, &mut distances);
                while cells != 0 {
                    // The cells of a row that rays meet first, too.
                    let i =
                        if heading.x < 0.0 { 31 - cells.leading_zeros() } else { cells.trailing_zeros() } as usize % 8;
                    cells &= !(1 << i);
                    let mut groups = groups & frusta.groups::<T, N, false>(token, &planes, i, &distances);
                    if groups == 0 {
                        continue;
                    }
                    let corners = loaded.cell(token, row, i, value);
                    let low = splat3(token, loaded.low(row, i));
                    while groups != 0 {
                        let group = groups.trailing_zeros() as usize % GROUPS;
                        groups &= groups - 1;
                        let mut at = group * size;
                        while at < (group + 1) * size {
                            let (lanes, active) = (Lanes::new(token, rays, at), rays.active(token, at));
                            let met = lanes.meet(token, &corners, low, rays, at, active, sink, id as u32);
                            changed |= u32::from(met) << group;
                            at += T::LANES;
                        }
                    }
                }
            }
        }
        changed
    }
}

/// A stream in a brick.
struct StreamInBrick<'a, 'b, const W: usize, S> {
    tree: &'a IsoTree<'b>,
    leaf: Range<usize>,
    rays: &'a mut Rays<W>,
    sink: &'a mut S,
    active: u64,
}

impl<const W: usize, S: Sink<W>> Task for StreamInBrick<'_, '_, W, S> {
    type Output = ();

    #[inline(always)]
    fn run<T: Token>(self, token: T) {
        let Self { tree, leaf, rays, sink, active } = self;
        let Some(loaded) = tree.load(leaf) else { return };
        for (id, &value) in tree.values.iter().enumerate() {
            for row in loaded.rows([1.0; 3]) {
                let mut cells = loaded.passed(token, row, value);
                while cells != 0 {
                    let i = cells.trailing_zeros() as usize % 8;
                    cells &= cells - 1;
                    let corners = loaded.cell(token, row, i, value);
                    let low = splat3(token, loaded.low(row, i));
                    let mut at = 0;
                    while at < W {
                        let among = (active >> at) as u32 & (u32::MAX >> (32 - T::LANES));
                        if among != 0 {
                            let lanes = Lanes::new(token, rays, at);
                            lanes.meet(token, &corners, low, rays, at, token.mask(among), sink, id as u32);
                        }
                        at += T::LANES;
                    }
                }
            }
        }
    }
}

impl Leaf for IsoTree<'_> {
    #[inline(always)]
    fn packet<T: Token, const N: usize, const COMMON_ORIGIN: bool, S: Sink<N>>(
        &self,
        token: T,
        leaf: Range<usize>,
        frusta: &Frusta,
        rays: &mut Rays<N>,
        sink: &mut S,
        groups: u32,
    ) -> u32 {
        token.run(PacketInBrick { tree: self, leaf, frusta, rays, sink, groups })
    }

    #[inline(always)]
    fn stream<T: Token, const W: usize, S: Sink<W>>(
        &self,
        token: T,
        leaf: Range<usize>,
        rays: &mut Rays<W>,
        sink: &mut S,
        active: u64,
    ) {
        token.run(StreamInBrick { tree: self, leaf, rays, sink, active });
    }

    #[inline(always)]
    fn single<T: Token, const ANY: bool>(
        &self,
        token: T,
        leaf: Range<usize>,
        ray: &mut SingleRay<T>,
        hit: &mut SingleHit<'_>,
    ) {
        let Some(loaded) = self.load(leaf) else { return };
        for (id, &value) in self.values.iter().enumerate() {
            for row in loaded.rows([1.0; 3]) {
                let passed = loaded.passed(token, row, value);
                let mut at = 0;
                while at < CELLS[0] {
                    let mut among = token.mask(passed >> at);
                    // Lane i is cell `at + i`.
                    let mut corners = [token.splat(0.0); 8];
                    for (corner, out) in corners.iter_mut().enumerate() {
                        let (values, start) = loaded.brick.corners(row[0], row[1], corner);
                        *out = token.load(values, start + at) - token.splat(value);
                    }
                    let [x, y, z] = loaded.low(row, at);
                    let low = [token.iota().to_f32() + token.splat(x), token.splat(y), token.splat(z)];
                    let mut t_min = ray.t_min;
                    while among.any() {
                        let SingleRay { origin, direction, inverse, t_max, .. } = *ray;
                        let (hits, t) = iso_cell(token, among, &corners, low, origin, direction, inverse, t_min, t_max);
                        let mut distances = [0.0; 16];
                        t.store(&mut distances, 0);
                        let mut left = hits.bits();
                        while left != 0 {
                            let lane = left.trailing_zeros() as usize % 16;
                            left &= left - 1;
                            if ANY {
                                if hit.any(distances[lane], id as u32) {
                                    return;
                                }
                            } else if hit.closest(distances[lane], id as u32) {
                                ray.t_max = token.splat(distances[lane]);
                            }
                        }
                        (among, t_min) = (if ANY { hits } else { token.mask(0) }, t.select(hits, t_min));
                    }
                    at += T::LANES;
                }
            }
        }
    }

    fn prefetch(&self, _leaf: Range<usize>) {}
}
