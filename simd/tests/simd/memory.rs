//! Loads, stores and gathers at every level, against their definition in plain Rust: every length of slice, every place
//! in it and beyond, and that nothing outside is touched.

use crate::levels::at_every_level;
use mobula_simd::{AnyToken, F32Lanes, I32Lanes, MaskLanes, Task, Token};

/// Larger than two of the widest vectors and a tail.
const MOST: usize = 37;
/// What stands in memory, before, after and within a slice that is to be written.
const OLD: u32 = 0x7f80_0bad;

/// The places to try in a slice: all of it, some beyond, and those where an address would overflow.
fn places(length: usize) -> impl Iterator<Item = usize> {
    let far = [usize::MAX, usize::MAX - 1, usize::MAX - 15, usize::MAX / 4, usize::MAX / 4 + 1, (1u64 << 32) as usize];
    (0..length + 20).chain(far)
}

/// The masks to try: all for narrow vectors, and for wide ones a sample that has every pattern of 4 neighbours.
fn masks(lanes: usize) -> impl Iterator<Item = u32> {
    let count = if lanes > 8 { 256 } else { 1 << lanes };
    (0..count).map(move |i: u32| if lanes > 8 { i.wrapping_mul(257) ^ (i << 4) } else { i })
}

fn element(i: usize) -> u32 {
    0x7f80_0001 + 0x0101 * i as u32
}

/// What `load` should give: lane `i` of `src[at..]` if it exists and its bit is set.
fn loaded(length: usize, at: usize, lane: usize, bits: u32) -> u32 {
    match at.checked_add(lane) {
        Some(i) if i < length && bits >> lane & 1 == 1 => element(i),
        _ => 0,
    }
}

struct Loads;

impl Task for Loads {
    type Output = ();
    #[inline(always)]
    fn run<T: Token>(self, token: T) {
        let all = (1 << T::LANES) - 1;
        for length in 0..MOST {
            // Of exactly this size: a reader of more would be seen by a memory checker.
            let integers: Box<[u32]> = (0..length).map(element).collect();
            let floats: Box<[f32]> = integers.iter().map(|&x| f32::from_bits(x)).collect();
            for at in places(length) {
                let mut out = [[0; 16]; 2];
                token.load(&floats, at).to_bits().store(&mut out[0], 0);
                token.load_u32(&integers, at).store(&mut out[1], 0);
                for (lane, got) in out[0].into_iter().zip(out[1]).enumerate().take(T::LANES) {
                    let want = loaded(length, at, lane, all);
                    assert_eq!(got, (want, want), "lane {lane} at {at} of {length}");
                }
            }
        }
    }
}

fn load(token: AnyToken) {
    token.run(Loads);
    token.twin().run(Loads);
}

struct MaskedLoads;

impl Task for MaskedLoads {
    type Output = ();
    #[inline(always)]
    fn run<T: Token>(self, token: T) {
        for length in (0..MOST).step_by(3) {
            let floats: Box<[f32]> = (0..length).map(|i| f32::from_bits(element(i))).collect();
            for at in places(length) {
                for bits in masks(T::LANES) {
                    let mut out = [0; 16];
                    token.load_masked(&floats, at, token.mask(bits)).to_bits().store(&mut out, 0);
                    for (lane, &got) in out[..T::LANES].iter().enumerate() {
                        assert_eq!(got, loaded(length, at, lane, bits), "lane {lane} at {at} of {length} by {bits:#b}");
                    }
                }
            }
        }
    }
}

fn load_masked(token: AnyToken) {
    token.run(MaskedLoads);
    token.twin().run(MaskedLoads);
}

/// Compares what a store left in a slice, and around it, with what it should have left there.
fn assert_stored(buffer: &[u32], start: usize, length: usize, at: usize, lanes: usize, bits: u32) {
    for (i, &got) in buffer.iter().enumerate() {
        let lane = i.checked_sub(start).filter(|&i| i < length).and_then(|i| i.checked_sub(at));
        let want = match lane {
            Some(lane) if lane < lanes && bits >> lane & 1 == 1 => element(lane),
            _ => OLD,
        };
        assert_eq!(got, want, "element {i} of {start}+{length}, written at {at} by {bits:#b}");
    }
}

/// Stores floats, or integers, with or without a mask.
struct Stores {
    floats: bool,
    masked: bool,
}

impl Task for Stores {
    type Output = ();
    #[inline(always)]
    fn run<T: Token>(self, token: T) {
        const AROUND: usize = 20;
        let source: [u32; 16] = std::array::from_fn(element);
        let lanes = token.load_u32(&source, 0);
        let step = if self.masked { 3 } else { 1 };
        for length in (0..MOST).step_by(step) {
            for at in places(length) {
                for bits in masks(if self.masked { T::LANES } else { 0 }) {
                    let mask = token.mask(bits);
                    let mut integers = [OLD; MOST + 2 * AROUND];
                    if self.floats {
                        let mut floats = integers.map(f32::from_bits);
                        let dst = &mut floats[AROUND..AROUND + length];
                        match self.masked {
                            true => lanes.from_bits_f32().store_masked(dst, at, mask),
                            false => lanes.from_bits_f32().store(dst, at),
                        }
                        integers = floats.map(f32::to_bits);
                    } else {
                        let dst = &mut integers[AROUND..AROUND + length];
                        match self.masked {
                            true => lanes.store_masked(dst, at, mask),
                            false => lanes.store(dst, at),
                        }
                    }
                    let bits = if self.masked { bits } else { u32::MAX };
                    assert_stored(&integers, AROUND, length, at, T::LANES, bits);
                }
            }
        }
    }
}

fn store(token: AnyToken) {
    token.run(Stores { floats: true, masked: false });
    token.twin().run(Stores { floats: true, masked: false });
}

fn store_masked(token: AnyToken) {
    token.run(Stores { floats: true, masked: true });
    token.twin().run(Stores { floats: true, masked: true });
}

fn i32_store(token: AnyToken) {
    token.run(Stores { floats: false, masked: false });
    token.twin().run(Stores { floats: false, masked: false });
}

fn i32_store_masked(token: AnyToken) {
    token.run(Stores { floats: false, masked: true });
    token.twin().run(Stores { floats: false, masked: true });
}

struct Gathers;

impl Task for Gathers {
    type Output = ();
    #[inline(always)]
    fn run<T: Token>(self, token: T) {
        let edges =
            [0, 1, 2, 7, 8, 15, 16, 30, 36, 37, 1000, 0x7fff_ffff, 0x8000_0000, 0x8000_0001, 0xc000_0000, u32::MAX];
        for length in 0..MOST {
            let floats: Box<[f32]> = (0..length).map(|i| f32::from_bits(element(i))).collect();
            for turn in 0..edges.len() {
                let index: [u32; 16] = std::array::from_fn(|lane| edges[(turn + lane * 3) % edges.len()]);
                for bits in masks(T::LANES).step_by(7).chain([u32::MAX]) {
                    let mut out = [0; 16];
                    let lanes = token.gather(&floats, token.load_u32(&index, 0), token.mask(bits));
                    lanes.to_bits().store(&mut out, 0);
                    for (lane, &got) in out[..T::LANES].iter().enumerate() {
                        let i = index[lane] as usize;
                        let want = if i < length && bits >> lane & 1 == 1 { element(i) } else { 0 };
                        assert_eq!(got, want, "lane {lane}, index {i} of {length} by {bits:#b}");
                    }
                }
            }
        }
    }
}

fn gather(token: AnyToken) {
    token.run(Gathers);
    token.twin().run(Gathers);
}

struct Repeats;

impl Task for Repeats {
    type Output = ();
    #[inline(always)]
    fn run<T: Token>(self, token: T) {
        let four: [f32; 4] = std::array::from_fn(|i| f32::from_bits(element(i)));
        for at in 0..4 {
            let mut out = [0; 16];
            token.repeat(&four, at).to_bits().store(&mut out, 0);
            for (lane, &got) in out[..T::LANES].iter().enumerate() {
                let expected = element(if T::LANES == 1 { at } else { lane % 4 });
                assert_eq!(got, expected, "lane {lane} at {at}");
            }
        }
    }
}

fn repeat(token: AnyToken) {
    token.run(Repeats);
    token.twin().run(Repeats);
}

struct Lookups;

impl Task for Lookups {
    type Output = ();
    #[inline(always)]
    fn run<T: Token>(self, token: T) {
        let table: [f32; 16] = std::array::from_fn(|i| f32::from_bits(element(i)));
        for turn in 0..64_u32 {
            // All places, and bits above the lowest four that must not count.
            let index: [u32; 16] =
                std::array::from_fn(|lane| (lane as u32 * 7 + turn) ^ turn.wrapping_mul(0xdead_bee0));
            let mut out = [0; 16];
            token.lookup(&table, token.load_u32(&index, 0)).to_bits().store(&mut out, 0);
            for (lane, &got) in out[..T::LANES].iter().enumerate() {
                assert_eq!(got, element(index[lane] as usize % 16), "lane {lane}, index {:#x}", index[lane]);
            }
        }
    }
}

fn lookup(token: AnyToken) {
    token.run(Lookups);
    token.twin().run(Lookups);
}

struct Rows;

impl Task for Rows {
    type Output = ();
    #[inline(always)]
    fn run<T: Token>(self, token: T) {
        let table: [[f32; 8]; 64] = std::array::from_fn(|row| std::array::from_fn(|i| (8 * row + i) as f32));
        let set = [0x8000_0001, 0x1234_5678, 0, 0xfedc_ba98_u32];
        for turn in 0..500_u32 {
            let index: [u32; 16] =
                std::array::from_fn(|lane| (turn + 37 * lane as u32).wrapping_mul(0x9e37_79b1) >> (turn % 27));
            let lanes = token.load_u32(&index, 0);
            for (i, column) in token.gather_rows(&table, lanes).into_iter().enumerate() {
                let mut out = [0.0; 16];
                column.store(&mut out, 0);
                for lane in 0..T::LANES {
                    assert_eq!(out[lane], table[index[lane] as usize % 64][i], "lane {lane}, element {i}");
                }
            }
            let bits = token.is_member(&set, lanes).bits();
            for lane in 0..T::LANES {
                let at = index[lane] % 128;
                assert_eq!(bits >> lane & 1, set[at as usize / 32] >> (at % 32) & 1, "lane {lane}, member {at}");
            }
        }
    }
}

fn rows_and_sets(token: AnyToken) {
    token.run(Rows);
    token.twin().run(Rows);
}

at_every_level!(
    rows_and_sets,
    lookup,
    repeat,
    load,
    load_masked,
    store,
    store_masked,
    i32_store,
    i32_store_masked,
    gather
);
