//! Where the boxes of a tree are measured from: amid most of its primitives, wherever the others are.

use alloc::vec::Vec;

use crate::kernel::margin::Frame;
use crate::leaf::Bounds;

/// So many primitives are asked.
pub(super) const SAMPLES: usize = 512;

/// Evenly spaced numbers below `count`, at most [`SAMPLES`].
pub(super) fn samples(count: usize) -> impl Iterator<Item = usize> {
    let samples = count.min(SAMPLES);
    (0..samples).map(move |i| (i as u64 * count as u64 / samples as u64) as usize)
}

/// The median of the middles on each axis, and four times as far as nearly half of the primitives reach from there: what it
/// takes for most of them, be there another group as large far away.
pub(super) fn frame(samples: impl Iterator<Item = Bounds>) -> Frame {
    let samples: Vec<Bounds> = samples.collect();
    let Some(last) = samples.len().checked_sub(1) else { return Frame::default() };
    let at = |mut values: Vec<f32>, place: usize| *values.select_nth_unstable_by(place, f32::total_cmp).1;
    let middles = |k: usize| samples.iter().map(|b| 0.5 * b.low[k] + 0.5 * b.high[k]).collect();
    let center = [0, 1, 2].map(|k| at(middles(k), samples.len() / 2));
    let reaches = samples.iter().map(|b| reach(b, center)).collect();
    Frame { center, size: 4.0 * at(reaches, last * 7 / 16), farthest: 0.0 }
}

/// How far a box reaches from a point, along an axis; 0 when empty.
pub(super) fn reach(bounds: &Bounds, from: [f32; 3]) -> f32 {
    (0..3).map(|k| (from[k] - bounds.low[k]).max(bounds.high[k] - from[k])).fold(0.0, f32::max)
}
