//! What precedes intersection: reciprocal directions with signs, unit directions, shears, bounds of groups, frusta. A test is a
//! ray.

use alloc::format;
use alloc::string::String;

use mobula_simd::{Dispatch, Scalar, Token};

use crate::Properties;
use crate::kernel::group_bounds::MIXED;
use crate::kernel::groups::{GROUPS, group_size};
use crate::kernel::margin::Frame;
use crate::lab::find::in_reach;
use crate::lab::leaves::AroundFirst;
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
        work.rays.forget(Properties::HAVE_INVERSE_DIRECTIONS | Properties::CONSTANT_SIGNS);
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
        work.rays.forget(Properties::HAVE_SHEARS);
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

/// [`GroupBounds::new`](crate::kernel::group_bounds::GroupBounds::new) and [`Frusta::new`](crate::kernel::frusta::Frusta::new): what a packet costs before its first node.
#[derive(Debug)]
pub struct FrustaSetup<const COMMON_ORIGIN: bool>;

/// Floats of `extra` a group: its class, least and greatest slopes in x and in y, least and greatest origins, the far end.
const GROUP_EXTRA: usize = 12;

impl<const COMMON_ORIGIN: bool> Kernel for FrustaSetup<COMMON_ORIGIN> {
    type General = Self;
    const PROMISES: Properties = if COMMON_ORIGIN { Properties::COMMON_ORIGIN } else { Properties::empty() };
    of_rays!();

    fn extra(_rays: usize, _primitives: usize) -> usize {
        GROUPS * GROUP_EXTRA
    }

    fn derive<const N: usize>(token: impl Dispatch, work: &mut Work<(), N>) {
        work.rays.shears(Scalar::new());
        work.frame = Frame { size: 1.0, farthest: 1.0, ..Frame::default() };
        let Some(bounds) = token.dispatch(AroundFirst::<N, COMMON_ORIGIN>::of(work)).bounds else { return };
        for (group, out) in work.extra.chunks_exact_mut(GROUP_EXTRA).enumerate() {
            // Of two zeros, which is least depends on the lanes; adding zero makes both positive.
            let of = |row: &[f32]| row[group] + 0.0;
            out.fill(0.0);
            out[0] = f32::from(bounds.class(group));
            if bounds.class(group) == MIXED {
                continue;
            }
            for k in 0..2 {
                (out[1 + 2 * k], out[2 + 2 * k]) = (of(&bounds.slope[0][k][..]), of(&bounds.slope[1][k][..]));
            }
            for k in 0..3 {
                (out[5 + 2 * k], out[6 + 2 * k]) = (of(&bounds.origin[0][k][..]), of(&bounds.origin[1][k][..]));
            }
            out[11] = of(&bounds.t_max[..]);
        }
    }

    #[inline(always)]
    fn reset<const N: usize>(_work: &mut Work<(), N>) {}

    #[inline(always)]
    fn run<T: Token, const N: usize>(token: T, work: &mut Work<(), N>) {
        work.frusta = token.run(AroundFirst::<N, COMMON_ORIGIN>::of(work)).frusta;
    }

    fn verify(draft: &Draft<()>, outcome: &Outcome) -> Result<(), String> {
        let size = group_size(draft.rays.len());
        for i in draft.range.clone() {
            let of = |at| outcome.extra(i / size * GROUP_EXTRA + at);
            // NaN is outside of nothing, and a ray without a direction goes no way.
            let (ray, [x, y, z]) = (&draft.rays[i], outcome.shear(i));
            if of(0) == f32::from(MIXED) || z.is_nan() {
                continue;
            }
            let mut outside = x < of(1) || x > of(2) || y < of(3) || y > of(4) || ray.t_max > of(11);
            for axis in 0..3 {
                outside |= ray.origin[axis] < of(5 + 2 * axis) || ray.origin[axis] > of(6 + 2 * axis);
            }
            let class = outcome.axis(i) * 2 + u32::from(z < 0.0);
            if outside || of(0) != class as f32 {
                return Err(format!("ray {i} is out of the bounds of its group: {ray:?}"));
            }
        }
        Ok(())
    }
}
