//! The surface area heuristic over bins.
//!
//! Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", RT 2007. Three passes over a range: the bounds
//! of the centroids, all three axes' bins at once, and the partition. Ranges are cut into runs, so that threads share the
//! passes near the root.

use alloc::boxed::Box;

use mobula_simd::{AnyToken, F32Lanes, I32Lanes, Task, Token};

use super::centroids::CentroidBounds;
use super::join::{Join, RUN, reduce};
use super::reference::{EMPTY, Reference, half_area, merge, middle2};
use super::wide::Ranges;
use crate::leaf::{BLOCK, FOUR};

/// Bins of many primitives.
const BINS: usize = 32;
/// Of fewer, and of few.
const HALF: usize = BINS / 2;
const QUARTER: usize = BINS / 4;
/// Ranges of more have all bins. The splits near the root are the ones that finer bins improve.
const MANY: usize = 256;
/// Ranges up to this have a quarter.
const FEW: usize = 32;

/// Ranges of references, split where the heuristic says.
pub(super) struct Sah {
    pub(super) token: AnyToken,
    /// Are blocks to be full?
    pub(super) full: bool,
}

/// References that become a subtree.
pub(super) struct Range<'a> {
    references: &'a mut [Reference],
    area: f32,
}

impl<'a> Ranges<'a> for Sah {
    type Range = Range<'a>;

    fn len(range: &Range<'a>) -> usize {
        range.references.len()
    }

    fn weight(range: &Range<'a>) -> f32 {
        range.area
    }

    fn split(&self, join: &impl Join, range: Range<'a>, by_count: bool) -> [Range<'a>; 2] {
        let Range { references, .. } = range;
        let count = references.len();
        let Parts { mut middle, areas, axis } = if by_count {
            Parts::NONE
        } else if count <= RUN {
            self.token.run(Split(references))
        } else {
            self.in_runs(join, references)
        };
        if middle == 0 || middle == count {
            middle = count / 2;
        }
        if self.full {
            middle = at_full_block(references, middle, axis);
        }
        let (left, right) = references.split_at_mut(middle);
        [Range { references: left, area: areas[0] }, Range { references: right, area: areas[1] }]
    }
}

impl Sah {
    /// The three passes, each in runs that threads share.
    fn in_runs(&self, join: &impl Join, references: &mut [Reference]) -> Parts {
        let token = self.token;
        let merge = |_: &mut [Reference], _, a: CentroidBounds, b: CentroidBounds| a.merge(&b);
        let centroids = reduce(join, references, 0, &|run, _| token.run(Measuring(run)), &merge);
        let binning = Binning::new(&centroids, references.len());
        let filling = |run: &mut [Reference], _| token.run(Filling(run, &binning));
        let bins = reduce(join, references, 0, &filling, &|_, _, mut a: Box<Bins<BINS>>, b| {
            a.merge(&b);
            a
        });
        let Some(split) = bins.best(FOUR, binning.bins) else { return Parts::NONE };
        let parting = |run: &mut [Reference], _| token.run(Parting(run, &binning, &split));
        // The right part of the left run and the left part of the right one change places, as far as both go.
        let middle = reduce(join, references, 0, &parting, &|all, start, left, right| {
            let swapped = right.min(start - left);
            let (front, back) = all.split_at_mut(start);
            front[left..left + swapped].swap_with_slice(&mut back[right - swapped..right]);
            left + right
        });
        Parts { middle, areas: split.areas, axis: split.axis }
    }
}

/// Moves a split along an axis to where what is left of it are full blocks, with the primitives that are nearest to it.
fn at_full_block(references: &mut [Reference], mut middle: usize, axis: usize) -> usize {
    let (count, over) = (references.len(), middle % BLOCK);
    if over == 0 {
        return middle;
    }
    let further = |a: &Reference, b: &Reference| a[axis] - a[axis + 4] > b[axis] - b[axis + 4];
    if middle - over + BLOCK >= count || over <= BLOCK / 2 && middle > over {
        for _ in 0..over {
            let last = (0..middle).fold(0, |last, i| if further(&references[i], &references[last]) { i } else { last });
            middle -= 1;
            references.swap(last, middle);
        }
    } else {
        for _ in over..BLOCK {
            let next = (middle..count)
                .fold(middle, |next, i| if further(&references[i], &references[next]) { next } else { i });
            references.swap(next, middle);
            middle += 1;
        }
    }
    middle
}

impl<'a> Range<'a> {
    pub(super) fn new(references: &'a mut [Reference]) -> Self {
        Self { references, area: 0.0 }
    }
}

/// How a range was split.
struct Parts {
    /// How many go left.
    middle: usize,
    /// Half the surface areas of both sides.
    areas: [f32; 2],
    /// The axis along which the left is less.
    axis: usize,
}

impl Parts {
    /// Not at all.
    const NONE: Self = Self { middle: 0, areas: [0.0; 2], axis: 0 };
}

/// The three passes one after the other.
struct Split<'a>(&'a mut [Reference]);

impl Task for Split<'_> {
    type Output = Parts;

    #[inline(always)]
    fn run<T: Token>(self, token: T) -> Parts {
        let binning = Binning::new(&CentroidBounds::of(self.0), self.0.len());
        // Most ranges are small: to clear bins that they do not have would be a good part of their time.
        match binning.bins {
            BINS => self.by::<T, BINS>(token, &binning),
            HALF => self.by::<T, HALF>(token, &binning),
            _ => self.by::<T, QUARTER>(token, &binning),
        }
    }
}

impl Split<'_> {
    #[inline(always)]
    fn by<T: Token, const N: usize>(self, token: T, binning: &Binning) -> Parts {
        let mut bins = Bins::<N>::EMPTY;
        bins.fill(token.narrow(), self.0, binning);
        match bins.best(token.narrow(), binning.bins) {
            Some(split) => Parts { middle: partition(self.0, binning, &split), areas: split.areas, axis: split.axis },
            None => Parts::NONE,
        }
    }
}

struct Measuring<'a>(&'a [Reference]);

impl Task for Measuring<'_> {
    type Output = CentroidBounds;

    #[inline(always)]
    fn run<T: Token>(self, _: T) -> CentroidBounds {
        CentroidBounds::of(self.0)
    }
}

struct Filling<'a>(&'a [Reference], &'a Binning);

impl Task for Filling<'_> {
    type Output = Box<Bins<BINS>>;

    #[inline(always)]
    fn run<T: Token>(self, token: T) -> Box<Bins<BINS>> {
        let mut bins = Box::new(Bins::EMPTY);
        bins.fill(token.narrow(), self.0, self.1);
        bins
    }
}

struct Parting<'a>(&'a mut [Reference], &'a Binning, &'a Best);

impl Task for Parting<'_> {
    type Output = usize;

    #[inline(always)]
    fn run<T: Token>(self, _: T) -> usize {
        partition(self.0, self.1, self.2)
    }
}

struct Binning {
    low: [f32; 4],
    scale: [f32; 4],
    bins: usize,
}

/// A float's integer is in its low bits after 2^23 was added.
const INTEGER: f32 = 8_388_608.0;

impl Binning {
    #[inline(always)]
    fn new(centroids: &CentroidBounds, count: usize) -> Self {
        let bins = if count > MANY {
            BINS
        } else if count > FEW {
            HALF
        } else {
            QUARTER
        };
        let extent = centroids.high - centroids.low;
        let scale = FOUR.splat((bins - 1) as f32) / extent;
        // Below this the quotient would overflow: all middles fall into bin 0 and the axis is not split.
        let scale = scale.select(extent.gt(FOUR.splat(1e-30)), FOUR.splat(0.0));
        let (mut lows, mut scales) = ([0.0; 4], [0.0; 4]);
        centroids.low.store(&mut lows, 0);
        scale.store(&mut scales, 0);
        Self { low: lows, scale: scales, bins }
    }

    /// The bins of a box, rounded to nearest.
    #[inline(always)]
    fn all(&self, reference: &Reference) -> [u32; 4] {
        let (low, scale) = (FOUR.load(&self.low, 0), FOUR.load(&self.scale, 0));
        let mut bins = [0; 4];
        ((middle2(reference) - low) * scale + FOUR.splat(INTEGER)).to_bits().store(&mut bins, 0);
        bins
    }

    /// The same on one axis.
    #[inline(always)]
    fn one(&self, reference: &Reference, axis: usize) -> u32 {
        let middle = reference[axis] - reference[axis + 4];
        ((middle - self.low[axis]) * self.scale[axis] + INTEGER).to_bits() & (BINS as u32 - 1)
    }
}

/// Boxes and counts by bin and axis.
struct Bins<const N: usize> {
    boxes: [[Reference; 4]; N],
    counts: [[u32; 4]; N],
}

struct Best {
    axis: usize,
    bin: u32,
    areas: [f32; 2],
}

impl<const N: usize> Bins<N> {
    const EMPTY: Self = Self { boxes: [[EMPTY; 4]; N], counts: [[0; 4]; N] };

    #[inline(always)]
    fn fill<T: Token>(&mut self, token: T, references: &[Reference], binning: &Binning) {
        for reference in references {
            let bins = binning.all(reference);
            for axis in 0..3 {
                let bin = bins[axis] as usize % N;
                merge(token, &mut self.boxes[bin][axis], reference);
                self.counts[bin][axis] += 1;
            }
        }
    }

    fn merge(&mut self, other: &Self) {
        for bin in 0..N {
            for axis in 0..3 {
                merge(FOUR, &mut self.boxes[bin][axis], &other.boxes[bin][axis]);
                self.counts[bin][axis] += other.counts[bin][axis];
            }
        }
    }

    /// The split that costs least, if one is possible.
    #[inline(always)]
    fn best<T: Token>(&self, token: T, bins: usize) -> Option<Best> {
        let blocks = |count: u32| count.div_ceil(BLOCK as u32) as i32 as f32;
        let mut right = [([0.0f32; 3], [0u32; 3]); N];
        let (mut boxes, mut counts) = ([EMPTY; 3], [0u32; 3]);
        for bin in (1..bins).rev() {
            for axis in 0..3 {
                merge(token, &mut boxes[axis], &self.boxes[bin][axis]);
                counts[axis] += self.counts[bin][axis];
                right[bin].0[axis] = half_area(&boxes[axis]);
            }
            right[bin].1 = counts;
        }
        let (mut best, mut least) = (None, f32::INFINITY);
        let (mut boxes, mut counts) = ([EMPTY; 3], [0u32; 3]);
        for bin in 1..bins {
            for axis in 0..3 {
                merge(token, &mut boxes[axis], &self.boxes[bin - 1][axis]);
                counts[axis] += self.counts[bin - 1][axis];
                let (area, count) = (right[bin].0[axis], right[bin].1[axis]);
                let here = half_area(&boxes[axis]);
                // Where a side is empty, the sum is infinite or no number.
                let cost = here * blocks(counts[axis]) + area * blocks(count);
                if cost < least {
                    least = cost;
                    best = Some(Best { axis, bin: bin as u32, areas: [here, area] });
                }
            }
        }
        best
    }
}

/// Moves what is left of the split to the front and returns how many do. Swaps always, so that nothing is guessed.
#[inline(always)]
fn partition(references: &mut [Reference], binning: &Binning, split: &Best) -> usize {
    let mut left = 0;
    let axis = split.axis % 4;
    for i in 0..references.len() {
        let is_left = binning.one(&references[i], axis) < split.bin;
        references.swap(i, left);
        left += usize::from(is_left);
    }
    left
}
