//! Kernels that ask which primitive each ray hits.

use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;
use core::fmt::Debug;
use core::marker::PhantomData;

use mobula_simd::{Dispatch, F32Lanes, I32Lanes, MaskLanes, Token};

use super::{Dice, Draft, Kernel, Outcome, Work};
use crate::oracle::{self, Truth};
use crate::{Column, NO_HIT, Properties, Rays};

/// One primitive against a vector of rays.
pub trait RayTest: 'static {
    /// The primitive, or [`PER`](Self::PER) of them, as they lie in memory.
    type Primitive: Clone + Debug + 'static;
    /// How many primitives one `Primitive` holds.
    const PER: usize = 1;
    /// The test that this one is a special case of; itself if it is general.
    type General: RayTest<Primitive = Self::Primitive>;
    /// What is the same for every primitive and ray of the packet, in scalars: common origin, dominant axis, signs.
    /// Held in registers; what is read from the packet is read again after every store to it.
    type Common: Copy;
    /// The primitive with all that is the same for every ray worked out.
    type Prepared<T: Token>: Copy;
    /// What it needs to know of the rays.
    const PROMISES: Properties = Properties::empty();
    /// By how many units of 2^-24 of the sizes involved its distances may differ from those of the general test: 0 where it
    /// only hoists work, which gives the same bits.
    const ULPS: u32 = 0;
    /// Relative to the distances involved, how far from a boundary hit and miss may be confused, and distances be off.
    const GUARD: f64 = 1.0 / (1 << 19) as f64;

    /// Draws a primitive.
    fn draw(dice: &mut Dice<'_>) -> Self::Primitive;

    /// A point of interest to aim a ray at.
    fn aim(dice: &mut Dice<'_>, primitive: &Self::Primitive) -> [f32; 3];

    /// Derives in the packet what the test reads; once per packet.
    fn derive<const N: usize>(_rays: &mut Rays<N>) {}

    /// Finds what is common; once per packet.
    fn common<T: Token, const N: usize>(token: T, rays: &Rays<N>) -> Self::Common;

    /// Prepares a primitive; once per packet and primitive.
    fn prepare<T: Token>(token: T, primitive: &Self::Primitive, common: Self::Common) -> Self::Prepared<T>;

    /// Which of the rays from `at` hit within their intervals, and where; `i` says which of the [`PER`](Self::PER).
    fn test<T: Token, const N: usize>(
        token: T,
        prepared: &Self::Prepared<T>,
        i: usize,
        common: Self::Common,
        rays: &Rays<N>,
        at: usize,
    ) -> (T::Mask, T::F32);

    /// What is true, and how far the distance moves when the surface moves by as much as it is away: the size of the
    /// scene over the cosine. `None` where the oracle cannot tell.
    fn truth(primitive: &Self::Primitive, i: usize, ray: &oracle::ExactRay) -> Option<(Truth, f64)>;
}

/// The nearest of all primitives, or any.
pub const CLOSEST: bool = false;
/// Any hit is enough: `t_max` becomes `-inf`.
pub const ANY: bool = true;
/// The kernel that runs a [`RayTest`] for every primitive and ray of the packet. Which rays are active is asked only
/// after a hit, so there is no special case for packets that are fully active: it gained 1 to 2 %.
#[derive(Debug)]
pub struct Find<R, const HIT: bool = CLOSEST>(PhantomData<R>);

impl<R: RayTest, const HIT: bool> Kernel for Find<R, HIT> {
    type Primitive = R::Primitive;
    type General = Find<R::General>;
    const PROMISES: Properties = R::PROMISES;
    const PRIMITIVES: usize = 64 / R::PER;

    fn tests(rays: usize, primitives: usize) -> usize {
        rays * primitives * R::PER
    }

    fn draw(dice: &mut Dice<'_>) -> R::Primitive {
        R::draw(dice)
    }

    fn aim(dice: &mut Dice<'_>, primitive: &R::Primitive) -> [f32; 3] {
        R::aim(dice, primitive)
    }

    fn derive<const N: usize>(_token: impl Dispatch, work: &mut Work<R::Primitive, N>) {
        R::derive(&mut work.rays);
    }

    #[inline(always)]
    fn run<T: Token, const N: usize>(token: T, work: &mut Work<R::Primitive, N>) {
        let Work { rays, primitives, hits, .. } = work;
        let common = R::common(token, rays);
        for (place, primitive) in primitives.iter().enumerate() {
            let prepared = R::prepare(token, primitive, common);
            for i in 0..R::PER {
                let id = (place * R::PER + i) as i32;
                let mut at = 0;
                while at < N {
                    let (hit, t) = R::test(token, &prepared, i, common, rays, at);
                    if hit.any() {
                        record::<T, N, HIT>(token, rays, &mut hits.primitive, at, hit, t, id);
                    }
                    at += T::LANES;
                }
            }
        }
    }

    fn verify(draft: &Draft<R::Primitive>, outcome: &Outcome) -> Result<(), String> {
        verify(draft, outcome, HIT == ANY, R::GUARD, |ray| {
            let of = |p: &R::Primitive| (0..R::PER).map(|i| R::truth(p, i, ray)).collect::<Vec<_>>();
            draft.primitives.iter().flat_map(of).collect()
        })
    }

    fn agrees(draft: &Draft<R::Primitive>, outcome: &Outcome, general: &Outcome) -> Result<(), String> {
        if HIT == CLOSEST && R::ULPS == 0 {
            return outcome.answers_equal(general);
        }
        for i in draft.range.clone() {
            let (found, of_general) = (outcome.found(i), general.found(i));
            if HIT == ANY {
                // Rays that reach nowhere look as if they had hit.
                let was_hit = outcome.t_max(i) == f32::NEG_INFINITY && draft.rays[i].t_max != f32::NEG_INFINITY;
                if R::ULPS == 0 && was_hit != (of_general != NO_HIT) {
                    return Err(format!("ray {i}: any hit {was_hit}, nearest {of_general:#x}; {:?}", draft.rays[i]));
                }
            } else if found == of_general && found != NO_HIT {
                let (t, want) = (f64::from(outcome.t_max(i)), f64::from(general.t_max(i)));
                let (place, part) = (found as usize / R::PER, found as usize % R::PER);
                let truth = R::truth(&draft.primitives[place], part, &draft.rays[i].exact());
                let Some((_, reach)) = truth.filter(|(truth, _)| truth.margin > R::GUARD) else { continue };
                let bound = f64::from(R::ULPS) / f64::from(1 << 24) * (reach + want.abs());
                if (t - want).abs() > bound {
                    return Err(format!("ray {i}: {t:e}, {want:e} in general, allowed {bound:e}; {:?}", draft.rays[i]));
                }
            }
        }
        Ok(())
    }
}

/// Keeps the nearest of the hits and what the active rays hit before, on equal distance the lower id; or any.
#[inline(always)]
fn record<T: Token, const N: usize, const HIT: bool>(
    token: T,
    rays: &mut Rays<N>,
    found: &mut Column<u32, N>,
    at: usize,
    hit: T::Mask,
    t: T::F32,
    id: i32,
) {
    let hit = hit & rays.active(token, at);
    if HIT == ANY {
        token.splat(f32::NEG_INFINITY).store_masked(&mut rays.t_max[..], at, hit);
    } else {
        let id = token.splat_i32(id);
        let nearest = token.load(&rays.t_max[..], at);
        let lower = id.lt_unsigned(token.load_u32(&found[..], at));
        let better = hit & (t.lt(nearest) | (t.eq(nearest) & lower));
        t.store_masked(&mut rays.t_max[..], at, better);
        id.store_masked(&mut found[..], at, better);
    }
}

/// What is true of a ray and each primitive, and how far the distance moves when the surface moves by as much as it is away;
/// `None` where the oracle cannot tell.
pub type Truths = Vec<Option<(Truth, f64)>>;

/// Are the answers of all active rays right? `guard`: see [`RayTest::GUARD`].
///
/// # Errors
/// The first that is wrong.
pub fn verify<P: Debug>(
    draft: &Draft<P>,
    outcome: &Outcome,
    any: bool,
    guard: f64,
    truths: impl Fn(&oracle::ExactRay) -> Truths,
) -> Result<(), String> {
    for i in draft.range.clone() {
        let ray = draft.rays[i].exact();
        let (t, found) = (f64::from(outcome.t_max(i)), outcome.found(i));
        if any && ray.t_max == f64::NEG_INFINITY {
            continue;
        }
        let was_hit = if any { t == f64::NEG_INFINITY } else { found != NO_HIT };
        judge(guard, &truths(&ray), any, was_hit, found, t)
            .map_err(|what| format!("ray {i}: {what}; {:?}, {:?}", draft.rays[i], draft.primitives))?;
    }
    Ok(())
}

/// Is the answer of one ray right?
fn judge(
    guard: f64,
    truths: &[Option<(Truth, f64)>],
    any: bool,
    was_hit: bool,
    found: u32,
    t: f64,
) -> Result<(), String> {
    // How far off a distance may be.
    let slack = |reach: f64, t: f64| guard * (reach + t.abs());
    let clear = |at: usize| truths[at].filter(|(truth, _)| truth.margin > guard);
    let all = 0..truths.len();
    if !was_hit {
        return match all.clone().find(|&at| clear(at).is_some_and(|(truth, _)| truth.t.is_some())) {
            Some(at) => Err(format!("missed primitive {at}, truly hit: {:?}", truths[at])),
            None => Ok(()),
        };
    }
    if any {
        let impossible = all.clone().all(|at| clear(at).is_some_and(|(truth, _)| truth.t.is_none()));
        return if impossible { Err(format!("hit nothing that is there: {truths:?}")) } else { Ok(()) };
    }
    let Some((truth, reach)) = clear(found as usize) else { return Ok(()) };
    let Some(true_t) = truth.t else { return Err(format!("hit primitive {found}, truly missed: {truth:?}")) };
    if (t - true_t).abs() > slack(reach, true_t) {
        return Err(format!("primitive {found} hit at {t:e}, truly at {true_t:e}, allowed {:e}", slack(reach, true_t)));
    }
    for at in all {
        if let Some((Truth { t: Some(nearer), .. }, nearer_reach)) = clear(at)
            && nearer + slack(nearer_reach, nearer) < true_t - slack(reach, true_t)
        {
            return Err(format!("primitive {found} hit at {t:e}, but {at} is nearer: {nearer:e}"));
        }
    }
    Ok(())
}

/// Is a number one that the oracle's bounds hold for? Where squares and cubes leave the range of `f32`, hits are lost.
pub fn in_reach(x: f32) -> bool {
    x == 0.0 || (1e-5..=1e5).contains(&x.abs())
}

/// Are all numbers of a ray ones that the oracle's bounds hold for?
pub fn ray_in_reach(ray: &oracle::ExactRay) -> bool {
    let longest = ray.direction.iter().fold(0.0f64, |l, d| l.max(d.abs()));
    // Directions of any kind of number are fine as long as they are of normal length.
    ray.origin.iter().all(|&x| in_reach(x as f32)) && (1e-5..=1e5).contains(&longest)
}
