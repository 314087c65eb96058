//! Light through a medium that a grid describes: what it adds and what it takes, along the ways of rays.
//!
//! Bricks are visited from front to back: of the eight that a node is made of, those that rays of one set of signs leave first come
//! first, which is right for all rays with these signs, wherever they start. So rays are walked once for each set of signs among them,
//! and a brick is loaded once for all of them. Nodes in which the transfer function shows nothing are passed by: that is asked of the
//! least and the greatest value of a node as it is met, so that there is nothing to keep up to date when the function changes.
//!
//! In a brick, the way of a ray is cut into equal steps, none longer than asked for in units of cells. So steps follow the spacing of the
//! grid in each direction, and what comes out for a ray depends on that ray alone. Values are interpolated at the ends of steps, and
//! what is between them is [classified](crate::kernel::classify) as a whole.

use alloc::vec::Vec;

use mobula_simd::{F32Lanes, I32Lanes, MaskLanes, Task, Token};

use super::field::Field;
use super::lighting::{Lighting, Lit};
use super::passage::{Passages, WIDTH};
use super::samples::BrickSamples;
use crate::kernel::absorb::{Light, absorb};
use crate::kernel::classify::{Look, Transfer};
use crate::kernel::trilinear::{CELLS, Place};
use crate::vector::{load3, splat3};
use crate::{Column, Columns3};

/// Rays of a group: nodes are passed by group by group.
const GROUP: usize = 16;
/// A ray with less light than this is at its end: it could not become brighter by more than this part of what is behind.
const DARK: f32 = 1.0 / 1024.0;
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
    /// The longest step, in units of cells.
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

/// The rays of a vector in a box: which are in it, and from where to where.
struct Inside<T: Token> {
    rays: T::Mask,
    near: T::F32,
    far: T::F32,
}

impl<T: Token> Inside<T> {
    /// Of the rays from `at` with these signs.
    #[inline(always)]
    fn new(
        token: T,
        passages: &Passages,
        transmittance: &Column<f32, WIDTH>,
        at: usize,
        octant: u32,
        bounds: [[T::F32; 3]; 2],
    ) -> Self {
        let origin = load3(token, &passages.origin, at);
        let inverse = load3(token, &passages.inverse, at);
        let mut near = token.load(&passages.t0[..], at);
        let mut far = token.load(&passages.t1[..], at);
        for axis in 0..3 {
            let low = (bounds[0][axis] - origin[axis]) * inverse[axis];
            let high = (bounds[1][axis] - origin[axis]) * inverse[axis];
            near = low.min(high).max(near);
            far = low.max(high).min(far);
        }
        let here = I32Lanes::eq(token.load_u32(&passages.octant[..], at), token.splat_i32(octant as i32));
        let lit = token.load(&transmittance[..], at).gt(token.splat(DARK));
        let rays = near.lt(far) & here & lit & token.first(passages.count.saturating_sub(at));
        Self { rays, near, far }
    }
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
                    self.steps(token, passages, out, at, inside, bounds);
                }
                at += T::LANES;
            }
        }
    }

    /// The rays from `at` in a brick.
    #[inline(always)]
    fn steps<T: Token>(
        &self,
        token: T,
        passages: &Passages,
        out: &mut Marched,
        at: usize,
        Inside { rays, near, far }: Inside<T>,
        [low, high]: [[T::F32; 3]; 2],
    ) {
        let (zero, one, half) = (token.splat(0.0), token.splat(1.0), token.splat(0.5));
        let Marched { radiance, transmittance, samples, lights } = out;
        let mut light =
            Light { radiance: load3(token, radiance, at), transmittance: token.load(&transmittance[..], at) };
        let direction = load3(token, &passages.direction, at);
        let mut origin = load3(token, &passages.origin, at);
        let mut size = [zero; 3];
        for axis in 0..3 {
            (origin[axis], size[axis]) = (origin[axis] - low[axis], high[axis] - low[axis]);
        }
        // Whole steps of one length.
        let way = (far - near) * token.load(&passages.cells[..], at);
        let steps = way * token.splat(1.0 / self.step);
        let whole = steps.to_i32().to_f32();
        let count = (whole + one.select(whole.lt(steps), zero)).max(one);
        let dt = (far - near) / count;
        let length = dt * token.load(&passages.space[..], at);
        let per_count = one / count;
        let most = count.select(rays, zero).reduce_max() as usize;
        let mut lit = None;
        if let Some(lighting) = self.lighting {
            lit = Some(Lit::new(token, lighting, lights, passages, at, [near, far]));
        }

        let nearest = self.between == Between::Nearest;
        let start = inside_of(origin, direction, near, size, zero);
        let mut last = Look::new(token, self.transfer, Place::new(token, start).value(token, &samples.values));
        let mut rays = rays;
        for step in 1..=most {
            let number = token.splat(step as f32);
            let seen = if nearest {
                let middle = dt.mul_add(number - half, near);
                let place = Place::new(token, inside_of(origin, direction, middle, size, zero));
                let look = Look::new(token, self.transfer, place.nearest(token, &samples.values));
                let [extinction, r, g, b] = look.seen;
                [extinction, extinction * r, extinction * g, extinction * b]
            } else {
                let end = dt.mul_add(number, near);
                let place = Place::new(token, inside_of(origin, direction, end, size, zero));
                let look = Look::new(token, self.transfer, place.value(token, &samples.values));
                let seen = last.until(token, self.transfer, &look);
                last = look;
                seen
            };
            let shown = rays & seen[0].gt(zero);
            if shown.any() {
                let mut seen = seen;
                if let Some(lit) = &lit {
                    let middle = number - half;
                    let point = inside_of(origin, direction, dt.mul_add(middle, near), size, zero);
                    let place = Place::new(token, point);
                    let mut gradient = [zero; 3];
                    for axis in 0..3 {
                        gradient[axis] = place.value(token, &samples.gradients[axis]);
                    }
                    lit.light(token, &mut seen, gradient, direction, middle * per_count);
                }
                let before = light;
                absorb(token, &mut light, seen, length);
                for (now, then) in light.radiance.iter_mut().zip(before.radiance) {
                    *now = now.select(shown, then);
                }
                light.transmittance = light.transmittance.select(shown, before.transmittance);
                rays = rays & light.transmittance.gt(token.splat(DARK));
            }
            rays = rays & number.lt(count);
            if !rays.any() {
                break;
            }
        }
        for (column, value) in radiance.iter_mut().zip(light.radiance) {
            value.store(&mut column[..], at);
        }
        light.transmittance.store(&mut transmittance[..], at);
    }
}

/// The point of a ray at t, within a box from 0 to `size`.
#[inline(always)]
fn inside_of<F: F32Lanes>(origin: [F; 3], direction: [F; 3], t: F, size: [F; 3], zero: F) -> [F; 3] {
    [
        direction[0].mul_add(t, origin[0]).max(zero).min(size[0]),
        direction[1].mul_add(t, origin[1]).max(zero).min(size[1]),
        direction[2].mul_add(t, origin[2]).max(zero).min(size[2]),
    ]
}
