//! What precedes intersection: reciprocal directions with signs, unit directions, shears, bounds. A test is a ray.

use alloc::format;
use alloc::string::String;

use mobula_simd::Token;

use crate::Properties;
use crate::kernel::bounds::packet_bounds;
use crate::kernel::edges::Window;
use crate::lab::find::in_reach;
use crate::lab::{Dice, Draft, Kernel, Outcome, Work};

/// What the operations have in common: no primitives, no aim, a test a ray.
macro_rules! of_rays {
    () => {
        type Primitive = ();
        const PRIMITIVES: usize = 0;

        fn draw(_dice: &mut Dice<'_>) {}

        fn aim(dice: &mut Dice<'_>, (): &()) -> [f32; 3] {
            dice.point()
        }

        fn tests(rays: usize, _primitives: usize) -> usize {
            rays
        }
    };
}

/// Is `got` within some units of the last place of `want`?
fn near(got: f32, want: f64) -> bool {
    (f64::from(got) - want).abs() <= 4.0 / f64::from(1u32 << 24) * want.abs()
}

/// [`Rays::inverse_directions`](crate::Rays::inverse_directions).
#[derive(Debug)]
pub struct Inverse;

impl Kernel for Inverse {
    type General = Self;
    of_rays!();

    #[inline(always)]
    fn reset<const N: usize>(work: &mut Work<(), N>) {
        work.rays.forget(Properties::HAVE_INVERSE_DIRECTIONS | Properties::HAVE_SIGNS | Properties::CONSTANT_SIGNS);
    }

    #[inline(always)]
    fn run<T: Token, const N: usize>(token: T, work: &mut Work<(), N>) {
        work.rays.inverse_directions(token);
    }

    fn verify(draft: &Draft<()>, outcome: &Outcome) -> Result<(), String> {
        let mut signs = [[false; 2]; 3];
        for i in draft.range.clone() {
            let greatest = draft.rays[i]
                .direction
                .into_iter()
                .fold(0.0, |g, d| if d.abs() > g || d.is_nan() { d.abs() } else { g });
            for (axis, (d, inverse)) in draft.rays[i].direction.into_iter().zip(outcome.inverse(i)).enumerate() {
                signs[axis][usize::from(d.is_sign_negative())] = true;
                let finite = inverse.is_finite() && (d.is_nan() || inverse.is_sign_negative() == d.is_sign_negative());
                if !d.is_nan()
                    && (!finite || in_reach(d) && d.abs() > greatest * 1e-11 && !near(inverse, 1.0 / f64::from(d)))
                {
                    return Err(format!("ray {i}: 1 / {d:e} is {inverse:e}"));
                }
            }
        }
        let constant = signs.iter().all(|[positive, negative]| !(*positive && *negative));
        if constant != outcome.properties().contains(Properties::CONSTANT_SIGNS) {
            return Err(format!("constant signs: {constant}, {:?}", outcome.properties()));
        }
        Ok(())
    }
}

/// [`Rays::normalize`](crate::Rays::normalize).
#[derive(Debug)]
pub struct Normalize;

impl Kernel for Normalize {
    type General = Self;
    of_rays!();

    #[inline(always)]
    fn reset<const N: usize>(_work: &mut Work<(), N>) {}

    #[inline(always)]
    fn run<T: Token, const N: usize>(token: T, work: &mut Work<(), N>) {
        work.rays.normalize(token);
    }

    fn verify(draft: &Draft<()>, outcome: &Outcome) -> Result<(), String> {
        for i in draft.range.clone() {
            let d = draft.rays[i].direction;
            let length = libm::sqrt(d.iter().map(|&x| f64::from(x) * f64::from(x)).sum());
            for (x, unit) in d.into_iter().zip(outcome.direction(i)) {
                if d.iter().all(|&x| in_reach(x)) && length > 0.0 && !near(unit, f64::from(x) / length) {
                    return Err(format!("ray {i}: {x:e} of {d:?} becomes {unit:e}"));
                }
            }
        }
        Ok(())
    }
}

/// [`Rays::shears`](crate::Rays::shears).
#[derive(Debug)]
pub struct Shears;

impl Kernel for Shears {
    type General = Self;
    of_rays!();

    #[inline(always)]
    fn reset<const N: usize>(work: &mut Work<(), N>) {
        work.rays.forget(Properties::HAVE_SHEARS | Properties::CONSTANT_AXIS);
    }

    #[inline(always)]
    fn run<T: Token, const N: usize>(token: T, work: &mut Work<(), N>) {
        work.rays.shears(token);
    }

    fn verify(draft: &Draft<()>, outcome: &Outcome) -> Result<(), String> {
        let axes = [[1, 2, 0], [2, 0, 1], [0, 1, 2]];
        for i in draft.range.clone() {
            let d = draft.rays[i].direction;
            let axis = outcome.axis(i) as usize;
            if axis > 2 {
                return Err(format!("ray {i}: axis {axis}"));
            }
            if d.iter().any(|x| x.is_nan()) {
                continue;
            }
            if d.iter().any(|x| x.abs() > d[axis].abs()) {
                return Err(format!("ray {i}: axis {axis} dominates {d:?}"));
            }
            let [x, y, z] = axes[axis].map(|k| f64::from(d[k]));
            let [sx, sy, sz] = outcome.shear(i);
            let right = near(sx, x / z) && near(sy, y / z) && near(sz, 1.0 / z);
            if d.iter().all(|&x| in_reach(x)) && z != 0.0 && !right {
                return Err(format!("ray {i}: shears {sx:e} {sy:e} {sz:e} of {d:?}"));
            }
        }
        Ok(())
    }
}

/// [`packet_bounds`].
#[derive(Debug)]
pub struct Bounds<const COMMON_ORIGIN: bool>;

impl<const COMMON_ORIGIN: bool> Kernel for Bounds<COMMON_ORIGIN> {
    type General = Bounds<false>;
    const PROMISES: Properties = if COMMON_ORIGIN { Properties::COMMON_ORIGIN } else { Properties::empty() };
    of_rays!();

    fn extra(_rays: usize, _primitives: usize) -> usize {
        14
    }

    #[inline(always)]
    fn derive<T: Token, const N: usize>(token: T, work: &mut Work<(), N>) {
        work.rays.inverse_directions(token);
    }

    #[inline(always)]
    fn reset<const N: usize>(_work: &mut Work<(), N>) {}

    #[inline(always)]
    fn run<T: Token, const N: usize>(token: T, work: &mut Work<(), N>) {
        let bounds = packet_bounds::<T, N, COMMON_ORIGIN>(token, &work.rays);
        for axis in 0..3 {
            for end in 0..2 {
                work.extra[axis * 4 + end] = bounds.origin[end][axis];
                work.extra[axis * 4 + 2 + end] = bounds.inverse[end][axis];
            }
        }
        (work.extra[12], work.extra[13]) = (bounds.t_min, bounds.t_max);
    }

    fn verify(draft: &Draft<()>, outcome: &Outcome) -> Result<(), String> {
        for i in draft.range.clone() {
            let (ray, inverse) = (&draft.rays[i], outcome.inverse(i));
            // NaN is outside of nothing.
            let mut outside = ray.t_min < outcome.extra(12) || ray.t_max > outcome.extra(13);
            for axis in 0..3 {
                let of = |at| outcome.extra(axis * 4 + at);
                outside |= ray.origin[axis] < of(0) || ray.origin[axis] > of(1);
                outside |= inverse[axis] < of(2) || inverse[axis] > of(3);
            }
            if outside {
                return Err(format!("ray {i} is out of bounds: {ray:?}"));
            }
        }
        let tight =
            draft.range.is_empty() || draft.rays[draft.range.clone()].iter().all(|r| r.t_max < outcome.extra(13));
        if tight && !draft.range.is_empty() && !outcome.extra(13).is_nan() {
            return Err(format!("nothing reaches as far as {:e}", outcome.extra(13)));
        }
        Ok(())
    }
}

/// [`Window::of`]: the frustum of a packet with a common origin.
#[derive(Debug)]
pub struct Frustum;

impl Kernel for Frustum {
    type General = Self;
    const PROMISES: Properties = Properties::COMMON_ORIGIN.union(Properties::CONSTANT_AXIS);
    of_rays!();

    fn extra(_rays: usize, _primitives: usize) -> usize {
        3
    }

    #[inline(always)]
    fn derive<T: Token, const N: usize>(token: T, work: &mut Work<(), N>) {
        work.rays.shears(token);
    }

    #[inline(always)]
    fn reset<const N: usize>(_work: &mut Work<(), N>) {}

    #[inline(always)]
    fn run<T: Token, const N: usize>(token: T, work: &mut Work<(), N>) {
        let Window { center, radius } = Window::of(token, &work.rays);
        // Of two zeros, which is least depends on the lanes; adding zero makes both positive.
        (work.extra[0], work.extra[1], work.extra[2]) = (center[0] + 0.0, center[1] + 0.0, radius);
    }

    fn verify(draft: &Draft<()>, outcome: &Outcome) -> Result<(), String> {
        let (center, radius) = ([outcome.extra(0), outcome.extra(1)], outcome.extra(2));
        let mut farthest = 0.0f32;
        for i in draft.range.clone() {
            let [x, y, _] = outcome.shear(i);
            for away in [center[0] - x, center[1] - y] {
                // A NaN is outside of nothing.
                if away.abs() > radius {
                    return Err(format!("ray {i} with shears {x:e} {y:e} is outside of {center:?} +- {radius:e}"));
                }
                farthest = farthest.max(away.abs());
            }
        }
        // It is the least one, up to the rounding of its middle.
        let size = center[0].abs().max(center[1].abs()) + radius;
        if radius > farthest + 1e-6 * size {
            return Err(format!("no ray is as far as {radius:e} from {center:?}: {farthest:e}"));
        }
        Ok(())
    }
}
