//! A tree from the order of primitives along a curve: little work, for scenes that are built anew each frame.
//!
//! Lauterbach et al., "Fast BVH Construction on GPUs", Eurographics 2009. Middles are sorted along the Morton curve; ranges
//! split where the highest bit changes that is not the same in all of their codes.

use alloc::vec::Vec;

use mobula_simd::{F32Lanes, I32Lanes, Token};

use super::centroids::CentroidBounds;
use super::join::{Join, reduce};
use super::memory::zeroed;
use super::reference::{self, Reference, middle2};
use super::wide::Ranges;
use crate::leaf::{BLOCK, FOUR, Four};

/// Bits of x, y and z in a code.
const BITS: [u32; 3] = [11, 11, 10];

/// So few primitives are dealt out to full blocks, whatever their codes.
const FEW: usize = 4 * BLOCK;

/// Code above, number of the primitive below. No two are equal, so the order is one whoever sorts.
pub(super) type Key = u64;

/// Number of the primitive.
pub(super) fn index(key: Key) -> u32 {
    key as u32
}

/// Cells along a curve through the middles of some primitives.
struct Cells {
    low: Four,
    scale: Four,
}

impl Cells {
    fn of(centroids: &CentroidBounds) -> Self {
        let extent = centroids.high - centroids.low;
        let cells = FOUR.load(&BITS.map(|bits| ((1 << bits) - 1) as f32), 0);
        // An axis along which all middles are the same, or all but, has one cell.
        let scale = (cells / extent).select(extent.gt(FOUR.splat(1e-30)), FOUR.splat(0.0));
        Self { low: centroids.low, scale }
    }

    /// Of a primitive with this number.
    fn key(&self, reference: &Reference) -> Key {
        let mut cell = [0; 4];
        let at = (middle2(reference) - self.low) * self.scale;
        at.max(FOUR.splat(0.0)).min(FOUR.splat(2047.0)).to_i32().store(&mut cell, 0);
        let code = spread(cell[0]) << 1 | spread(cell[1]) | spread(cell[2]) << 2;
        Key::from(code) << 32 | Key::from(reference::index(reference))
    }
}

/// The keys of all references, whose centroids have these bounds, sorted.
pub(super) fn sorted(join: &impl Join, references: &[Reference], centroids: &CentroidBounds) -> Vec<Key> {
    let cells = Cells::of(centroids);
    let mut keys = zeroed::<Key>(references.len());
    let run = |keys: &mut [Key], start: usize| {
        for (key, reference) in keys.iter_mut().zip(&references[start..]) {
            *key = cells.key(reference);
        }
    };
    reduce(join, &mut keys, 0, &run, &|_, _, (), ()| ());
    let mut room = zeroed::<Key>(keys.len());
    // Halved once: with one thread each merge is a loss.
    if keys.len() < 1 << 14 {
        by_digits(&mut keys, &mut room);
        return room;
    }
    let middle = keys.len() / 2;
    let ((left, right), (left_room, right_room)) = (keys.split_at_mut(middle), room.split_at_mut(middle));
    join.join(|| by_digits(left, left_room), || by_digits(right, right_room));
    merge(join, left_room, right_room, &mut keys, 1);
    keys
}

/// Puts two zeros above each of the low eleven bits.
fn spread(x: u32) -> u32 {
    let x = (x | x << 16) & 0x0700_00ff;
    let x = (x | x << 8) & 0x0700_f00f;
    let x = (x | x << 4) & 0x430c_30c3;
    (x | x << 2) & 0x4924_9249
}

/// Merges two sorted slices, after cutting both at the same key.
fn merge(join: &impl Join, left: &[Key], right: &[Key], to: &mut [Key], cuts: u32) {
    if cuts > 0 && !left.is_empty() {
        let middle = left.len() / 2;
        let same = right.partition_point(|&key| key < left[middle]);
        let (low, high) = to.split_at_mut(middle + same);
        join.join(
            || merge(join, &left[..middle], &right[..same], low, cuts - 1),
            || merge(join, &left[middle..], &right[same..], high, cuts - 1),
        );
        return;
    }
    let (mut i, mut j) = (0, 0);
    for to in to {
        let (a, b) = (left.get(i).copied().unwrap_or(Key::MAX), right.get(j).copied().unwrap_or(Key::MAX));
        *to = a.min(b);
        i += usize::from(a < b);
        j += usize::from(a >= b);
    }
}

/// Sorts by code, stable: eleven bits at a time, the lowest first. After three passes the result is in the room.
fn by_digits(keys: &mut [Key], room: &mut [Key]) {
    const DIGITS: usize = 1 << 11;
    let digit = |key: Key, pass: usize| (key >> (32 + 11 * pass)) as usize % DIGITS;
    let mut places = [[0u32; DIGITS]; 3];
    for &key in keys.iter() {
        for (pass, places) in places.iter_mut().enumerate() {
            places[digit(key, pass)] += 1;
        }
    }
    let (mut from, mut to) = (keys, room);
    for (pass, places) in places.iter_mut().enumerate() {
        let mut start = 0;
        for place in places.iter_mut() {
            start += core::mem::replace(place, start);
        }
        for &key in from.iter() {
            let place = &mut places[digit(key, pass)];
            to[*place as usize] = key;
            *place += 1;
        }
        core::mem::swap(&mut from, &mut to);
    }
}

/// Ranges of sorted keys.
pub(super) struct Morton<'a> {
    /// Of the primitives, by rising numbers.
    pub(super) references: &'a [Reference],
    /// Are blocks to be full?
    pub(super) full: bool,
}

impl Morton<'_> {
    /// Sorts many primitives that share a cell by smaller cells: where a few are far away all others do.
    fn refine(&self, keys: &mut [Key]) {
        let of = |key: Key| {
            let number = index(key);
            &self.references[self.references.partition_point(|reference| reference::index(reference) < number)]
        };
        let mut centroids = CentroidBounds::empty();
        keys.iter().for_each(|&key| centroids.take(of(key)));
        let cells = Cells::of(&centroids);
        keys.iter_mut().for_each(|key| *key = cells.key(of(*key)));
        keys.sort_unstable();
    }
}

impl<'a> Ranges<'a> for Morton<'_> {
    type Range = &'a mut [Key];

    fn len(range: &&'a mut [Key]) -> usize {
        range.len()
    }

    /// Large cells first.
    fn weight(range: &&'a mut [Key]) -> f32 {
        differing(range) as f32
    }

    fn split(&self, _: &impl Join, range: &'a mut [Key], by_count: bool) -> [&'a mut [Key]; 2] {
        if range.len() > FEW && !by_count && differing(range) == 0 {
            self.refine(range);
        }
        let differing = differing(range);
        let middle = if by_count || differing == 0 || range.len() <= FEW {
            (range.len() / 2).next_multiple_of(BLOCK)
        } else {
            let bit = 63 - differing.leading_zeros();
            let middle = range.partition_point(|key| key >> bit & 1 == 0);
            let (full, most) = (middle.next_multiple_of(BLOCK), (range.len() - 1) / BLOCK * BLOCK);
            if self.full { full.min(most) } else { middle }
        };
        let (left, right) = range.split_at_mut(middle);
        [left, right]
    }
}

/// The bits of the codes in which the first and the last differ.
fn differing(range: &[Key]) -> Key {
    match range {
        [first, .., last] => (first ^ last) & !Key::from(u32::MAX),
        _ => 0,
    }
}
