//! Ray/iso-surface in a trilinear cell: see [`crate::kernel::iso_cell`].

use alloc::vec::Vec;

use mobula_simd::{Scalar, Token};

use crate::Rays;
use crate::kernel::cell_walk::RayLanes;
use crate::kernel::iso_cell::iso_cell;
use crate::lab::Dice;
use crate::lab::find::{RayTest, in_reach, ray_in_reach};
use crate::oracle::{self, Truth};
use crate::vector::load3;

/// A cell of a volume, with the surface where its field is zero.
#[derive(Clone, Copy, Debug)]
pub struct Cell {
    /// Least corner.
    pub low: [f32; 3],
    /// Length of an edge.
    pub size: f32,
    /// Values at the corners; x, y, z are bits 0, 1, 2 of the index.
    pub values: [f32; 8],
}

/// The test. A common origin saves three subtractions of some two hundred operations: no case.
#[derive(Debug)]
pub struct IsoCell;

/// A cell for a packet: low corner, 1 / size, size, values.
#[derive(Clone, Copy, Debug)]
pub struct Prepared<F> {
    low: [F; 3],
    per_size: F,
    size: F,
    corners: [F; 8],
}

impl RayTest for IsoCell {
    type Primitive = Cell;
    type General = Self;
    type Common = ();
    type Prepared<T: Token> = Prepared<T::F32>;

    fn draw(dice: &mut Dice<'_>) -> Cell {
        let low = dice.point();
        let size = [0.25, 0.125, 0.3, dice.value().abs()][dice.below(4)];
        let mut values = [0.0; 8];
        for value in &mut values {
            *value = dice.value();
        }
        Cell { low, size, values }
    }

    fn aim(dice: &mut Dice<'_>, cell: &Cell) -> [f32; 3] {
        let corner = dice.below(16);
        let inside = [dice.unit(), dice.unit(), dice.unit()];
        [0, 1, 2].map(|k| cell.low[k] + cell.size * if corner < 8 { (corner >> k & 1) as f32 } else { inside[k] })
    }

    fn derive<const N: usize>(rays: &mut Rays<N>) {
        // The same bits at every level.
        rays.inverse_directions(Scalar::new());
    }

    #[inline(always)]
    fn common<T: Token, const N: usize>(_token: T, _rays: &Rays<N>) {}

    #[inline(always)]
    fn prepare<T: Token>(token: T, cell: &Cell, (): ()) -> Prepared<T::F32> {
        Prepared {
            low: [token.splat(cell.low[0]), token.splat(cell.low[1]), token.splat(cell.low[2])],
            per_size: token.splat(1.0 / cell.size),
            size: token.splat(cell.size),
            corners: cell.values.map(|value| token.splat(value + 0.0)),
        }
    }

    #[inline(always)]
    fn test<T: Token, const N: usize>(
        token: T,
        cell: &Prepared<T::F32>,
        _i: usize,
        (): (),
        rays: &Rays<N>,
        at: usize,
    ) -> (T::Mask, T::F32) {
        let mut origin = load3(token, rays.origins(), at);
        let mut direction = load3(token, rays.directions(), at);
        let mut inverse = load3(token, rays.inverse_columns(), at);
        for axis in 0..3 {
            origin[axis] = (origin[axis] - cell.low[axis]) * cell.per_size;
            direction[axis] = direction[axis] * cell.per_size;
            inverse[axis] = inverse[axis] * cell.size;
        }
        let (t_min, t_max) = (token.load(&rays.t_min()[..], at), token.load(&rays.t_max[..], at));
        let rays = RayLanes { origin, direction, inverse, t_min };
        iso_cell::<T, false>(token, token.mask(u32::MAX), &cell.corners, [token.splat(0.0); 3], &rays, t_max)
    }

    fn truth(cell: &Cell, _i: usize, ray: &oracle::ExactRay) -> Option<(Truth, f64)> {
        let usual = ray.direction.iter().all(|&d| in_reach(d as f32)) && ray_in_reach(ray) && cell.size > 1e-3;
        if !usual || !cell.low.iter().chain(&cell.values).all(|&x| in_reach(x)) || !in_reach(cell.size) {
            return None;
        }
        if ray.t_min.is_nan() || ray.t_max.is_nan() {
            return Some((Truth { t: None, margin: f64::INFINITY }, 0.0));
        }
        Exact::new(cell, ray).truth(Self::GUARD)
    }
}

/// The field along a ray, in `f64`.
struct Exact {
    /// Cubic in t, from the constant up.
    cubic: [f64; 4],
    /// The ray is in the cell, and in its interval, from `near` to `far`.
    near: f64,
    far: f64,
    /// How far off single precision may be: in t, and in the value.
    t_error: f64,
    error: f64,
    /// Greatest distance involved, in cells.
    reach: f64,
}

impl Exact {
    fn new(cell: &Cell, ray: &oracle::ExactRay) -> Self {
        let size = f64::from(cell.size);
        let mut cubic = [0.0; 4];
        let (mut near, mut far) = (ray.t_min, ray.t_max);
        // Distances are off by roundings of coordinates: 2^-24 of them, a few times.
        let mut reach = 1.0f64;
        let mut slowest = f64::INFINITY;
        for axis in 0..3 {
            let (o, low, d) = (ray.origin[axis], f64::from(cell.low[axis]), ray.direction[axis]);
            reach = reach.max((o.abs() + low.abs()) / size + 1.0);
            if d == 0.0 {
                // Along a face, or nearly: in and out are both right.
                if (o - low).abs().min((o - low - size).abs()) < 1e-6 * (o.abs() + low.abs() + size) {
                    slowest = 0.0;
                }
                if o < low || o > low + size {
                    far = f64::NEG_INFINITY;
                }
                continue;
            }
            slowest = slowest.min(d.abs());
            let (a, b) = ((low - o) / d, (low + size - o) / d);
            (near, far) = (near.max(a.min(b)), far.min(a.max(b)));
        }
        for (corner, &value) in cell.values.iter().enumerate() {
            // The product of three linear weights.
            let mut weight = [f64::from(value), 0.0, 0.0, 0.0];
            for axis in 0..3 {
                let p = (ray.origin[axis] - f64::from(cell.low[axis])) / size;
                let d = ray.direction[axis] / size;
                let (p, d) = if corner >> axis & 1 != 0 { (p, d) } else { (1.0 - p, -d) };
                weight = [
                    weight[0] * p,
                    weight[1] * p + weight[0] * d,
                    weight[2] * p + weight[1] * d,
                    weight[3] * p + weight[2] * d,
                ];
            }
            for (sum, part) in cubic.iter_mut().zip(weight) {
                *sum += part;
            }
        }
        let unit = 1.0 / f64::from(1u32 << 24);
        let sum: f64 = cell.values.iter().map(|&v| f64::from(v).abs()).sum();
        let longest = ray.direction.iter().fold(0.0f64, |l, d| l.max(d.abs()));
        // A plane met at a small angle moves far along the ray, which moves the start of the cubic with it.
        let t_error = 8.0 * unit * reach * size / slowest.min(longest) + 4.0 * unit * near.abs().min(1e9);
        Self { cubic, near, far, t_error, error: 64.0 * unit * sum * reach, reach }
    }

    fn at(&self, t: f64) -> f64 {
        let [d, c, b, a] = self.cubic;
        ((a * t + b) * t + c) * t + d
    }

    /// Ends of the pieces between `from` and `to` in which the cubic is monotone.
    fn pieces(&self, from: f64, to: f64) -> Vec<f64> {
        let [_, c, b, a] = self.cubic;
        let root = libm::sqrt((b * b - 3.0 * a * c).max(0.0));
        let sum = -(b + root.copysign(b));
        let mut ends: Vec<f64> = [sum / (3.0 * a), c / sum].into_iter().filter(|t| *t > from && *t < to).collect();
        ends.extend([from, to]);
        ends.sort_by(f64::total_cmp);
        ends
    }

    /// The first t at or after `from` where the value is on the other side of `level` than at `from`.
    fn crossing(&self, level: f64, from: f64, to: f64) -> Option<f64> {
        let above = self.at(from) > level;
        let ends = self.pieces(from, to);
        let piece = ends.windows(2).find(|piece| (self.at(piece[1]) > level) != above)?;
        let (mut low, mut high) = (piece[0], piece[1]);
        for _ in 0..100 {
            let middle = 0.5 * (low + high);
            if (self.at(middle) > level) == above { low = middle } else { high = middle }
        }
        Some(high)
    }

    fn truth(&self, guard: f64) -> Option<(Truth, f64)> {
        let clear = |t| Truth { t, margin: f64::INFINITY };
        let (from, to) = (self.near - self.t_error, self.far + self.t_error);
        // From too far away the cubic in t cancels even in f64.
        if self.reach > 1e3 || self.t_error.is_infinite() || from.is_nan() || to.is_nan() {
            return None;
        }
        if from > to {
            return Some((clear(None), 0.0));
        }
        // Never within reach of zero, anywhere around: missed for sure.
        let ends = self.pieces(from, to);
        let is_side = |side: f64, t: &f64| side * self.at(*t) > self.error;
        if ends.iter().all(|t| is_side(1.0, t)) || ends.iter().all(|t| is_side(-1.0, t)) {
            return Some((clear(None), 0.0));
        }
        // Clearly on one side and then clearly on the other, well inside: hit for sure, not before the value first comes
        // near zero, and not after it is clearly on the other side.
        let (inner, outer) = (self.near + self.t_error, self.far - self.t_error);
        if inner.is_nan() || inner >= outer {
            return None;
        }
        let start = self.pieces(inner, outer).into_iter().find(|t| self.at(*t).abs() > self.error)?;
        let side = self.at(start).signum();
        let last = self.crossing(-side * self.error, start, outer)?;
        let first_side = self.at(from).signum();
        let first =
            if self.at(from).abs() <= self.error { from } else { self.crossing(first_side * self.error, from, to)? };
        let (first, last) = (first - self.t_error, last + self.t_error);
        Some((clear(Some(0.5 * (first + last))), 0.5 * (last - first) / guard))
    }
}
