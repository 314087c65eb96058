//! What the rays of a packet have in common, so that a box can be dismissed for all of them at once.

use mobula_simd::Token;

use crate::Rays;
use crate::bvh::Node;

/// Groups in a packet, at most.
pub(super) const GROUPS: usize = 16;

/// Rays in a group: 16, or as many as make 16 groups of a wider packet.
pub(super) const fn group_size(width: usize) -> usize {
    if width <= 16 * GROUPS { 16 } else { width.div_ceil(GROUPS).next_multiple_of(16) }
}

/// The class of a group whose rays have nothing in common: they go one by one.
pub(super) const MIXED: u8 = u8::MAX;

/// A value of every group.
pub(super) type Row = [f32; GROUPS];

/// Bounds of the rays of each group, and of all groups of one class that travel together. What it says of a box is
/// conservative: see [`traverse`](super) for the margin.
pub(super) trait Cull: Sized {
    /// Do the packets that it is made for have a common origin, so that kernels may hoist?
    const COMMON_ORIGIN: bool;

    /// Looks at all groups of a packet.
    fn new<T: Token, const N: usize>(token: T, rays: &Rays<N>, scale: f32) -> Self;

    /// Groups of one class can travel together.
    fn class(&self, group: usize) -> u8;

    /// Lets the groups of a mask, all of this class, travel together.
    fn gather(&mut self, groups: u32, class: u8);

    /// The dominant axis of all rays that travel together. Only with a common origin.
    fn axis(&self) -> usize;

    /// The farthest that any ray that travels may still hit.
    fn farthest(&self) -> f32;

    /// Which children of a node may any ray meet, and where at the earliest.
    fn children<T: Token>(&self, token: T, node: &Node, near: &mut [f32; 8]) -> u32;

    /// Are the rays so close together that [`groups`](Self::groups) tells enough of a child? Else its rays are tested.
    fn compact(&self) -> bool {
        false
    }

    /// Which groups may meet a child, of the first `groups`. Asked only if [`compact`](Self::compact).
    fn groups<T: Token>(&self, _token: T, _node: &Node, _slot: usize, _groups: usize) -> u32 {
        u32::MAX
    }

    /// By how much boxes are widened: see [`traverse`](super).
    fn margin(&self) -> f32;

    /// The farthest of each group, to lower after hits.
    fn farthest_of_groups(&mut self) -> &mut Row;

    /// Lowers [`farthest`](Self::farthest) to that of the groups.
    fn shorten(&mut self);
}

/// The greatest of the groups of a mask.
#[inline(always)]
pub(super) fn greatest(row: &Row, groups: u32) -> f32 {
    let mut greatest = f32::NEG_INFINITY;
    let mut left = groups;
    while left != 0 {
        let value = row[left.trailing_zeros() as usize % GROUPS];
        left &= left - 1;
        greatest = if value > greatest { value } else { greatest };
    }
    greatest
}

/// The least of the groups of a mask.
#[inline(always)]
pub(super) fn least(row: &Row, groups: u32) -> f32 {
    let mut least = f32::INFINITY;
    let mut left = groups;
    while left != 0 {
        let value = row[left.trailing_zeros() as usize % GROUPS];
        left &= left - 1;
        least = if value < least { value } else { least };
    }
    least
}
