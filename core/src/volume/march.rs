//! Light through a medium that a grid describes: what it adds and what it takes, along the ways of rays.
//!
//! Bricks are visited from front to back: of the eight that a node is made of, those that rays of one set of signs leave first come
//! first, which is right for all rays with these signs, wherever they start. So rays are walked once for each set of signs among them,
//! and a brick is loaded once for all of them. Nodes in which the transfer function shows nothing are passed by: that is asked of the
//! least and the greatest value of a node as it is met, so that there is nothing to keep up to date when the function changes.
//!
//! In a brick, the way of a ray is cut into [steps](super::steps).

use alloc::vec::Vec;

use mobula_simd::{F32Lanes, MaskLanes, Task, Token};

use super::field::Field;
use super::lighting::{Lighting, Lit};
use super::passage::{Passages, WIDTH};
use super::samples::BrickSamples;
use super::steps::{Inside, Steps};
use crate::kernel::absorb::Light;
use crate::kernel::classify::Transfer;
use crate::kernel::trilinear::CELLS;
use crate::vector::{load3, splat3};
use crate::{Column, Columns3};

/// Rays of a group: nodes are passed by group by group.
const GROUP: usize = 16;
/// Nodes that may wait: seven for each level below the first, of which there are at most 16.
const WAITING: usize = 128;

/// How values between samples are taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Between {
    /// Interpolated.
    Linear,
    /// That of the nearest sample: for labels.
    Nearest,
}

/// A medium in a grid.
#[derive(Clone, Copy)]
pub struct March<'a> {
    /// The values.
    pub field: &'a dyn Field,
    /// What they look like.
    pub transfer: &'a Transfer,
    /// Between samples.
    pub between: Between,
    /// The longest step, in units of cells. That of the nearest samples has no steps: these are where they change.
    pub step: f32,
    /// Lights; without any, what is emitted is seen as it is.
    pub lighting: Option<&'a Lighting>,
}

impl core::fmt::Debug for March<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("March").field("step", &self.step).finish_non_exhaustive()
    }
}

/// What comes of a march, and what it needs on the way.
#[derive(Clone, Debug)]
pub struct Marched {
    /// What the medium adds, as it arrives where rays start, linear RGB.
    pub radiance: Columns3<WIDTH>,
    /// The part of the light from behind that comes through.
    pub transmittance: Column<f32, WIDTH>,
    samples: BrickSamples,
    lights: Vec<[[f32; 16]; 9]>,
}

impl Default for Marched {
    fn default() -> Self {
        let zero = Column::splat(0.0);
        Self { radiance: [zero; 3], transmittance: zero, samples: BrickSamples::ZERO, lights: Vec::new() }
    }
}

/// A node that waits to be visited.
#[derive(Clone, Copy)]
struct Node {
    level: usize,
    at: [usize; 3],
    groups: u32,
}

/// Marches passages through a medium. The task of [`March::task`].
#[derive(Debug)]
pub struct MarchTask<'a> {
    march: March<'a>,
    passages: &'a Passages,
    out: &'a mut Marched,
}

impl<'a> March<'a> {
    /// What marches passages: to be run at a level.
    pub fn task(self, passages: &'a Passages, out: &'a mut Marched) -> MarchTask<'a> {
        MarchTask { march: self, passages, out }
    }
}

impl Task for MarchTask<'_> {
    type Output = ();

    #[inline(always)]
    fn run<T: Token>(self, token: T) {
        let Self { march, passages, out } = self;
        let rows = 0..passages.count.next_multiple_of(GROUP);
        for column in &mut out.radiance {
            column[rows.clone()].fill(0.0);
        }
        out.transmittance[rows].fill(1.0);
        for (octant, groups) in by_octant(passages).into_iter().enumerate() {
            if groups != 0 {
                march.walk(token, passages, out, octant as u32, groups);
            }
        }
    }
}

/// For each set of signs, the groups with rays whose directions have these, and that go through the grid.
fn by_octant(passages: &Passages) -> [u32; 8] {
    let mut groups = [0; 8];
    for i in 0..passages.count {
        let there = passages.t0[i] < passages.t1[i];
        groups[passages.octant[i] as usize % 8] |= u32::from(there) << (i / GROUP);
    }
    groups
}

impl March<'_> {
    #[inline(always)]
    fn walk<T: Token>(&self, token: T, passages: &Passages, out: &mut Marched, octant: u32, groups: u32) {
        let layout = self.field.layout();
        let cells = [0, 1, 2].map(|axis| layout.cells(axis));
        let mut waiting = [Node { level: 0, at: [0; 3], groups: 0 }; WAITING];
        let mut count = 1;
        waiting[0] = Node { level: layout.levels().len() - 1, at: [0; 3], groups };
        while count > 0 {
            count -= 1;
            let node = waiting[count];
            let (mut low, mut high) = ([0.0; 3], [0.0; 3]);
            for axis in 0..3 {
                let size = CELLS[axis] << node.level;
                let first = node.at[axis] * size;
                (low[axis], high[axis]) = (first as f32, (first + size).min(cells[axis]) as f32);
            }
            let bounds = [splat3(token, low), splat3(token, high)];
            if node.level == 0 {
                self.brick(token, passages, out, octant, node, bounds);
                continue;
            }
            let (mut groups, mut left) = (0, node.groups);
            while left != 0 {
                let group = left.trailing_zeros() as usize % (WIDTH / GROUP);
                left &= left - 1;
                let mut at = group * GROUP;
                while at < (group + 1) * GROUP {
                    let inside = Inside::new(token, passages, &out.transmittance, at, octant, bounds);
                    groups |= u32::from(inside.rays.any()) << group;
                    at += T::LANES;
                }
            }
            if groups == 0 {
                continue;
            }
            let [least, greatest] = self.field.ranges(node.level - 1, node.at);
            // The last to be put there is the first to be visited: that from which no ray comes back.
            for i in (0..8).rev() {
                let slot = i ^ octant as usize;
                if self.transfer.is_visible(least[slot], greatest[slot]) && count < WAITING {
                    let at = [0, 1, 2].map(|axis| 2 * node.at[axis] + (slot >> axis & 1));
                    waiting[count] = Node { level: node.level - 1, at, groups };
                    count += 1;
                }
            }
        }
    }

    /// The rays of a node's groups in a brick.
    #[inline(always)]
    fn brick<T: Token>(
        &self,
        token: T,
        passages: &Passages,
        out: &mut Marched,
        octant: u32,
        node: Node,
        bounds: [[T::F32; 3]; 2],
    ) {
        let (mut left, mut loaded) = (node.groups, false);
        while left != 0 {
            let group = left.trailing_zeros() as usize % (WIDTH / GROUP);
            left &= left - 1;
            let mut at = group * GROUP;
            while at < (group + 1) * GROUP {
                let inside = Inside::new(token, passages, &out.transmittance, at, octant, bounds);
                if inside.rays.any() {
                    if !loaded {
                        self.field.samples(node.at, self.lighting.is_some(), &mut out.samples);
                        loaded = true;
                    }
                    self.rays(token, passages, out, at, inside, bounds);
                }
                at += T::LANES;
            }
        }
    }
    /// The rays from `at` in a brick.
    #[inline(always)]
    fn rays<T: Token>(
        &self,
        token: T,
        passages: &Passages,
        out: &mut Marched,
        at: usize,
        inside: Inside<T>,
        bounds: [[T::F32; 3]; 2],
    ) {
        let Marched { radiance, transmittance, samples, lights } = out;
        let light = Light { radiance: load3(token, radiance, at), transmittance: token.load(&transmittance[..], at) };
        let mut lit = None;
        if let Some(lighting) = self.lighting {
            lit = Some(Lit::new(token, lighting, lights, passages, at, [inside.near, inside.far]));
        }
        let steps = Steps::new(token, passages, at, inside, bounds, (self.transfer, samples, lit, light));
        let light = match self.between {
            Between::Linear => steps.linear(token, passages, self.step),
            Between::Nearest => steps.nearest(token, passages),
        };
        for (column, value) in radiance.iter_mut().zip(light.radiance) {
            value.store(&mut column[..], at);
        }
        light.transmittance.store(&mut transmittance[..], at);
    }
}
