//! Rays in a brick that a surface passes through: packets and streams cell by cell, a ray a lane; a single ray row by row, a cell a
//! lane.

use core::ops::Range;

use mobula_simd::{F32Lanes, I32Lanes, MaskLanes, Task, Token};

use super::brick::{ALL_ROWS, Brick, CELLS};
use super::cells::Cells;
use super::iso::IsoTree;
use crate::Rays;
use crate::kernel::cell_walk::{CellWalk, RayLanes};
use crate::kernel::few::FewRays;
use crate::kernel::frusta::Frusta;
use crate::kernel::groups::{GROUPS, group_size};
use crate::kernel::iso_cell::{FieldAlong, field_along, iso_cell};
use crate::kernel::words::{part, word_size};
use crate::leaf::Leaf;
use crate::sink::{SingleHit, Sink};
use crate::vector::load3;

/// The cells of a brick.
#[derive(Clone, Copy)]
struct Place {
    /// Its place among bricks.
    at: [usize; 3],
    /// Its first cell along each axis, and how many there are.
    first: [usize; 3],
    cells: [usize; 3],
}

impl IsoTree<'_> {
    #[inline(always)]
    fn place(&self, leaf: Range<usize>) -> Option<Place> {
        let layout = self.layout();
        let at = layout.brick(leaf.start)?;
        let (mut first, mut cells) = ([0; 3], [0; 3]);
        for axis in 0..3 {
            first[axis] = at[axis] * CELLS[axis];
            cells[axis] = CELLS[axis].min(layout.cells(axis) - first[axis]);
        }
        Some(Place { at, first, cells })
    }
}

/// The rays from `at`, in lanes.
#[inline(always)]
fn lanes<T: Token, const N: usize>(token: T, rays: &Rays<N>, at: usize) -> RayLanes<T> {
    RayLanes {
        origin: load3(token, rays.origins(), at),
        direction: load3(token, rays.directions(), at),
        inverse: load3(token, rays.inverse_columns(), at),
        t_min: token.load(&rays.t_min()[..], at),
    }
}

/// Takes the rays `among` from `at` through the cells of a brick that the surface passes through, until they have found enough. Says
/// whether the interval of any changed.
#[expect(clippy::too_many_arguments, reason = "a brick, rays, and what becomes of hits")]
#[inline(always)]
fn through<T: Token, const N: usize, S: Sink<N>>(
    token: T,
    place: &Place,
    cells: &Cells,
    rays: &mut Rays<N>,
    at: usize,
    among: T::Mask,
    sink: &mut S,
    (id, value): (usize, f32),
) -> bool {
    let id = id as u32;
    let ray = lanes(token, rays, at);
    let mut walk = CellWalk::new(token, &ray, among, token.load(&rays.t_max[..], at), place.first, place.cells);
    let mut changed = false;
    let (mut found, mut sure) = (FieldAlong::none(token), token.mask(0));
    let (on, wait) = (token.splat(f32::INFINITY), token.splat(f32::NEG_INFINITY));
    while walk.inside.any() {
        // Each on to a cell to test: then all at once.
        let mut arrived = token.is_member(&cells.passed, walk.cell);
        while walk.inside.and_not(arrived).any() {
            walk.advance(&ray, wait.select(arrived, on));
            arrived = token.is_member(&cells.passed, walk.cell);
        }
        if !walk.inside.any() {
            break;
        }
        let corners = cells.corners(token, walk.cell, token.splat(value));
        let t_max = token.load(&rays.t_max[..], at);
        let (may, along) = field_along(token, walk.inside, &corners, walk.low(), &ray, t_max);
        if S::ANY && !sink.wants_all() {
            let (hit, t) = along.first_root::<true>(token, may, ray.t_min, t_max);
            if hit.any() {
                changed |= sink.record(token, rays, at, hit, t, id);
                walk.inside = walk.inside.and_not(hit);
            }
        } else {
            let mut may = may;
            if !S::ANY {
                // Where they hit is worked out for all at once, later.
                found.set(may.surely, &along);
                sure = sure | may.surely;
                may.hit = may.hit.and_not(may.surely);
                walk.inside = walk.inside.and_not(may.surely);
            }
            if may.hit.any() {
                let (hit, t) = along.first_root::<false>(token, may, ray.t_min, t_max);
                if hit.any() {
                    changed |= sink.record(token, rays, at, hit, t, id);
                    if S::ANY {
                        changed |= again(token, &corners, walk.low(), ray, t, rays, at, hit, sink, id);
                    } else {
                        walk.inside = walk.inside.and_not(hit);
                    }
                }
            }
        }
        walk.advance(&ray, on);
        walk.inside = walk.inside & walk.entered.le(token.load(&rays.t_max[..], at));
    }
    if sure.any() {
        let (hit, t) = found.sure_root(token, sure, ray.t_min, token.load(&rays.t_max[..], at));
        changed |= sink.record(token, rays, at, hit, t, id);
    }
    changed
}

/// Rays that go on through the surface, which they have hit at `t`, may meet it again in a cell.
#[expect(clippy::too_many_arguments, reason = "a cell, rays, and what becomes of hits")]
#[inline(always)]
fn again<T: Token, const N: usize, S: Sink<N>>(
    token: T,
    corners: &[T::F32; 8],
    low: [T::F32; 3],
    mut ray: RayLanes<T>,
    mut t: T::F32,
    rays: &mut Rays<N>,
    at: usize,
    mut hit: T::Mask,
    sink: &mut S,
    id: u32,
) -> bool {
    let mut changed = false;
    while hit.any() {
        ray.t_min = t.select(hit, ray.t_min);
        (hit, t) = iso_cell::<T, false>(token, hit, corners, low, &ray, token.load(&rays.t_max[..], at));
        changed |= sink.record(token, rays, at, hit, t, id);
    }
    changed
}

/// A packet in a brick. A task, so that it is compiled once for all that walks do.
struct PacketInBrick<'a, 'b, const N: usize, S> {
    tree: &'a IsoTree<'b>,
    leaf: Range<usize>,
    rays: &'a mut Rays<N>,
    sink: &'a mut S,
    groups: u32,
}

impl<const N: usize, S: Sink<N>> Task for PacketInBrick<'_, '_, N, S> {
    type Output = u32;

    #[inline(always)]
    fn run<T: Token>(self, token: T) -> u32 {
        let Self { tree, leaf, rays, sink, groups } = self;
        let Some(place) = tree.place(leaf) else { return 0 };
        rays.inverse_directions(token);
        let mut brick = Brick::EMPTY;
        tree.field.load(place.at, ALL_ROWS, &mut brick);
        let size = group_size(N);
        let mut changed = 0;
        let mut cells = Cells::NONE;
        for (id, &value) in tree.values.iter().enumerate() {
            if !cells.fill(token, &brick, place.cells, value) {
                continue;
            }
            let mut left = groups;
            while left != 0 {
                let group = left.trailing_zeros() as usize % GROUPS;
                left &= left - 1;
                let mut at = group * size;
                while at < (group + 1) * size {
                    let active = rays.active(token, at);
                    let met = through(token, &place, &cells, rays, at, active, sink, (id, value));
                    changed |= u32::from(met) << group;
                    at += T::LANES;
                }
            }
        }
        changed
    }
}

/// A stream in a brick.
struct StreamInBrick<'a, 'b, const N: usize, S> {
    tree: &'a IsoTree<'b>,
    leaf: Range<usize>,
    rays: &'a mut Rays<N>,
    sink: &'a mut S,
    word: usize,
    active: u64,
}

impl<const N: usize, S: Sink<N>> Task for StreamInBrick<'_, '_, N, S> {
    type Output = ();

    #[inline(always)]
    fn run<T: Token>(self, token: T) {
        let Self { tree, leaf, rays, sink, word, active } = self;
        let Some(place) = tree.place(leaf) else { return };
        let mut brick = Brick::EMPTY;
        tree.field.load(place.at, ALL_ROWS, &mut brick);
        let mut cells = Cells::NONE;
        for (id, &value) in tree.values.iter().enumerate() {
            if !cells.fill(token, &brick, place.cells, value) {
                continue;
            }
            let mut lane = 0;
            while lane < word_size(N) {
                let (at, among) = (64 * word + lane, part::<T>(active, lane));
                if among != 0 {
                    through(token, &place, &cells, rays, at, token.mask(among), sink, (id, value));
                }
                lane += T::LANES;
            }
        }
    }
}

/// Which cells of a brick one ray meets, by rows, and the rows of samples around these.
#[inline(always)]
fn met<T: Token>(token: T, place: &Place, ray: &RayLanes<T>, t_max: T::F32) -> ([u32; 4], u32) {
    let (mut met, mut samples) = ([0; 4], 0);
    let one = token.splat(1.0);
    let mut at = 0;
    while at < place.cells[0] {
        let low = token.iota().to_f32() + token.splat((place.first[0] + at) as f32);
        let a = (low - ray.origin[0]) * ray.inverse[0];
        let b = ((low + one) - ray.origin[0]) * ray.inverse[0];
        let ends = [a.min(b).max(ray.t_min), a.max(b).min(token.splat(f32::INFINITY))];
        let sound = ray.sound() & ends[0].le(t_max) & token.first(place.cells[0] - at);
        for k in 0..place.cells[2] {
            let ends = slab(token, ray, 2, place.first[2] + k, ends);
            for j in 0..place.cells[1] {
                let [near, far] = slab(token, ray, 1, place.first[1] + j, ends);
                let row = (sound & near.lt(far) & near.le(t_max)).bits();
                if row != 0 {
                    met[k % 4] |= row << (8 * (j % 4) + at);
                    samples |= 0b110_0011 << (j + 5 * k);
                }
            }
        }
        at += T::LANES;
    }
    (met, samples)
}

/// What is left of an interval in the slab from `k` to `k + 1`.
#[inline(always)]
fn slab<T: Token>(token: T, ray: &RayLanes<T>, axis: usize, k: usize, [near, far]: [T::F32; 2]) -> [T::F32; 2] {
    let a = (token.splat(k as f32) - ray.origin[axis]) * ray.inverse[axis];
    let b = (token.splat((k + 1) as f32) - ray.origin[axis]) * ray.inverse[axis];
    [a.min(b).max(near), a.max(b).min(far)]
}

impl Leaf for IsoTree<'_> {
    #[inline(always)]
    fn packet<T: Token, const N: usize, const COMMON_ORIGIN: bool, S: Sink<N>>(
        &self,
        token: T,
        leaf: Range<usize>,
        _frusta: &Frusta,
        rays: &mut Rays<N>,
        sink: &mut S,
        groups: u32,
    ) -> u32 {
        token.run(PacketInBrick { tree: self, leaf, rays, sink, groups })
    }

    #[inline(always)]
    fn stream<T: Token, const N: usize, S: Sink<N>>(
        &self,
        token: T,
        leaf: Range<usize>,
        rays: &mut Rays<N>,
        sink: &mut S,
        word: usize,
        active: u64,
    ) {
        token.run(StreamInBrick { tree: self, leaf, rays, sink, word, active });
    }

    #[inline(always)]
    fn single<T: Token, const ANY: bool>(
        &self,
        token: T,
        leaf: Range<usize>,
        ray: &mut FewRays<T>,
        hit: &mut SingleHit<'_>,
    ) {
        let Some(place) = self.place(leaf) else { return };
        let FewRays { origin, direction, inverse, t_min, .. } = *ray;
        let lanes = RayLanes { origin, direction, inverse, t_min };
        let (met, samples) = met(token, &place, &lanes, ray.t_max);
        if samples == 0 {
            return;
        }
        let mut brick = Brick::EMPTY;
        self.field.load(place.at, samples, &mut brick);
        for (id, &value) in self.values.iter().enumerate() {
            for row in 0..16 {
                let (j, k) = (row % 4, row / 4);
                let met = met[k] >> (8 * j) & 0xff;
                let mut at = 0;
                while at < CELLS[0] {
                    if met >> at & ((1 << T::LANES) - 1) == 0 {
                        at += T::LANES;
                        continue;
                    }
                    // Lane i is cell `at + i`.
                    let mut corners = [token.splat(0.0); 8];
                    let mut sound = token.mask(met >> at);
                    let (mut least, mut greatest) = (token.splat(f32::INFINITY), token.splat(f32::NEG_INFINITY));
                    for (corner, out) in corners.iter_mut().enumerate() {
                        let (values, start) = brick.corners(j, k, corner);
                        let here = token.load(values, start + at);
                        (least, greatest) = (here.min(least), here.max(greatest));
                        sound = sound & here.eq(here);
                        *out = here - token.splat(value);
                    }
                    let mut among = sound & least.lt(token.splat(value)) & token.splat(value).le(greatest);
                    let [x, y, z] = [place.first[0] + at, place.first[1] + j, place.first[2] + k];
                    let low =
                        [token.iota().to_f32() + token.splat(x as f32), token.splat(y as f32), token.splat(z as f32)];
                    let mut lanes = lanes;
                    while among.any() {
                        let (hits, t) = iso_cell::<T, false>(token, among, &corners, low, &lanes, ray.t_max);
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
                        (among, lanes.t_min) = (if ANY { hits } else { token.mask(0) }, t.select(hits, lanes.t_min));
                    }
                    at += T::LANES;
                }
            }
        }
    }

    #[inline(always)]
    fn prefetch(&self, leaf: Range<usize>) {
        if let Some(at) = self.layout().brick(leaf.start) {
            self.field.prefetch(at);
        }
    }
}
