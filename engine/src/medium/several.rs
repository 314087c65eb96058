//! Media that overlap: parts of rays in which more than one of them is are cut so short that they may be taken to be mixed there.

use std::sync::Arc;

use crate::math::{exp_minus, log2};
use crate::packet::{Column, Columns3, part_mut, set_vec3, vec3};
use crate::scratch::lend;
use crate::stack::{Context, Medium, Segments};

/// A ray with less light than this is at its end.
const DARK: f32 = 1.0 / 1024.0;
/// At most so many parts of a ray: the longest of them get longer.
const MOST_PARTS: f32 = 4096.0;

/// As [`Medium::march`], through all of some media.
///
/// Within a part of a ray, a medium i has an optical depth of x_i and shines with r_i when it is alone. Mixed evenly, of all that shines
/// a fraction phi(x) = (1 - exp(-x)) / x gets out, with x the sum of all depths: so together they shine with the sum of
/// r_i phi(x) / phi(x_i) (Max, "Optical Models for Direct Volume Rendering", 1995).
pub(super) fn march(
    media: &[Arc<dyn Medium>],
    context: &Context<'_>,
    segments: &Segments<'_>,
    mut radiance: [&mut [f32]; 3],
    transmittance: &mut [f32],
) {
    if let [only] = media {
        return only.march(context, segments, radiance, transmittance);
    }
    let count = transmittance.len();
    radiance.iter_mut().for_each(|column| column.fill(0.0));
    transmittance.fill(1.0);
    let mut walk = Walk::new(media, segments);
    let sum: &mut Columns3 = &mut lend(context.width);
    let depth: &mut Column<f32> = &mut lend(context.width);
    let alone: &mut Columns3 = &mut lend(context.width);
    let through: &mut Column<f32> = &mut lend(context.width);
    while walk.advance(transmittance) {
        sum.iter_mut().for_each(|column| column[..count].fill(0.0));
        depth[..count].fill(0.0);
        for (number, medium) in media.iter().enumerate() {
            if walk.take(number) {
                let parts = Segments { t0: &walk.t0, t1: &walk.t1, ..*segments };
                medium.march(context, &parts, part_mut(alone, 0..count), &mut through[..count]);
                for i in (0..count).filter(|&i| walk.t0[i] < walk.t1[i]) {
                    let x = optical_depth(through[i]);
                    depth[i] += x;
                    set_vec3(sum, i, vec3(sum, i) + vec3(alone, i) * (1.0 / gets_out(x, through[i])));
                }
            }
        }
        for i in 0..count {
            let mixed = exp_minus(depth[i]);
            let weight = transmittance[i] * gets_out(depth[i], mixed);
            let more = vec3(&radiance, i) + vec3(sum, i) * weight;
            set_vec3(&mut radiance, i, more);
            transmittance[i] *= mixed;
        }
    }
}

/// As [`Medium::transmittance`], through all of some media: where they are does not matter.
pub(super) fn transmittance(
    media: &[Arc<dyn Medium>],
    context: &Context<'_>,
    segments: &Segments<'_>,
    out: &mut [f32],
) {
    let Some((first, others)) = media.split_first() else { return out.fill(1.0) };
    first.transmittance(context, segments, out);
    let through: &mut Column<f32> = &mut lend(context.width);
    for medium in others {
        medium.transmittance(context, segments, &mut through[..out.len()]);
        out.iter_mut().zip(through.iter()).for_each(|(out, through)| *out *= through);
    }
}

fn optical_depth(through: f32) -> f32 {
    let least = f32::MIN_POSITIVE;
    (-log2(f64::from(through.max(least))) * std::f64::consts::LN_2).max(0.0) as f32
}

/// `(1 - exp(-x)) / x`, given `exp(-x)` too.
fn gets_out(x: f32, through: f32) -> f32 {
    if x < 0.01 { 1.0 - x * (0.5 - x * (1.0 / 6.0)) } else { (1.0 - through) / x }
}

/// Rays on their way from part to part.
struct Walk {
    /// Where each medium begins and ends along each ray.
    reaches: Vec<[Vec<f32>; 2]>,
    /// The longest part where several media are, in lengths of the direction.
    longest: Vec<f32>,
    /// The parts that rays are at.
    from: Vec<f32>,
    to: Vec<f32>,
    /// The same of those rays only for which a medium is there.
    t0: Vec<f32>,
    t1: Vec<f32>,
}

impl Walk {
    fn new(media: &[Arc<dyn Medium>], segments: &Segments<'_>) -> Self {
        let count = segments.t0.len();
        let grain = media.iter().map(|medium| medium.grain()).fold(f32::INFINITY, f32::min);
        let reach = |medium: &Arc<dyn Medium>| {
            let (mut t0, mut t1) = (vec![0.0; count], vec![0.0; count]);
            medium.clip(segments, &mut t0, &mut t1);
            [t0, t1]
        };
        let reaches: Vec<[Vec<f32>; 2]> = media.iter().map(reach).collect();
        let longest = |i: usize| {
            let ends = reaches.iter().map(|[t0, t1]| if t1[i].is_finite() { (t1[i] - t0[i]).max(0.0) } else { 0.0 });
            let all: f32 = ends.sum();
            (grain / vec3(&segments.directions, i).length()).max(all / MOST_PARTS)
        };
        Self {
            longest: (0..count).map(longest).collect(),
            from: vec![0.0; count],
            to: segments.t0.to_vec(),
            t0: vec![0.0; count],
            t1: vec![0.0; count],
            reaches,
        }
    }

    /// Goes on to the next parts in which any medium is. Says whether there are any.
    fn advance(&mut self, transmittance: &[f32]) -> bool {
        let mut any = false;
        for i in 0..self.to.len() {
            let from = self.to[i];
            (self.from[i], self.to[i]) = (f32::INFINITY, f32::INFINITY);
            if transmittance[i] < DARK {
                continue;
            }
            // From where the first of those begins that do not end before.
            let begins = self
                .reaches
                .iter()
                .filter(|[_, t1]| t1[i] > from)
                .map(|[t0, t1]| if t0[i] < t1[i] { t0[i].max(from) } else { f32::INFINITY });
            let from = begins.fold(f32::INFINITY, f32::min);
            if from == f32::INFINITY {
                continue;
            }
            let (mut to, mut there) = (f32::INFINITY, 0);
            for [t0, t1] in self.reaches.iter().filter(|[t0, t1]| t0[i] < t1[i] && t1[i] > from) {
                if t0[i] <= from {
                    there += 1;
                    to = to.min(t1[i]);
                } else {
                    to = to.min(t0[i]);
                }
            }
            if there > 1 {
                let next = from + self.longest[i];
                // Beyond what a float can tell apart, the rest is one part.
                to = if next > from { to.min(next) } else { to };
            }
            (self.from[i], self.to[i]) = (from, to);
            any = true;
        }
        any
    }

    /// Takes the parts in which a medium is. Says whether there are any.
    fn take(&mut self, medium: usize) -> bool {
        let [t0, t1] = &self.reaches[medium];
        let mut any = false;
        for i in 0..self.t0.len() {
            let there = self.from[i] < self.to[i] && t0[i] <= self.from[i] && self.to[i] <= t1[i];
            (self.t0[i], self.t1[i]) = if there { (self.from[i], self.to[i]) } else { (0.0, 0.0) };
            any |= there;
        }
        any
    }
}
