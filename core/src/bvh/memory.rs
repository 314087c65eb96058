//! Memory for nodes and leaves, in large pages.

use alloc::vec::Vec;

use bytemuck::{Zeroable, zeroed_vec};
use mobula_simd::pages;

/// Zeros that the system hands out when they are first written: by who fills them, in large pages.
pub(super) fn zeroed<T: Zeroable>(count: usize) -> Vec<T> {
    let mut memory = zeroed_vec(count);
    pages::prefer_large(&mut memory);
    memory
}

/// As many values, in large pages.
pub(super) fn filled<T>(count: usize, values: impl Iterator<Item = T>) -> Vec<T> {
    let mut memory = Vec::with_capacity(count);
    pages::prefer_large(memory.spare_capacity_mut());
    memory.extend(values);
    memory
}
