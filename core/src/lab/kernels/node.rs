//! The children of a node, eight boxes, against packets, streams and single rays: what walks do at each node. See
//! [`crate::kernel::frusta`], [`crate::kernel::diverged`], [`crate::kernel::stream`], [`crate::kernel::single`].

use alloc::format;
use alloc::string::String;

use mobula_simd::{Dispatch, MaskLanes, Scalar, Token};

use crate::Properties;
use crate::kernel::boxes::Planes;
use crate::kernel::diverged::{ANY_SIGNS, rays_meeting};
use crate::kernel::frusta::NodeDistances;
use crate::kernel::groups::group_size;
use crate::kernel::margin::{Frame, PAD, larger};
use crate::kernel::single::{OneRay, SingleRay, padded_origin};
use crate::kernel::stream::Stream;
use crate::kernel::words::{WORDS, word_size};
use crate::lab::find::{in_reach, ray_in_reach};
use crate::lab::{Dice, Draft, DraftRay, Kernel, Outcome, Work};
use crate::oracle::{self, Truth};

fn draw(dice: &mut Dice<'_>) -> Planes {
    let mut planes = [[0.0; 8]; 6];
    for slot in 0..8 {
        let (a, b) = (dice.point(), dice.point());
        for k in 0..3 {
            let b = a[k] + 0.25 * b[k];
            (planes[k][slot], planes[k + 3][slot]) = (a[k].min(b), a[k].max(b));
        }
    }
    planes
}

fn corners(planes: &Planes, slot: usize) -> [[f32; 3]; 2] {
    [[0, 1, 2].map(|k| planes[k][slot]), [3, 4, 5].map(|k| planes[k][slot])]
}

fn aim(dice: &mut Dice<'_>, planes: &Planes) -> [f32; 3] {
    let [low, high] = corners(planes, dice.below(8));
    // A corner on each axis half of the time: edges and corners are aimed at often.
    [0, 1, 2].map(|k| match dice.below(4) {
        0 => low[k],
        1 => high[k],
        _ => low[k] + dice.unit() * (high[k] - low[k]),
    })
}

/// Boxes are as they would be in a tree around zero, but not widened: that is for who fills the tree.
fn frame(nodes: &[Planes]) -> Frame {
    let sizes = nodes.iter().flatten().flatten().map(|x| x.abs());
    let farthest = sizes.filter(|x| x.is_finite()).fold(0.0, f32::max);
    Frame { center: [0.0; 3], size: farthest, farthest }
}

macro_rules! of_nodes {
    () => {
        type Primitive = Planes;

        fn draw(dice: &mut Dice<'_>) -> Planes {
            draw(dice)
        }

        fn aim(dice: &mut Dice<'_>, planes: &Planes) -> [f32; 3] {
            aim(dice, planes)
        }
    };
}

/// [`Frusta::boxes`](crate::kernel::frusta::Frusta::boxes), then
/// [`Frusta::groups`](crate::kernel::frusta::Frusta::groups) for each box that is met. A test is a box.
#[derive(Debug)]
pub struct NodePacket<const COMMON_ORIGIN: bool>;

/// Floats of `extra` a node: entry distances, then the groups that meet each box, as bits.
const PACKET_EXTRA: usize = 16;

impl<const COMMON_ORIGIN: bool> Kernel for NodePacket<COMMON_ORIGIN> {
    type General = Self;
    const PROMISES: Properties = if COMMON_ORIGIN { Properties::COMMON_ORIGIN } else { Properties::empty() };
    const PRIMITIVES: usize = 16;
    of_nodes!();

    fn extra(_rays: usize, nodes: usize) -> usize {
        nodes * PACKET_EXTRA
    }

    fn tests(_rays: usize, nodes: usize) -> usize {
        nodes * 8
    }

    fn derive<const N: usize>(token: impl Dispatch, work: &mut Work<Planes, N>) {
        work.rays.shears(Scalar::new());
        work.frame = frame(&work.primitives);
        work.frusta = work.frusta::<COMMON_ORIGIN>(token);
        for i in work.rays.range() {
            // Which rays have a frustum around them.
            let groups = work.frusta.as_ref().map_or(0, |(_, groups)| *groups);
            work.hits.primitive[i] = groups >> (i / group_size(N)) & 1;
        }
    }

    #[inline(always)]
    fn run<T: Token, const N: usize>(token: T, work: &mut Work<Planes, N>) {
        let Work { primitives, frusta, extra, .. } = work;
        let Some((frusta, groups)) = frusta else { return };
        for (planes, out) in primitives.iter().zip(extra.chunks_exact_mut(PACKET_EXTRA)) {
            let mut distances = NodeDistances::NONE;
            let mut met = frusta.boxes(token, planes, &mut distances);
            let (nears, bits) = out.split_at_mut(8);
            // Which zero the first of all origins is depends on the lanes; this makes both positive.
            nears.iter_mut().zip(distances.near).for_each(|(out, near)| *out = near + 0.0);
            bits.fill(0.0);
            while met != 0 {
                let slot = met.trailing_zeros() as usize % 8;
                met &= met - 1;
                let meeting = frusta.groups::<T, N, COMMON_ORIGIN>(token, planes, slot, &distances);
                bits[slot] = f32::from_bits(meeting & *groups);
            }
        }
    }

    fn verify(draft: &Draft<Planes>, outcome: &Outcome) -> Result<(), String> {
        let width = draft.rays.len();
        for (node, planes) in draft.primitives.iter().enumerate() {
            for slot in 0..8 {
                let [low, high] = corners(planes, slot);
                let near = f64::from(outcome.extra(node * PACKET_EXTRA + slot));
                let groups = outcome.extra(node * PACKET_EXTRA + 8 + slot).to_bits();
                for i in draft.range.clone().filter(|&i| outcome.found(i) == 1) {
                    let Some((truth, reach)) = box_truth(low, high, &draft.rays[i].exact()) else { continue };
                    let Some(t) = truth.t.filter(|_| truth.margin > GUARD) else { continue };
                    let met = groups >> (i / group_size(width)) & 1 != 0;
                    if !met || near > t + GUARD * (reach + t.abs()) {
                        return Err(format!("ray {i} enters {low:?} {high:?} at {t:e}, its group {met} at {near:e}"));
                    }
                }
            }
        }
        Ok(())
    }
}

/// [`rays_meeting`]: the rays of groups that have diverged, each against each box. A test is a ray and a box.
#[derive(Debug)]
pub struct NodeDiverged<const COMMON_ORIGIN: bool>;

/// [`Stream::meetings`]: rays that have nothing in common, and look for `ANY` hit or the closest, each against each box. A test is a ray
/// and a box.
#[derive(Debug)]
pub struct NodeStream<const ANY: bool>;

/// Words of 16 bits that answer for all rays.
fn words(rays: usize) -> usize {
    rays.div_ceil(16)
}

/// Stores a bit a ray, in words of 16 bits (which are no NaN, all of which are one to the lab).
#[inline(always)]
fn store(lanes: &[u64], out: &mut [f32]) {
    for (at, out) in out.iter_mut().enumerate() {
        *out = f32::from_bits((lanes[at / 4] >> (at % 4 * 16)) as u32 & 0xffff);
    }
}

/// Were the boxes met that are truly met, and no others? `farthest` is the greatest coordinate that the margin may follow from.
fn verify_bits(draft: &Draft<Planes>, outcome: &Outcome, farthest: f32) -> Result<(), String> {
    let width = words(draft.rays.len());
    for (node, planes) in draft.primitives.iter().enumerate() {
        for slot in 0..8 {
            let [low, high] = corners(planes, slot);
            for i in draft.range.clone() {
                let met = outcome.extra((node * 8 + slot) * width + i / 16).to_bits() >> (i % 16) & 1 != 0;
                judge(&draft.rays[i], [low, high], farthest, met).map_err(|what| format!("ray {i}: {what}"))?;
            }
        }
    }
    Ok(())
}

/// Is it right that a ray met a box, or not?
fn judge(ray: &DraftRay, [low, high]: [[f32; 3]; 2], farthest: f32, met: bool) -> Result<(), String> {
    let Some((truth, _)) = box_truth(low, high, &ray.exact()) else { return Ok(()) };
    let guard = if truth.t.is_some() { GUARD } else { widened(ray, low, high, farthest) };
    if truth.margin > guard && truth.t.is_some() != met {
        return Err(format!("{low:?} {high:?}: met {met}, {truth:?}; {ray:?}"));
    }
    Ok(())
}

impl<const COMMON_ORIGIN: bool> Kernel for NodeDiverged<COMMON_ORIGIN> {
    type General = NodeDiverged<false>;
    const PROMISES: Properties = if COMMON_ORIGIN { Properties::COMMON_ORIGIN } else { Properties::empty() };
    const PRIMITIVES: usize = 16;
    of_nodes!();

    fn extra(rays: usize, nodes: usize) -> usize {
        nodes * 8 * words(rays)
    }

    fn tests(rays: usize, nodes: usize) -> usize {
        rays * nodes * 8
    }

    fn derive<const N: usize>(_token: impl Dispatch, work: &mut Work<Planes, N>) {
        work.rays.inverse_directions(Scalar::new());
        work.frame = frame(&work.primitives);
    }

    #[inline(always)]
    fn reset<const N: usize>(_work: &mut Work<Planes, N>) {}

    #[inline(always)]
    fn run<T: Token, const N: usize>(token: T, work: &mut Work<Planes, N>) {
        let Work { rays, primitives, extra, .. } = work;
        if rays.range().is_empty() {
            return;
        }
        let signs = rays.octant().unwrap_or(ANY_SIGNS);
        // That of the ray that starts farthest away.
        let origins = rays.origins().iter().flat_map(|column| &column[rays.range()]);
        let margin = origins.fold(0.0, |away, x| larger(x.abs(), away)) * PAD;
        let mut lanes = [0; WORDS];
        // Where fewer rays than N were asked for, the last words have no place.
        let width = extra.len() / primitives.len().max(1) / 8;
        for (planes, out) in primitives.iter().zip(extra.chunks_exact_mut(8 * width.max(1))) {
            for (slot, out) in out.chunks_exact_mut(width.max(1)).enumerate() {
                let groups = (1 << N.div_ceil(group_size(N))) - 1;
                let (_, count) = rays_meeting::<T, N, COMMON_ORIGIN>(
                    token,
                    rays,
                    signs,
                    rays.origins(),
                    margin,
                    planes,
                    slot,
                    groups,
                    &mut lanes,
                );
                core::hint::black_box(count);
                store(&lanes, out);
            }
        }
    }

    fn verify(draft: &Draft<Planes>, outcome: &Outcome) -> Result<(), String> {
        // The margin of a packet is that of the ray that starts farthest away.
        let origins = draft.rays[draft.range.clone()].iter().flat_map(|ray| ray.origin);
        verify_bits(draft, outcome, origins.fold(frame(&draft.primitives).farthest, |far, x| larger(x.abs(), far)))
    }

    /// One origin moves the box in place of the ray, by the same margin but with other roundings.
    fn agrees(_draft: &Draft<Planes>, _outcome: &Outcome, _general: &Outcome) -> Result<(), String> {
        Ok(())
    }
}

impl<const ANY: bool> Kernel for NodeStream<ANY> {
    type General = NodeStream<false>;
    const PRIMITIVES: usize = 16;
    of_nodes!();

    fn extra(rays: usize, nodes: usize) -> usize {
        nodes * 8 * (words(rays) + 1)
    }

    fn tests(rays: usize, nodes: usize) -> usize {
        rays * nodes * 8
    }

    fn derive<const N: usize>(_token: impl Dispatch, work: &mut Work<Planes, N>) {
        work.rays.inverse_directions(Scalar::new());
        work.frame = frame(&work.primitives);
    }

    #[inline(always)]
    fn reset<const N: usize>(_work: &mut Work<Planes, N>) {}

    #[inline(always)]
    fn run<T: Token, const N: usize>(token: T, work: &mut Work<Planes, N>) {
        let Work { rays, primitives, extra, frame, .. } = work;
        let width = (extra.len() / primitives.len().max(1) / 8).saturating_sub(1);
        let (bits, nears) = extra.split_at_mut(8 * width * primitives.len());
        nears.fill(f32::INFINITY);
        let mut stream = Stream::default();
        for word in 0..N.div_ceil(64) {
            let (mut active, mut lane) = (0, 0);
            while lane < word_size(N) {
                active |= u64::from(rays.active(token, 64 * word + lane).bits()) << lane;
                lane += T::LANES;
            }
            if active == 0 {
                continue;
            }
            stream.derive(token, rays, frame, word);
            let outs = bits.chunks_exact_mut(8 * width.max(1)).zip(nears.chunks_exact_mut(8));
            for (planes, (bits, nears)) in primitives.iter().zip(outs) {
                let meetings = stream.meetings::<T, ANY>(token, rays, planes, word, active);
                for (slot, out) in bits.chunks_exact_mut(width.max(1)).enumerate() {
                    let places = (4 * word).min(out.len())..(4 * (word + 1)).min(out.len());
                    let rays = if meetings.boxes >> slot & 1 != 0 { meetings.rays[slot] } else { 0 };
                    store(&[rays], &mut out[places]);
                    nears[slot] = meetings.near[slot].min(nears[slot]);
                }
            }
        }
    }

    fn verify(draft: &Draft<Planes>, outcome: &Outcome) -> Result<(), String> {
        verify_bits(draft, outcome, frame(&draft.primitives).farthest)?;
        let nears = draft.primitives.len() * 8 * words(draft.rays.len());
        for (node, planes) in draft.primitives.iter().enumerate().filter(|_| !ANY) {
            for slot in 0..8 {
                let [low, high] = corners(planes, slot);
                let near = f64::from(outcome.extra(nears + node * 8 + slot));
                for i in draft.range.clone() {
                    let Some((truth, reach)) = box_truth(low, high, &draft.rays[i].exact()) else { continue };
                    let Some(t) = truth.t.filter(|_| truth.margin > GUARD) else { continue };
                    if near > t + GUARD * (reach + t.abs()) {
                        return Err(format!("ray {i} enters {low:?} {high:?} at {t:e}, the first of all at {near:e}"));
                    }
                }
            }
        }
        Ok(())
    }

    /// Any hits leave out boxes that do not overlap the box around all rays, which is rounded otherwise.
    fn agrees(_draft: &Draft<Planes>, _outcome: &Outcome, _general: &Outcome) -> Result<(), String> {
        Ok(())
    }
}

/// [`SingleRay::boxes`]: one ray against eight boxes, for each ray of the packet. The mask of each node is rotated into the ray's
/// answer; entry distances go to `extra`, which keeps those of the last rays. A test is a ray and a box.
#[derive(Debug)]
pub struct NodeSingle;

/// Rays whose entry distances are kept: few, so that they stay in the first cache as a stack does.
const KEPT: usize = 4;

impl Kernel for NodeSingle {
    type General = Self;
    of_nodes!();

    fn extra(_rays: usize, nodes: usize) -> usize {
        KEPT * nodes * 8
    }

    fn tests(rays: usize, nodes: usize) -> usize {
        rays * nodes * 8
    }

    fn derive<const N: usize>(_token: impl Dispatch, work: &mut Work<Planes, N>) {
        work.rays.inverse_directions(Scalar::new());
        work.rays.shears(Scalar::new());
        work.frame = frame(&work.primitives);
    }

    #[inline(always)]
    fn run<T: Token, const N: usize>(token: T, work: &mut Work<Planes, N>) {
        let token = token.narrow();
        let Work { rays, primitives, hits, extra, .. } = work;
        for i in rays.range() {
            let ray = SingleRay::new(token, &OneRay::of(rays, i, padded_origin(rays, rays.ray(i).0.to_array(), i)));
            let mut word = hits.primitive[i];
            for (planes, nears) in primitives.iter().zip(extra[i % KEPT * primitives.len() * 8..].chunks_exact_mut(8)) {
                let mut distances = [0.0; 8];
                word = word << 8 | ray.boxes(token, planes, &mut distances);
                nears.copy_from_slice(&distances);
            }
            hits.primitive[i] = word;
        }
    }

    fn verify(draft: &Draft<Planes>, outcome: &Outcome) -> Result<(), String> {
        let farthest = frame(&draft.primitives).farthest;
        let last = draft.primitives.len().min(4);
        for i in draft.range.clone() {
            for (at, planes) in draft.primitives.iter().rev().take(last).enumerate() {
                let met = outcome.found(i) >> (8 * at) & 0xff;
                for slot in 0..8 {
                    let [low, high] = corners(planes, slot);
                    judge(&draft.rays[i], [low, high], farthest, met >> slot & 1 != 0)
                        .map_err(|what| format!("ray {i}: {what}"))?;
                }
            }
        }
        Ok(())
    }
}

const GUARD: f64 = 1.0 / (1 << 19) as f64;
/// Sizes of a direction below this share of the greatest count as that: half of what [`Rays::inverse_directions`] says.
const SHORT: f64 = 1.0 / (1u64 << 41) as f64;

/// How near to its outline a box may be met that is missed, as a fraction of its distance: boxes are widened by
/// [`PAD`] of the origin's greatest coordinate, which may be as large as `farthest`.
fn widened(ray: &DraftRay, low: [f32; 3], high: [f32; 3], farthest: f32) -> f64 {
    let (mut far, mut away) = (f64::from(farthest), 0.0f64);
    for (axis, &origin) in ray.origin.iter().enumerate() {
        let origin = f64::from(origin);
        far = far.max(origin.abs());
        away = away.max((f64::from(low[axis]) - origin).abs()).max((f64::from(high[axis]) - origin).abs());
    }
    // Where products overflow, streams and single rays pass over the axis: see `padded_origin`.
    let slowest = ray.direction.iter().fold(f64::INFINITY, |s, d| s.min(f64::from(d.abs())));
    let fastest = ray.direction.iter().fold(0.0f64, |f, d| f.max(f64::from(d.abs())));
    if 8.0 * far / slowest.max(fastest * SHORT) > f64::from(f32::MAX) {
        return f64::INFINITY;
    }
    4.0 * f64::from(PAD) * (1.0 + far / away)
}

/// What the oracle says of a box, where it can tell.
fn box_truth(low: [f32; 3], high: [f32; 3], ray: &oracle::ExactRay) -> Option<(Truth, f64)> {
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
