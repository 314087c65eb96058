//! Blocks of four primitives of one kind, and how rays meet a leaf of them.

use alloc::vec::Vec;
use core::ops::Range;

use bytemuck::Zeroable;
use mobula_simd::{F32Lanes, MaskLanes, Token, prefetch};

use super::{Bounds, Leaf};
use crate::kernel::few::FewRays;
use crate::kernel::frusta::Frusta;
use crate::kernel::group_shears::GroupShears;
use crate::kernel::groups::{GROUPS, group_size};
use crate::kernel::words::{part, word_size};
use crate::sink::{SingleHit, Sink};
use crate::{NO_HIT, Rays};

/// Primitives in a block.
pub const BLOCK: usize = 4;
/// A bit for each.
const ALL: u32 = (1 << BLOCK) - 1;

/// Four primitives of one kind as a structure of arrays. Unused places have the id [`NO_HIT`] and come last. Zeros are what a
/// builder's memory starts as.
pub trait Block: Copy + Send + Sync + Zeroable + 'static {
    /// One primitive, as it is given.
    type Primitive: Copy;
    /// Four unused places.
    const EMPTY: Self;
    /// Are trees to be small rather than exact in their bounds? Then all blocks but the last are full, leaves have two, and nodes that
    /// can have eight children mostly do. For primitives of about one size that fill space.
    const COMPACT: bool = false;
    /// What no ray hits.
    const NOWHERE: Self::Primitive;
    /// Four primitives with all that is the same for every ray of a packet worked out.
    type Prepared: Copy;

    /// The bounds of a primitive, all of it: what is rounded here is rounded [outwards](Bounds::outward). `None` if it is not finite or degenerate, and so left out.
    fn bounds(primitive: &Self::Primitive) -> Option<Bounds>;

    /// Puts a primitive at a place.
    fn set(&mut self, place: usize, id: u32, primitive: &Self::Primitive);

    /// The bounds of all its primitives; unused places and what is [`NOWHERE`](Self::NOWHERE) have none.
    fn whole(&self) -> Bounds;

    /// The primitives' ids; `number` is which block it is.
    fn ids(&self, number: usize) -> [u32; BLOCK];

    /// Prepares the block for a packet: with a `COMMON_ORIGIN` relative to it.
    fn prepare<const N: usize, const COMMON_ORIGIN: bool>(&self, rays: &Rays<N>) -> Self::Prepared;

    /// By which groups each primitive may be hit, for rays with a common origin or direction and the dominant axis `axis`, a bit a
    /// group. Never leaves out a hit; unused places do not matter.
    #[inline(always)]
    fn touched<T: Token, const N: usize>(
        _token: T,
        _prepared: &Self::Prepared,
        _axis: usize,
        _shears: &GroupShears,
    ) -> [u32; BLOCK] {
        [u32::MAX; BLOCK]
    }

    /// Tests primitive `i` of a prepared block against the rays from `at` in the lanes `among`: which hit within their intervals,
    /// and where. All directions have the dominant axis `axis`, unless the rays have their `OWN_AXES`.
    fn test<T: Token, const N: usize, const COMMON_ORIGIN: bool, const OWN_AXES: bool>(
        token: T,
        prepared: &Self::Prepared,
        i: usize,
        axis: usize,
        rays: &Rays<N>,
        at: usize,
        among: T::Mask,
    ) -> (T::Mask, T::F32);

    /// Tests all four against a few rays: lane 4 k + i is primitive i, for ray k. With one lane, `i` is which primitive; otherwise it
    /// is 0.
    fn test_few<T: Token>(&self, token: T, rays: &FewRays<T>, i: usize) -> (T::Mask, T::F32);
}

/// Leaves of blocks, and which of their primitives there are.
pub trait Blocks: Send + Sync {
    /// What they are.
    type Block: Block;

    /// All of them.
    fn blocks(&self) -> &[Self::Block];

    /// Which primitives of a block rays can hit, a bit each.
    #[inline(always)]
    fn shown(&self, _block: usize) -> u32 {
        u32::MAX
    }
}

impl<B: Block> Blocks for Vec<B> {
    type Block = B;

    #[inline(always)]
    fn blocks(&self) -> &[B] {
        self
    }
}

impl<L: Blocks> Leaf for L {
    const TESTS_FEW: bool = true;

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
        let size = group_size(N);
        let axis = frusta.axis();
        let Some(blocks) = self.blocks().get(leaf.clone()) else { return 0 };
        let all = token.mask(u32::MAX);
        let mut changed = 0;
        for (block, number) in blocks.iter().zip(leaf) {
            let shown = self.shown(number);
            if shown & ALL == 0 {
                continue;
            }
            let prepared = block.prepare::<N, COMMON_ORIGIN>(rays);
            // A group that is one vector is tested in less time than bounded.
            let touched = match frusta.shears() {
                Some(shears) if size > T::LANES || !groups.is_power_of_two() => {
                    L::Block::touched::<T, N>(token, &prepared, axis, shears)
                }
                _ => [u32::MAX; BLOCK],
            };
            for (i, id) in block.ids(number).into_iter().enumerate() {
                let mut groups = touched[i] & groups;
                if id == NO_HIT {
                    break;
                }
                if shown >> i & 1 == 0 {
                    continue;
                }
                while groups != 0 {
                    let group = groups.trailing_zeros() as usize % GROUPS;
                    groups &= groups - 1;
                    let mut at = group * size;
                    while at < (group + 1) * size {
                        let (hit, t) =
                            L::Block::test::<T, N, COMMON_ORIGIN, false>(token, &prepared, i, axis, rays, at, all);
                        // In a wide vector a hit is as likely as none: a branch would be guessed wrong.
                        if T::LANES >= 8 || hit.any() {
                            changed |= u32::from(sink.record(token, rays, at, hit, t, id)) << group;
                        }
                        at += T::LANES;
                    }
                }
            }
        }
        changed
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
        let Some(blocks) = self.blocks().get(leaf.clone()) else { return };
        for (block, number) in blocks.iter().zip(leaf) {
            let shown = self.shown(number);
            if shown & ALL == 0 {
                continue;
            }
            let prepared = block.prepare::<N, false>(rays);
            for (i, id) in block.ids(number).into_iter().enumerate() {
                if id == NO_HIT {
                    break;
                }
                if shown >> i & 1 == 0 {
                    continue;
                }
                let mut lane = 0;
                while lane < word_size(N) {
                    let (at, among) = (64 * word + lane, part::<T>(active, lane));
                    if among != 0 {
                        let among = token.mask(among);
                        let (hit, t) = L::Block::test::<T, N, false, true>(token, &prepared, i, 0, rays, at, among);
                        if hit.any() {
                            sink.record(token, rays, at, hit, t, id);
                        }
                    }
                    lane += T::LANES;
                }
            }
        }
    }

    #[inline(always)]
    fn single<T: Token, const ANY: bool>(
        &self,
        token: T,
        leaf: Range<usize>,
        ray: &mut FewRays<T>,
        hit: &mut SingleHit<'_>,
    ) {
        let Some(blocks) = self.blocks().get(leaf.clone()) else { return };
        for (block, number) in blocks.iter().zip(leaf) {
            let shown = self.shown(number);
            if shown & ALL == 0 {
                continue;
            }
            let mut first = 0;
            while first < BLOCK {
                let (hits, t) = block.test_few(token, ray, first);
                let mut hits = hits.bits() & (shown & ALL) >> first;
                if hits != 0 {
                    let (mut distance, ids) = ([0.0; 16], block.ids(number));
                    t.store(&mut distance, 0);
                    while hits != 0 {
                        let lane = hits.trailing_zeros() as usize % 16;
                        hits &= hits - 1;
                        let (t, id) = (distance[lane], ids[(first + lane) % BLOCK]);
                        if ANY {
                            if hit.any(t, id) {
                                return;
                            }
                        } else if hit.closest(t, id) {
                            ray.t_max = token.splat(t);
                        }
                    }
                }
                first += T::LANES;
            }
        }
    }

    #[inline(always)]
    fn few<T: Token, const N: usize, S: Sink<N>>(
        &self,
        token: T,
        leaf: Range<usize>,
        rays: &mut Rays<N>,
        sink: &mut S,
        numbers: &[usize],
        axis: Option<usize>,
    ) -> bool {
        if T::LANES < BLOCK {
            return false;
        }
        let Some(blocks) = self.blocks().get(leaf.clone()) else { return true };
        for (block, number) in blocks.iter().zip(leaf) {
            let shown = self.shown(number);
            if shown & ALL == 0 {
                continue;
            }
            let ids = block.ids(number);
            for numbers in numbers.chunks(FewRays::<T>::COUNT) {
                let few = FewRays::<T>::of::<N>(token, rays, numbers, axis);
                let (hits, t) = block.test_few(token, &few, 0);
                let hits = hits.bits();
                if hits == 0 {
                    continue;
                }
                let mut distance = [0.0; 16];
                t.store(&mut distance, 0);
                for (k, &ray) in numbers.iter().enumerate() {
                    let mut hits = hits >> (BLOCK * k) & shown & ALL;
                    if hits == 0 {
                        continue;
                    }
                    let mut hit = sink.single(rays, ray);
                    while hits != 0 {
                        let i = hits.trailing_zeros() as usize % BLOCK;
                        hits &= hits - 1;
                        let (t, id) = (distance[(BLOCK * k + i) % 16], ids[i]);
                        if !S::ANY {
                            hit.closest(t, id);
                        } else if hit.any(t, id) {
                            break;
                        }
                    }
                    let found = hit.found;
                    sink.set(rays, ray, found);
                }
            }
        }
        true
    }

    #[inline(always)]
    fn prefetch(&self, leaf: Range<usize>) {
        if let Some(block) = self.blocks().get(leaf.start) {
            prefetch(block);
        }
    }
}
