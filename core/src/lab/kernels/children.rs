//! One ray, or the beam around a packet, against the eight boxes of a node: see [`crate::kernel::aabb`].

use alloc::format;
use alloc::string::String;

use mobula_simd::{F32Lanes, MaskLanes, Token};

use super::slab::{box_truth, without_nan};
use crate::Properties;
use crate::kernel::aabb::{aabb, beam, slabs, slabs_scaled};
use crate::kernel::bounds::{PacketBounds, packet_bounds};
use crate::kernel::{splat3, sub};
use crate::lab::{Dice, Draft, DraftRay, Kernel, Outcome, Work};
use crate::oracle;

use super::slab::Slab;

/// Eight boxes: low x, y, z, high x, y, z. A cache line begins with them, as with a node: loads across two of them cost twice.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Planes([[f32; 8]; 6]);

/// Which plane is nearer is found box by box.
pub const GENERAL: u8 = 0;
/// Planes are picked by the ray's signs.
pub const SORTED: u8 = 1;
/// So are they, and the origin is multiplied out once per ray.
pub const SORTED_FUSED: u8 = 2;

/// One ray against eight boxes, for each ray of the packet. The mask of each node is rotated into the ray's `found`; entry
/// distances go to `extra`, which keeps those of the last four rays.
#[derive(Debug)]
pub struct Children<const CASE: u8>;

const NODES: usize = 64;
/// Rays whose entry distances are kept: few, so that they stay in the first cache as a stack does.
const KEPT: usize = 4;

fn draw(dice: &mut Dice<'_>) -> Planes {
    let mut planes = [[0.0; 8]; 6];
    for slot in 0..8 {
        let [low, high] = <Slab<0> as Kernel>::draw(dice);
        for axis in 0..3 {
            (planes[axis][slot], planes[axis + 3][slot]) = (low[axis], high[axis]);
        }
    }
    Planes(planes)
}

fn corners(Planes(planes): &Planes, slot: usize) -> [[f32; 3]; 2] {
    [[0, 1, 2].map(|k| planes[k][slot]), [3, 4, 5].map(|k| planes[k][slot])]
}

fn aim(dice: &mut Dice<'_>, planes: &Planes) -> [f32; 3] {
    let slot = dice.below(8);
    <Slab<0> as Kernel>::aim(dice, &corners(planes, slot))
}

impl<const CASE: u8> Kernel for Children<CASE> {
    type Primitive = Planes;
    type General = Children<GENERAL>;
    const PRIMITIVES: usize = NODES;

    fn draw(dice: &mut Dice<'_>) -> Planes {
        draw(dice)
    }

    fn aim(dice: &mut Dice<'_>, planes: &Planes) -> [f32; 3] {
        aim(dice, planes)
    }

    fn extra(_rays: usize, primitives: usize) -> usize {
        KEPT * primitives * 8
    }

    fn tests(rays: usize, primitives: usize) -> usize {
        rays * primitives * 8
    }

    #[inline(always)]
    fn derive<T: Token, const N: usize>(token: T, work: &mut Work<Planes, N>) {
        work.rays.inverse_directions(token);
    }

    #[inline(always)]
    fn run<T: Token, const N: usize>(token: T, work: &mut Work<Planes, N>) {
        let token = token.narrow();
        let Work { rays, primitives, found, extra, .. } = work;
        for i in rays.range() {
            let mut inverse = [0.0; 3];
            let mut origin = [0.0; 3];
            let mut scaled = [0.0; 3];
            let mut rows = [[0, 1, 2], [3, 4, 5]];
            for axis in 0..3 {
                inverse[axis] = rays.inverse_columns()[axis][i];
                origin[axis] = rays.origins()[axis][i];
                scaled[axis] = origin[axis] * inverse[axis];
                if CASE != GENERAL && inverse[axis].is_sign_negative() {
                    (rows[0][axis], rows[1][axis]) = (axis + 3, axis);
                }
            }
            let (inverse, origin, scaled) = (splat3(token, inverse), splat3(token, origin), splat3(token, scaled));
            let (t_min, t_max) = (token.splat(rays.t_min()[i]), token.splat(rays.t_max[i]));
            let mut word = found[i];
            for (planes, nears) in primitives.iter().zip(extra[i % KEPT * primitives.len() * 8..].chunks_exact_mut(8)) {
                let mut met = 0;
                let mut at = 0;
                while at < 8 {
                    let near = pick(token, planes, rows[0], at);
                    let far = pick(token, planes, rows[1], at);
                    let (hit, t) = match CASE {
                        GENERAL => aabb(token, sub(near, origin), sub(far, origin), inverse, t_min, t_max),
                        SORTED => slabs(token, sub(near, origin), sub(far, origin), inverse, t_min, t_max),
                        _ => slabs_scaled(token, near, far, inverse, scaled, t_min, t_max),
                    };
                    met |= hit.bits() << at;
                    t.store(nears, at);
                    at += token_lanes(token);
                }
                word = word << 8 | met;
            }
            found[i] = word;
        }
    }

    fn verify(draft: &Draft<Planes>, outcome: &Outcome) -> Result<(), String> {
        let last = draft.primitives.len().min(4);
        for i in draft.range.clone() {
            for (at, planes) in draft.primitives.iter().rev().take(last).enumerate() {
                let met = outcome.found(i) >> (8 * at) & 0xff;
                for slot in 0..8 {
                    let [low, high] = corners(planes, slot);
                    let Some((truth, reach)) = box_truth(low, high, &draft.rays[i].exact()) else { continue };
                    if truth.margin <= guard(CASE, &draft.rays[i], low, high) {
                        continue;
                    }
                    if truth.t.is_some() != (met >> slot & 1 != 0) {
                        return Err(format!(
                            "ray {i} and {low:?} {high:?}: {truth:?}, met {met:#x}; {:?}",
                            draft.rays[i]
                        ));
                    }
                    let node = draft.primitives.len() - 1 - at;
                    let near = f64::from(outcome.extra((i % KEPT * draft.primitives.len() + node) * 8 + slot));
                    if let Some(t) = truth.t
                        && i + KEPT >= draft.range.end
                        && (near - t).abs() > GUARD * (reach + t.abs())
                    {
                        return Err(format!("ray {i} enters {low:?} {high:?} at {near:e}, truly {t:e}"));
                    }
                }
            }
        }
        Ok(())
    }

    fn agrees(draft: &Draft<Planes>, outcome: &Outcome, general: &Outcome) -> Result<(), String> {
        let count = draft.primitives.len();
        // Of the last four nodes there are the bits of all rays, of all nodes the distances of the last rays.
        for i in draft.range.clone() {
            let (ray, exact) = (&draft.rays[i], draft.rays[i].exact());
            for (node, planes) in draft.primitives.iter().enumerate() {
                for slot in 0..8 {
                    let [low, high] = corners(planes, slot);
                    if !without_nan(ray, [low, high]) {
                        continue;
                    }
                    let bit = 8 * (count - 1 - node) + slot;
                    if CASE == SORTED && bit < 32 && (outcome.found(i) ^ general.found(i)) >> bit & 1 != 0 {
                        return Err(format!("ray {i}, {low:?} {high:?}: not as in general; {ray:?}"));
                    }
                    let at = (i % KEPT * count + node) * 8 + slot;
                    let [near, want] = [outcome, general].map(|of| f64::from(of.extra(at)));
                    let last = i + KEPT >= draft.range.end;
                    let truth = box_truth(low, high, &exact).filter(|(truth, _)| last && truth.t.is_some());
                    let clear = truth.filter(|(truth, _)| truth.margin > guard(CASE, ray, low, high));
                    let Some((truth, reach)) = clear else { continue };
                    let allowed = if CASE == SORTED { 0.0 } else { ULPS / f64::from(1 << 24) * reach };
                    if (near - want).abs() > allowed {
                        return Err(format!("ray {i}, {low:?} {high:?}: {near:e}, {want:e} in general; {truth:?}"));
                    }
                }
            }
        }
        Ok(())
    }
}

const GUARD: f64 = 1.0 / (1 << 19) as f64;

/// How near to its outline the box may be confused, as a fraction of its distance. The origin that is multiplied out is
/// rounded as a fraction of its own distance to zero, which may be much more.
fn guard(case: u8, ray: &DraftRay, low: [f32; 3], high: [f32; 3]) -> f64 {
    let (mut far, mut away) = (0.0f64, 0.0f64);
    for (axis, &origin) in ray.origin.iter().enumerate() {
        let origin = f64::from(origin);
        far = far.max(origin.abs());
        away = away.max((f64::from(low[axis]) - origin).abs()).max((f64::from(high[axis]) - origin).abs());
    }
    if case == SORTED_FUSED { GUARD * (1.0 + far / away) } else { GUARD }
}

/// By how many units of 2^-24 of the sizes involved entry distances may differ where the origin is multiplied out: the
/// rounding of the product, of the fused operation or the two of the other family, and those of the general path.
const ULPS: f64 = 4.0;

#[inline(always)]
fn token_lanes<T: Token>(_: T) -> usize {
    T::LANES
}

#[inline(always)]
fn pick<T: Token>(token: T, Planes(planes): &Planes, rows: [usize; 3], at: usize) -> [T::F32; 3] {
    let rows = [&planes[rows[0] % 6], &planes[rows[1] % 6], &planes[rows[2] % 6]];
    [token.load(rows[0], at), token.load(rows[1], at), token.load(rows[2], at)]
}

/// Floats of `extra` that hold the packet's bounds.
const BOUNDS: usize = 14;

/// The beam around all rays of a packet against eight boxes, as packet traversal does: a box that any ray meets is
/// met. It needs constant signs; a packet without them is not tested.
#[derive(Debug)]
pub struct Beams;

impl Kernel for Beams {
    type Primitive = Planes;
    type General = Self;
    const PROMISES: crate::Properties = Properties::CONSTANT_SIGNS;
    const PRIMITIVES: usize = 16;

    fn draw(dice: &mut Dice<'_>) -> Planes {
        draw(dice)
    }

    fn aim(dice: &mut Dice<'_>, planes: &Planes) -> [f32; 3] {
        aim(dice, planes)
    }

    fn extra(_rays: usize, primitives: usize) -> usize {
        BOUNDS + primitives * 16
    }

    fn tests(_rays: usize, primitives: usize) -> usize {
        primitives * 8
    }

    #[inline(always)]
    fn derive<T: Token, const N: usize>(token: T, work: &mut Work<Planes, N>) {
        work.rays.inverse_directions(token);
        let bounds = packet_bounds::<T, N, false>(token, &work.rays);
        for (out, v) in work.extra.chunks_exact_mut(3).zip([bounds.origin, bounds.inverse].into_iter().flatten()) {
            out.copy_from_slice(&v);
        }
        (work.extra[12], work.extra[13]) = (bounds.t_min, bounds.t_max);
    }

    #[inline(always)]
    fn run<T: Token, const N: usize>(token: T, work: &mut Work<Planes, N>) {
        let (bounds, answers) = work.extra.split_at_mut(BOUNDS);
        let of = |at: usize| [bounds[at], bounds[at + 1], bounds[at + 2]];
        let bounds =
            PacketBounds { origin: [of(0), of(3)], inverse: [of(6), of(9)], t_min: bounds[12], t_max: bounds[13] };
        let token = token.narrow();
        let (mut near_origin, mut far_origin) = (bounds.origin[1], bounds.origin[0]);
        let mut rows = [[0, 1, 2], [3, 4, 5]];
        for axis in 0..3 {
            // The least: the greatest may be the zero of an infinite direction.
            if bounds.inverse[0][axis] < 0.0 {
                (rows[0][axis], rows[1][axis]) = (axis + 3, axis);
                (near_origin[axis], far_origin[axis]) = (far_origin[axis], near_origin[axis]);
            }
        }
        let (near_origin, far_origin) = (splat3(token, near_origin), splat3(token, far_origin));
        let inverse = [splat3(token, bounds.inverse[0]), splat3(token, bounds.inverse[1])];
        let (t_min, t_max) = (token.splat(bounds.t_min), token.splat(bounds.t_max));
        for (planes, out) in work.primitives.iter().zip(answers.chunks_exact_mut(16)) {
            let (nears, met) = out.split_at_mut(8);
            let mut at = 0;
            while at < 8 {
                let to_near = sub(pick(token, planes, rows[0], at), near_origin);
                let to_far = sub(pick(token, planes, rows[1], at), far_origin);
                let (hit, near) = beam(token, to_near, to_far, inverse, t_min, t_max);
                near.store(nears, at);
                token.splat(1.0).select(hit, token.splat(0.0)).store(met, at);
                at += token_lanes(token);
            }
        }
    }

    fn verify(draft: &Draft<Planes>, outcome: &Outcome) -> Result<(), String> {
        for (node, planes) in draft.primitives.iter().enumerate() {
            for slot in 0..8 {
                let [low, high] = corners(planes, slot);
                let met = outcome.extra(BOUNDS + node * 16 + 8 + slot) == 1.0;
                for i in draft.range.clone() {
                    // Packets of which one ray is out of reach have no bounds to speak of.
                    let all = draft.range.clone().all(|k| box_truth(low, high, &exact(draft, k)).is_some());
                    let Some((truth, reach)) = box_truth(low, high, &exact(draft, i)).filter(|_| all) else { continue };
                    let Some(t) = truth.t.filter(|_| truth.margin > GUARD) else { continue };
                    let near = f64::from(outcome.extra(BOUNDS + node * 16 + slot));
                    if !met || near > t + GUARD * (reach + t.abs()) {
                        return Err(format!("ray {i} enters {low:?} {high:?} at {t:e}, its beam {met} at {near:e}"));
                    }
                }
            }
        }
        Ok(())
    }
}

fn exact(draft: &Draft<Planes>, i: usize) -> oracle::Ray {
    draft.rays[i].exact()
}
