//! A packet against one box: see [`crate::kernel::aabb`].

use alloc::format;
use alloc::string::String;

use mobula_simd::{MaskLanes, Token};

use crate::kernel::aabb::{aabb, slabs};
use crate::kernel::{load3, sub};
use crate::lab::find::{in_reach, ray_in_reach};
use crate::lab::{Dice, Draft, DraftRay, Kernel, Outcome, Work};
use crate::oracle::{self, Truth};
use crate::{Properties, Rays};

/// Nothing is known of the rays.
pub const GENERAL: u8 = 0;
/// One origin: the box is moved once.
pub const COMMON_ORIGIN: u8 = 1;
/// One sign an axis: which plane is nearer is known.
pub const CONSTANT_SIGNS: u8 = 2;
/// Both.
pub const COMMON_ORIGIN_CONSTANT_SIGNS: u8 = COMMON_ORIGIN | CONSTANT_SIGNS;

/// The test, by what is known of the rays.
#[derive(Debug)]
pub struct Slab<const CASE: u8>;

impl<const CASE: u8> Slab<CASE> {
    /// The planes met first and last where that is known, the low and high ones otherwise. `first` says which corner is met
    /// first by axis, 0 or 1.
    #[inline(always)]
    fn prepare<T: Token>(
        token: T,
        corners: &[[f32; 3]; 2],
        (origin, first): ([f32; 3], [usize; 3]),
    ) -> [[T::F32; 3]; 2] {
        let mut planes = [[token.splat(0.0); 3]; 2];
        for axis in 0..3 {
            // An address, not a choice.
            let first = if CASE & CONSTANT_SIGNS == 0 { 0 } else { first[axis] & 1 };
            planes[0][axis] = token.splat(corners[first][axis]);
            planes[1][axis] = token.splat(corners[1 - first][axis]);
            if CASE & COMMON_ORIGIN != 0 {
                let origin = token.splat(origin[axis]);
                planes[0][axis] = planes[0][axis] - origin;
                planes[1][axis] = planes[1][axis] - origin;
            }
        }
        planes
    }

    /// Which of the rays from `at` meet the box.
    #[inline(always)]
    fn test<T: Token, const N: usize>(token: T, [near, far]: [[T::F32; 3]; 2], rays: &Rays<N>, at: usize) -> T::Mask {
        let (t_min, t_max) = (token.load(&rays.t_min()[..], at), token.load(&rays.t_max[..], at));
        let inverse = load3(token, rays.inverse_columns(), at);
        let (near, far) = if CASE & COMMON_ORIGIN != 0 {
            (near, far)
        } else {
            let origin = load3(token, rays.origins(), at);
            (sub(near, origin), sub(far, origin))
        };
        if CASE & CONSTANT_SIGNS != 0 {
            slabs(token, near, far, inverse, t_min, t_max).0
        } else {
            aabb(token, near, far, inverse, t_min, t_max).0
        }
    }
}

/// The answer is a bit a ray, as a traversal wants it: words of 16 bits in `extra` (which are no NaN, all of which are one
/// to the lab), box by box.
impl<const CASE: u8> Kernel for Slab<CASE> {
    /// Low and high corner.
    type Primitive = [[f32; 3]; 2];
    type General = Slab<GENERAL>;
    const PROMISES: Properties = match CASE {
        COMMON_ORIGIN => Properties::COMMON_ORIGIN,
        CONSTANT_SIGNS => Properties::CONSTANT_SIGNS,
        COMMON_ORIGIN_CONSTANT_SIGNS => Properties::COMMON_ORIGIN.union(Properties::CONSTANT_SIGNS),
        _ => Properties::empty(),
    };

    fn draw(dice: &mut Dice<'_>) -> [[f32; 3]; 2] {
        let (a, b) = (dice.point(), dice.point());
        let b = [0, 1, 2].map(|k| a[k] + 0.25 * b[k]);
        [[0, 1, 2].map(|k| a[k].min(b[k])), [0, 1, 2].map(|k| a[k].max(b[k]))]
    }

    fn aim(dice: &mut Dice<'_>, &[low, high]: &[[f32; 3]; 2]) -> [f32; 3] {
        // A corner on each axis half of the time: edges and corners are aimed at often.
        [0, 1, 2].map(|k| match dice.below(4) {
            0 => low[k],
            1 => high[k],
            _ => low[k] + dice.unit() * (high[k] - low[k]),
        })
    }

    fn extra(rays: usize, primitives: usize) -> usize {
        rays.div_ceil(16) * primitives
    }

    #[inline(always)]
    fn derive<T: Token, const N: usize>(token: T, work: &mut Work<[[f32; 3]; 2], N>) {
        work.rays.inverse_directions(token);
    }

    #[inline(always)]
    fn reset<const N: usize>(_work: &mut Work<[[f32; 3]; 2], N>) {}

    #[inline(always)]
    fn run<T: Token, const N: usize>(token: T, work: &mut Work<[[f32; 3]; 2], N>) {
        let Work { rays, primitives, extra, .. } = work;
        let first = rays.range().start % N;
        let [x, y, z] = rays.inverse_columns();
        // The bit, not `< 0`: the reciprocal of minus infinity is minus zero.
        let negative = [x[first].is_sign_negative(), y[first].is_sign_negative(), z[first].is_sign_negative()];
        let common = (rays.ray(first).0.to_array(), negative.map(usize::from));
        // Where fewer rays than N were asked for, the last words have no place.
        let words = (extra.len() / primitives.len().max(1)).max(1);
        let mut active = [0; 64];
        for (place, word) in active.iter_mut().enumerate().take(N.div_ceil(16)) {
            *word = active_word(rays, place);
        }
        for (corners, out) in primitives.iter().zip(extra.chunks_exact_mut(words)) {
            let planes = Self::prepare(token, corners, common);
            let mut word = 0;
            let mut at = 0;
            while at < N {
                word |= Self::test(token, planes, rays, at).bits() << (at % 16);
                at += T::LANES;
                if at.is_multiple_of(16) || at >= N {
                    let place = (at - 1) / 16;
                    if let Some(out) = out.get_mut(place) {
                        *out = f32::from_bits(word & active[place % 64]);
                    }
                    word = 0;
                }
            }
        }
    }

    fn verify(draft: &Draft<[[f32; 3]; 2]>, outcome: &Outcome) -> Result<(), String> {
        let words = draft.rays.len().div_ceil(16);
        for (at, &[low, high]) in draft.primitives.iter().enumerate() {
            for i in draft.range.clone() {
                let met = outcome.extra(at * words + i / 16).to_bits() >> (i % 16) & 1 != 0;
                let Some((truth, _)) = box_truth(low, high, &draft.rays[i].exact()) else { continue };
                if truth.margin > 1.0 / (1 << 19) as f64 && truth.t.is_some() != met {
                    return Err(format!("ray {i}, {low:?} {high:?}: met {met}, {truth:?}; {:?}", draft.rays[i]));
                }
            }
        }
        Ok(())
    }

    fn agrees(draft: &Draft<[[f32; 3]; 2]>, outcome: &Outcome, general: &Outcome) -> Result<(), String> {
        let words = draft.rays.len().div_ceil(16);
        for (at, &corners) in draft.primitives.iter().enumerate() {
            for i in draft.range.clone().filter(|&i| without_nan(&draft.rays[i], corners)) {
                let [met, want] =
                    [outcome, general].map(|of| of.extra(at * words + i / 16).to_bits() >> (i % 16) & 1 != 0);
                if met != want {
                    return Err(format!("ray {i}, {corners:?}: met {met}, {want} in general; {:?}", draft.rays[i]));
                }
            }
        }
        Ok(())
    }
}

/// Are a ray's numbers and a box's such that no test of theirs makes a NaN? With one, the answer is arbitrary.
pub(super) fn without_nan(ray: &DraftRay, [low, high]: [[f32; 3]; 2]) -> bool {
    let numbers = [ray.origin, ray.direction, low, high];
    numbers.iter().flatten().all(|x| x.is_finite()) && !ray.t_min.is_nan() && !ray.t_max.is_nan()
}

/// The active ones of the 16 rays from `16 * place`.
#[inline(always)]
fn active_word<const N: usize>(rays: &Rays<N>, place: usize) -> u32 {
    let below = |end: usize| match end.saturating_sub(16 * place) {
        n @ 0..16 => (1 << n) - 1,
        _ => 0xffff,
    };
    below(rays.range().end) & !below(rays.range().start)
}

/// What the oracle says of a box, where it can tell.
pub(super) fn box_truth(low: [f32; 3], high: [f32; 3], ray: &oracle::Ray) -> Option<(Truth, f64)> {
    // A NaN makes the answer arbitrary; most are out of reach anyway.
    let interval = !ray.t_min.is_nan() && !ray.t_max.is_nan();
    let usual = interval && ray.direction.iter().all(|&d| in_reach(d as f32));
    if !usual || !ray_in_reach(ray) || !low.iter().chain(&high).all(|&x| in_reach(x)) {
        return None;
    }
    // Boxes whose planes nearly meet have a margin of their own.
    let size = ray.origin.iter().fold(0.0f64, |s, o| s.max(o.abs()));
    let size = low.iter().chain(&high).fold(size, |s, &x| s.max(f64::from(x).abs()));
    let slowest = ray.direction.iter().fold(f64::INFINITY, |s, d| if *d == 0.0 { s } else { s.min(d.abs()) });
    let truth = oracle::aabb(ray, low, high);
    // Everything at zero has no size to measure a margin by.
    (!truth.margin.is_nan()).then_some((truth, 4.0 * size / slowest))
}
