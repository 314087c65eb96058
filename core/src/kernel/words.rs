//! Rays of a packet in words of 64, a bit a ray.

use mobula_simd::Token;

/// Words of the widest packet.
pub const WORDS: usize = 1024 / 64;

/// Rays of a word: 64, unless a packet has fewer, rounded up to vectors.
pub(crate) const fn word_size(width: usize) -> usize {
    if width < 64 { width } else { 64 }
}

/// Those of a word in the vector from `lane`.
#[inline(always)]
pub(crate) fn part<T: Token>(word: u64, lane: usize) -> u32 {
    (word >> lane) as u32 & (u32::MAX >> (32 - T::LANES))
}
