//! What a step through a medium is made of: a sample, what it looks like, what it does to the light. A test is a ray.

use alloc::boxed::Box;
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;

use mobula_simd::{F32Lanes, Token};

use crate::kernel::absorb::{Light, absorb};
use crate::kernel::classify::{Knot, Look, Transfer};
use crate::kernel::trilinear::{CELLS, Place, SAMPLES, Samples};
use crate::lab::find::in_reach;
use crate::lab::{Dice, Draft, Kernel, Outcome, Work};
use crate::vector::load3;

/// 2^-24.
const UNIT: f64 = 1.0 / (1 << 24) as f64;

/// Rays of the case that is timed: four by four pixels in a row, as groups of a packet are, a quarter of a cell apart.
fn pixel(i: usize) -> [f32; 2] {
    let (group, at) = (i / 16, i % 16);
    [(group % 4 * 4 + at % 4) as f32 * 0.25, (group / 4 * 4 + at / 4) as f32 * 0.25]
}

/// A sample at the origins of rays, which are moved from -1 to 1 to the ends of a brick: interpolated, or the nearest one.
#[derive(Debug)]
pub struct Sample<const NEAREST: bool>;

/// Where an origin is in a brick: the same in single precision everywhere.
fn point(origin: [f32; 3]) -> [f32; 3] {
    [0, 1, 2].map(|axis| {
        let (x, most) = ((origin[axis] + 1.0) * (CELLS[axis] as f32 * 0.5), CELLS[axis] as f32);
        if x > 0.0 { if x < most { x } else { most } } else { 0.0 }
    })
}

impl<const NEAREST: bool> Kernel for Sample<NEAREST> {
    type Primitive = Box<Samples>;
    type General = Self;
    const PRIMITIVES: usize = 1;

    fn draw(dice: &mut Dice<'_>) -> Box<Samples> {
        let mut samples = Box::new(Samples::ZERO);
        for k in 0..SAMPLES[2] {
            for j in 0..SAMPLES[1] {
                let mut row = [0.0; SAMPLES[0]];
                row.iter_mut().for_each(|value| *value = dice.value());
                samples.set_row(j, k, &row);
            }
        }
        samples
    }

    fn timed(draft: &mut Draft<Box<Samples>>) {
        for (i, ray) in draft.rays.iter_mut().enumerate() {
            let [x, y] = pixel(i);
            ray.origin = [0.2 * x - 0.9, 0.4 * y - 0.9, 0.1 * x + 0.05 * y - 0.3];
        }
    }

    fn aim(dice: &mut Dice<'_>, _: &Box<Samples>) -> [f32; 3] {
        dice.point()
    }

    fn extra(rays: usize, primitives: usize) -> usize {
        rays * primitives
    }

    #[inline(always)]
    fn reset<const N: usize>(_work: &mut Work<Box<Samples>, N>) {}

    #[inline(always)]
    fn run<T: Token, const N: usize>(token: T, work: &mut Work<Box<Samples>, N>) {
        let (zero, one) = (token.splat(0.0), token.splat(1.0));
        // The twin runs in a wider packet than the answers are for.
        let width = work.extra.len() / work.primitives.len().max(1);
        for (samples, out) in work.primitives.iter().zip(work.extra.chunks_exact_mut(width.max(1))) {
            let mut at = 0;
            while at < width {
                let mut point = load3(token, work.rays.origins(), at);
                for axis in 0..3 {
                    let most = token.splat(CELLS[axis] as f32);
                    point[axis] = ((point[axis] + one) * (most * token.splat(0.5))).max(zero).min(most);
                }
                let place = Place::new(token, point);
                let value = if NEAREST { place.nearest(token, samples) } else { place.value(token, samples) };
                value.store_masked(out, at, work.rays.active(token, at));
                at += T::LANES;
            }
        }
    }

    fn verify(draft: &Draft<Box<Samples>>, outcome: &Outcome) -> Result<(), String> {
        for (number, samples) in draft.primitives.iter().enumerate() {
            for i in draft.range.clone() {
                let at = point(draft.rays[i].origin);
                let cell = [0, 1, 2].map(|axis| (at[axis] as usize).min(CELLS[axis] - 1));
                let (mut want, mut sum, mut usual) = (0.0, 0.0, true);
                for corner in 0..8 {
                    let side = [0, 1, 2].map(|axis| corner >> axis & 1);
                    let value = samples.at([0, 1, 2].map(|axis| cell[axis] + side[axis]));
                    let weight: f64 = (0..3)
                        .map(|axis| {
                            let part = f64::from(at[axis]) - cell[axis] as f64;
                            let part = if NEAREST { f64::from(u8::from(part >= 0.5)) } else { part };
                            if side[axis] == 1 { part } else { 1.0 - part }
                        })
                        .product();
                    if NEAREST && weight == 0.0 {
                        continue;
                    }
                    usual &= in_reach(value);
                    want += weight * f64::from(value);
                    sum += f64::from(value).abs();
                }
                let got = f64::from(outcome.extra(number * draft.rays.len() + i));
                if usual && (got - want).abs() > 16.0 * UNIT * sum {
                    return Err(format!("ray {i}: {got:e} at {at:?}, and {want:e} is right"));
                }
            }
        }
        Ok(())
    }
}

/// A transfer function, and its knots.
#[derive(Clone, Debug)]
pub struct Function {
    knots: Vec<Knot>,
    transfer: Transfer,
}

/// What is between two values, which are x and y of the origins of rays.
#[derive(Debug)]
pub struct Classify;

impl Kernel for Classify {
    type Primitive = Function;
    type General = Self;
    const PRIMITIVES: usize = 1;

    fn draw(dice: &mut Dice<'_>) -> Function {
        let count = [1, 2, 3, 6, 9, 14, 15, 16, 40][dice.below(9)];
        let mut knots: Vec<Knot> = (0..count)
            .map(|_| Knot {
                value: dice.value(),
                color: [dice.unit(), dice.unit(), dice.unit()],
                extinction: if dice.one_in(3) { 0.0 } else { 4.0 * dice.unit() },
            })
            .filter(|knot| knot.value.is_finite())
            .collect();
        knots.sort_by(|a, b| a.value.total_cmp(&b.value));
        Function { transfer: Transfer::new(&knots), knots }
    }

    fn timed(draft: &mut Draft<Function>) {
        let knot = |i: usize| Knot {
            value: 0.2 * i as f32 - 0.8,
            color: [0.1 * i as f32, 0.5, 0.3],
            extinction: (i % 3) as f32,
        };
        let knots: Vec<_> = (0..9).map(knot).collect();
        draft.primitives = alloc::vec![Function { transfer: Transfer::new(&knots), knots }];
        for (i, ray) in draft.rays.iter_mut().enumerate() {
            let [x, y] = pixel(i);
            ray.origin = [0.2 * x - 0.4, 0.2 * x + 0.02 * y - 0.38, 0.0];
        }
    }

    fn aim(dice: &mut Dice<'_>, function: &Function) -> [f32; 3] {
        // Knots themselves, and what is between.
        match function.knots.get(dice.below(2 * function.knots.len().max(1))) {
            Some(knot) => [knot.value, dice.value(), 0.0],
            None => dice.point(),
        }
    }

    fn extra(rays: usize, primitives: usize) -> usize {
        4 * rays * primitives
    }

    #[inline(always)]
    fn reset<const N: usize>(_work: &mut Work<Function, N>) {}

    #[inline(always)]
    fn run<T: Token, const N: usize>(token: T, work: &mut Work<Function, N>) {
        let width = work.extra.len() / work.primitives.len().max(1) / 4;
        for (function, out) in work.primitives.iter().zip(work.extra.chunks_exact_mut((4 * width).max(1))) {
            let mut at = 0;
            while at < width {
                let [from, to, _] = load3(token, work.rays.origins(), at);
                let start = Look::new(token, &function.transfer, from);
                let end = Look::new(token, &function.transfer, to);
                let seen = start.until(token, &function.transfer, &end);
                for (seen, out) in seen.into_iter().zip(out.chunks_exact_mut(width)) {
                    seen.store_masked(out, at, work.rays.active(token, at));
                }
                at += T::LANES;
            }
        }
    }

    fn verify(draft: &Draft<Function>, outcome: &Outcome) -> Result<(), String> {
        for (number, function) in draft.primitives.iter().enumerate() {
            let knots = &function.knots;
            let usual = knots.iter().all(|knot| in_reach(knot.value));
            let range = knots.first().zip(knots.last()).map_or(0.0, |(a, b)| f64::from(b.value) - f64::from(a.value));
            for i in draft.range.clone() {
                let [from, to, _] = draft.rays[i].origin;
                let got = [0, 1, 2, 3].map(|k| outcome.extra((4 * number + k) * draft.rays.len() + i));
                // Samples are finite or NaN.
                if from.is_infinite() || to.is_infinite() {
                    continue;
                }
                if let Some(bad) = got.iter().find(|x| !x.is_finite()) {
                    return Err(format!("ray {i}: {bad} from {from:e} to {to:e}"));
                }
                // Values that are so close that rounding decides on which side of a knot they are.
                let (from, to) = (f64::from(from), f64::from(to));
                if !usual
                    || (to - from).is_nan()
                    || (to - from).abs() <= range / 2048.0
                    || from.abs().max(to.abs()) > 1e6
                {
                    continue;
                }
                let want = average(knots, from.min(to), from.max(to));
                for k in 0..4 {
                    if (f64::from(got[k]) - want[k]).abs() > 0.02 {
                        return Err(format!("ray {i}: {got:?} from {from:e} to {to:e}, and {want:?} is right"));
                    }
                }
            }
        }
        Ok(())
    }
}

/// What is on average from `low` to `high`: extinction, and extinction times colour.
fn average(knots: &[Knot], low: f64, high: f64) -> [f64; 4] {
    let mut ends: Vec<f64> = knots.iter().map(|knot| f64::from(knot.value)).filter(|x| *x > low && *x < high).collect();
    ends.extend([low, high]);
    ends.sort_by(f64::total_cmp);
    let mut sum = [0.0; 4];
    for piece in ends.windows(2) {
        let middle = 0.5 * (piece[0] + piece[1]);
        let next = knots.iter().position(|knot| f64::from(knot.value) > middle).unwrap_or(knots.len());
        // What the function is at x, by the knots around the middle.
        let at = |x: f64| {
            let numbers = |knot: &Knot| [knot.extinction, knot.color[0], knot.color[1], knot.color[2]].map(f64::from);
            match (next.checked_sub(1).map(|i| &knots[i]), knots.get(next)) {
                (Some(a), Some(b)) => {
                    let part = (x - f64::from(a.value)) / (f64::from(b.value) - f64::from(a.value));
                    let (a, b) = (numbers(a), numbers(b));
                    [0, 1, 2, 3].map(|k| a[k] * (1.0 - part) + b[k] * part)
                }
                (Some(only), None) | (None, Some(only)) => numbers(only),
                (None, None) => [0.0; 4],
            }
        };
        let (a, m, b) = (at(piece[0]), at(middle), at(piece[1]));
        for k in 0..4 {
            let color = |c: [f64; 4]| if k == 0 { 1.0 } else { c[k] };
            // Simpson's rule is exact for these.
            let value = a[0] * color(a) + 4.0 * m[0] * color(m) + b[0] * color(b);
            sum[k] += (piece[1] - piece[0]) * value / 6.0;
        }
    }
    sum.map(|x| x / (high - low))
}

/// A stretch of a medium: extinction, transmittance before it, and length are x, y, z of the origins of rays, less their signs;
/// directions are what is emitted.
#[derive(Debug)]
pub struct Absorb;

impl Kernel for Absorb {
    type Primitive = ();
    type General = Self;
    const PRIMITIVES: usize = 0;

    fn draw(_dice: &mut Dice<'_>) {}

    fn aim(dice: &mut Dice<'_>, (): &()) -> [f32; 3] {
        dice.point()
    }

    fn tests(rays: usize, _primitives: usize) -> usize {
        rays
    }

    fn extra(rays: usize, _primitives: usize) -> usize {
        4 * rays
    }

    #[inline(always)]
    fn reset<const N: usize>(_work: &mut Work<(), N>) {}

    #[inline(always)]
    fn run<T: Token, const N: usize>(token: T, work: &mut Work<(), N>) {
        let width = work.extra.len() / 4;
        let mut at = 0;
        while at < width {
            let [extinction, transmittance, length] = load3(token, work.rays.origins(), at);
            let [r, g, b] = load3(token, work.rays.directions(), at);
            let mut light = Light { radiance: [token.splat(0.25); 3], transmittance: transmittance.abs() };
            absorb(token, &mut light, [extinction.abs(), r, g, b], length.abs());
            let active = work.rays.active(token, at);
            let [red, green, blue] = light.radiance;
            for (value, out) in
                [red, green, blue, light.transmittance].into_iter().zip(work.extra.chunks_exact_mut(width))
            {
                value.store_masked(out, at, active);
            }
            at += T::LANES;
        }
    }

    fn verify(draft: &Draft<()>, outcome: &Outcome) -> Result<(), String> {
        for i in draft.range.clone() {
            let [extinction, transmittance, length] = draft.rays[i].origin.map(|x| f64::from(x).abs());
            let emission = draft.rays[i].direction.map(f64::from);
            let got = [0, 1, 2, 3].map(|k| f64::from(outcome.extra(k * draft.rays.len() + i)));
            let all = [extinction, transmittance, length].into_iter().chain(emission);
            if all.into_iter().any(|x| !in_reach(x as f32)) {
                continue;
            }
            let depth = extinction * length;
            let through = libm::exp(-depth);
            let out = if depth > 0.0 { -libm::expm1(-depth) / depth } else { 1.0 };
            let mut want = [0.25, 0.25, 0.25, transmittance * through];
            for k in 0..3 {
                want[k] += transmittance * length * out * emission[k];
            }
            for k in 0..4 {
                let size = if k < 3 { 0.25 + (want[k] - 0.25).abs() } else { transmittance };
                if (got[k] - want[k]).abs() > 64.0 * UNIT * size {
                    return Err(format!("ray {i}: {got:?}, and {want:?} is right"));
                }
            }
        }
        Ok(())
    }
}
