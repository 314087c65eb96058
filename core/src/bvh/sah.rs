//! The surface area heuristic over bins.
//!
//! Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", RT 2007. Three passes over a range: how far
//! middles reach, all three axes' bins at once, and the partition. Ranges are cut into runs, so that threads share the
//! passes near the root.

use mobula_simd::{AnyToken, Task, Token};

use super::block::BLOCK;
use super::join::{Join, reduce};
use super::reference::{self, EMPTY, Reference, half_area, merge, middle2};
use super::wide::Ranges;

const BINS: usize = 16;

/// Ranges of references, split where the heuristic says.
pub(super) struct Sah {
    pub(super) token: AnyToken,
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
        self.token.run(Split { join, references, by_count })
    }
}

impl<'a> Range<'a> {
    pub(super) fn new(references: &'a mut [Reference]) -> Self {
        Self { references, area: 0.0 }
    }
}

struct Split<'a, 'j, J> {
    join: &'j J,
    references: &'a mut [Reference],
    by_count: bool,
}

impl<'a, J: Join> Task for Split<'a, '_, J> {
    type Output = [Range<'a>; 2];

    #[inline(always)]
    fn run<T: Token>(self, token: T) -> [Range<'a>; 2] {
        let Self { join, references, by_count } = self;
        let centers = reach(references);
        let binning = Binning::new(&centers, references.len());
        let bins = fill(references, &binning);
        let found = if by_count { None } else { bins.best(&binning) };
        let middle = match &found {
            Some(split) => partition(references, &binning, split),
            None => references.len() / 2,
        };
        let half = references.len() / 2;
        let middle = if middle == 0 || middle == references.len() { half } else { middle };
        let areas = found.map_or([0.0; 2], |split| split.areas);
        let (left, right) = references.split_at_mut(middle);
        [Range { references: left, area: areas[0] }, Range { references: right, area: areas[1] }]
    }
}

/// How far middles reach: `[low x, y, z, -, high x, y, z, -]`.
#[inline(always)]
fn reach(references: &[Reference]) -> [[f32; 4]; 2] {
    let (mut low, mut high) = ([f32::INFINITY; 4], [f32::NEG_INFINITY; 4]);
    for reference in references {
        let middle = middle2(reference);
        for i in 0..4 {
            low[i] = if middle[i] < low[i] { middle[i] } else { low[i] };
            high[i] = if middle[i] > high[i] { middle[i] } else { high[i] };
        }
    }
    [low, high]
}

struct Binning {
    low: [f32; 4],
    scale: [f32; 4],
    bins: usize,
}

impl Binning {
    #[inline(always)]
    fn new([low, high]: &[[f32; 4]; 2], count: usize) -> Self {
        let bins = if count > 32 { BINS } else { BINS / 2 };
        let scale = core::array::from_fn(|axis| {
            let extent = high[axis] - low[axis];
            // Below this the quotient would overflow: all middles fall into bin 0 and the axis is not split.
            if extent > 1e-30 { (bins - 1) as f32 / extent } else { 0.0 }
        });
        Self { low: *low, scale, bins }
    }

    /// The bins of a middle: rounded by adding 2^23, which leaves the integer in the low bits.
    #[inline(always)]
    fn bins(&self, middle: [f32; 4]) -> [usize; 3] {
        let bits: [u32; 4] =
            core::array::from_fn(|i| (((middle[i] - self.low[i]) * self.scale[i]) + 8_388_608.0).to_bits());
        [0, 1, 2].map(|axis| bits[axis] as usize % BINS)
    }
}

struct Bins {
    bounds: [[Reference; 3]; BINS],
    counts: [[u32; 4]; BINS],
}

#[inline(always)]
fn fill(references: &[Reference], binning: &Binning) -> Bins {
    let mut bins = Bins { bounds: [[EMPTY; 3]; BINS], counts: [[0; 4]; BINS] };
    for reference in references {
        let at = binning.bins(middle2(reference));
        for axis in 0..3 {
            merge(&mut bins.bounds[at[axis]][axis], reference);
            bins.counts[at[axis]][axis] += 1;
        }
    }
    bins
}

struct Best {
    axis: usize,
    bin: usize,
    areas: [f32; 2],
}

impl Bins {
    #[inline(always)]
    fn best(&self, binning: &Binning) -> Option<Best> {
        let blocks = |count: u32| count.div_ceil(BLOCK as u32) as f32;
        let mut right = [[(0.0f32, 0u32); 3]; BINS];
        let (mut bounds, mut counts) = ([EMPTY; 3], [0u32; 3]);
        for i in (1..binning.bins).rev() {
            for axis in 0..3 {
                merge(&mut bounds[axis], &self.bounds[i][axis]);
                counts[axis] += self.counts[i][axis];
                right[i][axis] = (half_area(&bounds[axis]), counts[axis]);
            }
        }
        let (mut best, mut least) = (None, f32::INFINITY);
        let (mut bounds, mut counts) = ([EMPTY; 3], [0u32; 3]);
        for i in 1..binning.bins {
            for axis in 0..3 {
                merge(&mut bounds[axis], &self.bounds[i - 1][axis]);
                counts[axis] += self.counts[i - 1][axis];
                let (area, count) = right[i][axis];
                let here = half_area(&bounds[axis]);
                let cost = here * blocks(counts[axis]) + area * blocks(count);
                if cost < least && counts[axis] > 0 && count > 0 {
                    least = cost;
                    best = Some(Best { axis, bin: i, areas: [here, area] });
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
    for i in 0..references.len() {
        let reference = references[i];
        let is_left = binning.bins(middle2(&reference))[split.axis] < split.bin;
        references[i] = references[left];
        references[left] = reference;
        left += usize::from(is_left);
    }
    left
}
