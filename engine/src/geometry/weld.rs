//! Finds points that are equal, bit for bit, in a time that follows from their number alone.
//!
//! A table with open addressing that holds nothing but numbers of points: what they are is asked of whoever has them. It is mixed with
//! words that are drawn anew by each process, so that no file can be written whose points all want the same place. What is found does
//! not depend on these: it is always the first of equal points.

use std::hash::{BuildHasher, RandomState};

/// A place in the table that is free.
const FREE: u32 = u32::MAX;

/// Points by what they are: `N` words of bits each.
pub(crate) struct Weld<const N: usize> {
    /// Numbers of points; a power of two, at most half of them taken.
    slots: Vec<u32>,
    taken: usize,
    secret: [u64; 2],
}

impl<const N: usize> Weld<N> {
    /// A table that need not grow for so many points.
    pub(crate) fn with_capacity(points: usize) -> Self {
        let state = RandomState::new();
        let secret = [state.hash_one(1), state.hash_one(2) | 1];
        Self { slots: vec![FREE; (2 * points.max(8)).next_power_of_two()], taken: 0, secret }
    }

    /// The number of the first point that is equal; `new` if there was none. `words` tells what the points of the table are.
    #[inline]
    pub(crate) fn find(&mut self, point: [u64; N], new: u32, words: impl Fn(u32) -> [u64; N]) -> u32 {
        if 2 * self.taken >= self.slots.len() {
            self.grow(&words);
        }
        let slot = self.slot(point, &words);
        if self.slots[slot] == FREE {
            self.slots[slot] = new;
            self.taken += 1;
        }
        self.slots[slot]
    }

    /// Where a point is, or would be.
    #[inline]
    fn slot(&self, point: [u64; N], words: &impl Fn(u32) -> [u64; N]) -> usize {
        let mask = self.slots.len() - 1;
        let mut slot = self.mixed(point) & mask;
        while self.slots[slot] != FREE && words(self.slots[slot]) != point {
            slot = (slot + 1) & mask;
        }
        slot
    }

    /// Each word is multiplied, and the halves of the product are folded together: all bits of a word count in all bits of the result.
    #[inline]
    fn mixed(&self, point: [u64; N]) -> usize {
        let [start, factor] = self.secret;
        let mixed = point.iter().fold(start, |mixed, word| {
            let product = u128::from(mixed ^ word) * u128::from(factor);
            product as u64 ^ (product >> 64) as u64
        });
        mixed as usize
    }

    fn grow(&mut self, words: &impl Fn(u32) -> [u64; N]) {
        let larger = vec![FREE; 2 * self.slots.len()];
        for number in std::mem::replace(&mut self.slots, larger).into_iter().filter(|number| *number != FREE) {
            let slot = self.slot(words(number), words);
            self.slots[slot] = number;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_first_of_equal_points_is_found(points in prop::collection::vec(prop::array::uniform2(0..6_u64), 0..300)) {
            let mut weld = Weld::with_capacity(0);
            for (number, &point) in points.iter().enumerate() {
                let found = weld.find(point, number as u32, |number| points[number as usize]);
                prop_assert_eq!(Some(found as usize), points.iter().position(|other| *other == point));
            }
        }
    }
}
