//! A case before it is poured into a packet of some width: rays, primitives, the active range.

use alloc::vec::Vec;
use core::ops::Range;

use super::{Dice, Kernel, Style};
use crate::{Properties, oracle};

/// A ray in rows.
#[derive(Clone, Copy, Debug)]
pub struct DraftRay {
    /// Origin.
    pub origin: [f32; 3],
    /// Direction.
    pub direction: [f32; 3],
    /// Near end of the interval.
    pub t_min: f32,
    /// Far end of the interval.
    pub t_max: f32,
}

impl DraftRay {
    /// The ray in `f64`.
    pub fn exact(&self) -> oracle::Ray {
        let ray = oracle::Ray::new(self.origin, self.direction);
        oracle::Ray { t_min: f64::from(self.t_min), t_max: f64::from(self.t_max), ..ray }
    }

    /// The dominant axis as [`Rays::shears`](crate::Rays::shears) finds it.
    fn axis(&self) -> usize {
        let [x, y, z] = self.direction.map(f32::abs);
        if z > x && z > y {
            2
        } else if y > x {
            1
        } else {
            0
        }
    }
}

/// What a kernel is run on.
#[derive(Clone, Debug)]
pub struct Draft<P> {
    /// Rays, the inactive ones too.
    pub rays: Vec<DraftRay>,
    /// Which of them are active.
    pub range: Range<usize>,
    /// Primitives; their ids are their places.
    pub primitives: Vec<P>,
    /// What is true of the active rays.
    pub promises: Properties,
}

impl<P> Draft<P> {
    /// Draws a case of `width` rays that keeps the promises of `K`: of every style, most rays aimed at something.
    pub fn draw<K: Kernel<Primitive = P>>(dice: &mut Dice<'_>, width: usize) -> Self {
        dice.draw_style();
        let count = 1 + dice.below(5);
        let mut primitives: Vec<P> = (0..count).map(|_| K::draw(dice)).collect();
        K::number(&mut primitives);
        if dice.one_in(2) {
            dice.draw_style();
        }
        let range = if dice.one_in(2) {
            let begin = dice.below(width + 1);
            begin..begin + dice.below(width - begin + 1)
        } else {
            0..width
        };
        let common = dice.point();
        let limited = dice.one_in(3);
        let rays = (0..width).map(|_| {
            let origin = if K::PROMISES.contains(Properties::COMMON_ORIGIN) { common } else { dice.point() };
            let mut direction = dice.point();
            if !dice.one_in(4) {
                let at = dice.below(count);
                let target = K::aim(dice, &primitives[at]);
                for axis in 0..3 {
                    direction[axis] = target[axis] - origin[axis];
                }
            }
            let (t_min, t_max) = if limited { (dice.value(), dice.value()) } else { (0.0, f32::INFINITY) };
            DraftRay { origin, direction, t_min, t_max }
        });
        let mut draft = Self { rays: rays.collect(), range, primitives, promises: K::PROMISES };
        draft.keep_promises(K::PARALLEL);
        draft
    }

    /// What kernels are timed on: the packet of a pinhole camera, and small primitives of which it misses most.
    pub fn timed<K: Kernel<Primitive = P>>(width: usize) -> Self {
        let mut dice = Dice::from_seed(2006);
        dice.set_style(Style::Ordinary);
        let mut primitives: Vec<P> = (0..K::PRIMITIVES).map(|_| K::draw(&mut dice)).collect();
        K::number(&mut primitives);
        let side = (1..=width).find(|side| side * side >= width).unwrap_or(1);
        let ray = |i| {
            let (x, y) = ((i % side) as f32, (i / side) as f32);
            let direction = [-0.25 + 0.01 * x, -0.2 + 0.01 * y, -1.0];
            DraftRay { origin: [0.1, 0.2, 3.0], direction, t_min: 0.0, t_max: f32::INFINITY }
        };
        let rays = (0..width).map(ray).collect();
        let mut draft = Self { rays, range: 0..width, primitives, promises: K::PROMISES };
        K::timed(&mut draft);
        draft.keep_promises(K::PARALLEL);
        draft
    }

    /// Bends the directions until the promises are true.
    fn keep_promises(&mut self, parallel: bool) {
        let Some(first) = self.rays.get(self.range.start).or(self.rays.first()).copied() else { return };
        for ray in &mut self.rays {
            if parallel {
                // As seen from a plane: the packet's image stays, where the first ray went.
                if ray.origin == first.origin {
                    ray.origin = [0, 1, 2].map(|k| first.origin[k] + 4.0 * (ray.direction[k] - first.direction[k]));
                }
                ray.direction = first.direction;
            }
            let d = &mut ray.direction;
            if self.promises.contains(Properties::NORMALIZED_DIRECTIONS) {
                let length = libm::sqrt(d.iter().map(|&x| f64::from(x) * f64::from(x)).sum());
                let unit = d.map(|x| (f64::from(x) / length) as f32);
                // NaN and infinities stay; what has no direction gets one.
                *d = if length > 0.0 { unit } else { [1.0, 0.0, 0.0] };
            }
            if self.promises.contains(Properties::CONSTANT_AXIS) {
                let (from, to) = (ray.axis(), first.axis());
                ray.direction.swap(from, to);
                if ray.axis() != to {
                    ray.direction = first.direction;
                }
            }
            if self.promises.contains(Properties::CONSTANT_SIGNS) {
                for (x, like) in ray.direction.iter_mut().zip(first.direction) {
                    *x = x.copysign(like);
                }
            }
        }
    }
}
