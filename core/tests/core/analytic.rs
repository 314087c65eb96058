//! Iso-surfaces of fields that formulas give, against the true surface; and roots in cells against those in double precision.
//!
//! Trilinear interpolation of a field is off by at most 1/8 of the sum of its greatest second derivatives along the axes, for
//! samples a unit apart: an interpolated surface is where the true field is that near to the iso value.

use glam::{DVec3, Vec3};
use mobula_core::kernel::cell_walk::RayLanes;
use mobula_core::kernel::iso_cell::iso_cell;
use mobula_core::simd::{AnyToken, F32Lanes, MaskLanes, Task, Token};
use mobula_core::traverse;
use mobula_core::volume::IsoTree;

use crate::common::Random;
use crate::levels;
use crate::volume::{Grid, packet};

/// A field, in units of its grid.
struct Analytic<F> {
    samples: usize,
    value: F,
    iso: f64,
    /// The greatest error of interpolation.
    bound: f64,
}

impl<F: Fn(DVec3) -> f64> Analytic<F> {
    /// The greatest and the mean distance in values of hits from the iso value, over at least so many hits.
    fn check(&self, token: AnyToken, wanted: usize) -> [f64; 2] {
        let Self { samples, value, iso, bound } = self;
        let grid = Grid::new([*samples; 3], |at| value(Vec3::from(at).as_dvec3()) as f32);
        let (field, isos) = (grid.field(), [*iso as f32]);
        let tree = IsoTree::new(&field, &isos);
        // Samples are rounded to single precision, and hits are.
        let bound = bound + 1e-5 * iso.abs().max(1.0);
        let size = (samples - 1) as f32;
        let mut random = Random(samples.wrapping_mul(7) as u64);
        let (mut hits, mut most, mut sum) = (0, 0.0f64, 0.0);
        while hits < wanted {
            let common = Vec3::splat(0.5 * size) + random.point(4.0 * size);
            let scattered = random.below(2) == 0;
            let rays: Vec<(Vec3, Vec3)> = (0..256)
                .map(|_| {
                    let from = if scattered { Vec3::splat(0.5 * size) + random.point(2.0 * size) } else { common };
                    (from, Vec3::splat(0.5 * size) + random.point(0.9 * size) - from)
                })
                .collect();
            let mut packet = packet::<256>(&rays);
            traverse::intersect(&tree, token, &mut packet);
            for (i, &(origin, direction)) in rays.iter().enumerate() {
                let (origin, direction) = (origin.as_dvec3(), direction.as_dvec3());
                let until = if packet.was_hit(i) { f64::from(packet.t_max[i]) } else { f64::INFINITY };
                if until.is_finite() {
                    let off = (value(origin + direction * until) - iso).abs();
                    assert!(off <= bound, "{}: {off} for {bound} at ray {i}", token.level());
                    (hits, most, sum) = (hits + 1, most.max(off), sum + off);
                }
                if i % 8 == 0 {
                    self.check_way(bound, origin, direction, until);
                }
            }
        }
        [most, sum / hits as f64]
    }

    /// Up to where it hit, a ray is on one side, as far as interpolation leaves that clear.
    fn check_way(&self, bound: f64, origin: DVec3, direction: DVec3, until: f64) {
        let Self { samples, value, iso, .. } = self;
        let inverse = direction.recip();
        let (a, b) = (-origin * inverse, (DVec3::splat((samples - 1) as f64) - origin) * inverse);
        let (from, to) = (a.min(b).max_element().max(0.0), a.max(b).min_element().min(until));
        let step = 0.1 / direction.length();
        let mut sides = [false; 2];
        let steps = ((to - from) / step).max(0.0) as usize;
        for i in 1..steps {
            let off = value(origin + direction * (from + i as f64 * step)) - iso;
            sides[0] |= off < -bound;
            sides[1] |= off > bound;
        }
        assert!(!(sides[0] && sides[1]), "{origin} {direction} goes through the surface before {until}");
    }
}

/// Distances from a sphere: their second derivatives are at most 1/r, 2/r in sum.
fn sphere(radius: f64) -> Analytic<impl Fn(DVec3) -> f64> {
    let samples = (2.5 * radius) as usize;
    let middle = DVec3::splat(0.5 * samples as f64 - 0.3);
    Analytic { samples, value: move |p: DVec3| (p - middle).length(), iso: radius, bound: 0.25 / (radius - 2.0) }
}

fn spheres_are_round(token: AnyToken) {
    // In units of cells: distances are values.
    let [most, mean] = sphere(12.0).check(token, 10_000);
    let [fine_most, fine_mean] = sphere(48.0).check(token, 10_000);
    println!("spheres: {most} {mean}, four times finer {fine_most} {fine_mean}");
    // The error in cells is by 1/r: of second order.
    assert!((3.4..4.6).contains(&(mean / fine_mean)), "{mean} {fine_mean}");
    assert!(fine_most < most / 3.4);
}

/// Schoen's gyroid, of a period in cells. Each second derivative is at most the square root of 2 times k^2.
fn gyroid(period: f64, samples: usize) -> Analytic<impl Fn(DVec3) -> f64> {
    let k = std::f64::consts::TAU / period;
    let value = move |p: DVec3| {
        let (sin, cos) = ((p * k).map(f64::sin), (p * k).map(f64::cos));
        sin.x * cos.y + sin.y * cos.z + sin.z * cos.x
    };
    Analytic { samples, value, iso: 0.2, bound: 3.0 * 2.0f64.sqrt() * k * k / 8.0 }
}

fn gyroids_are_smooth(token: AnyToken) {
    let [most, mean] = gyroid(16.0, 49).check(token, 10_000);
    let [fine_most, fine_mean] = gyroid(32.0, 97).check(token, 10_000);
    println!("gyroids: {most} {mean}, twice finer {fine_most} {fine_mean}");
    assert!((3.4..4.6).contains(&(mean / fine_mean)), "{mean} {fine_mean}");
    assert!(fine_most < most / 3.0);
}

/// Marschner and Lobb, "An Evaluation of Reconstruction Filters for Volume Rendering" (1994), on so many samples a side; 41 in the paper.
fn marschner_lobb(samples: usize) -> Analytic<impl Fn(DVec3) -> f64> {
    const PI: f64 = std::f64::consts::PI;
    let (alpha, frequency) = (0.25, 6.0);
    let step = 2.0 / (samples - 1) as f64;
    let value = move |p: DVec3| {
        let p = p * step - 1.0;
        let ring = (2.0 * PI * frequency * (0.5 * PI * p.x.hypot(p.y)).cos()).cos();
        (1.0 - (0.5 * PI * p.z).sin() + alpha * (1.0 + ring)) / (2.0 * (1.0 + alpha))
    };
    // Along x and y: that along the radius, and the slope over the radius; along z that of the sine.
    let (ring, w) = (alpha / (2.0 * (1.0 + alpha)), 2.0 * PI * frequency);
    let quarter = (0.5 * PI).powi(2);
    let second = ring * quarter * (w * w + w) + ring * quarter * w + quarter / (2.0 * (1.0 + alpha));
    Analytic { samples, value, iso: 0.5, bound: second * step * step / 8.0 }
}

fn waves_near_the_limit_of_sampling(token: AnyToken) {
    let [most, mean] = marschner_lobb(41).check(token, 10_000);
    let [fine_most, fine_mean] = marschner_lobb(121).check(token, 10_000);
    println!("Marschner-Lobb: {most} {mean}, three times finer {fine_most} {fine_mean}");
    assert!(fine_mean < mean / 6.0);
}

levels::at_every_level!(spheres_are_round, gyroids_are_smooth, waves_near_the_limit_of_sampling);

/// Cells, each with a ray.
struct Cells<'a> {
    corners: &'a [[f32; 8]],
    rays: &'a [[[f32; 3]; 2]],
}

impl Task for Cells<'_> {
    type Output = Vec<Option<f32>>;

    #[inline(always)]
    fn run<T: Token>(self, token: T) -> Self::Output {
        let zero = token.splat(0.0);
        let mut found = Vec::new();
        for (corners, [origin, direction]) in self.corners.iter().zip(self.rays) {
            let corners = corners.map(|value| token.splat(value));
            let inverse = direction.map(|d| token.splat(1.0 / d));
            let (origin, direction) = (origin.map(|x| token.splat(x)), direction.map(|x| token.splat(x)));
            let rays = RayLanes { origin, direction, inverse, t_min: zero };
            let all = token.mask(u32::MAX);
            let infinity = token.splat(f32::INFINITY);
            let (hit, t) = iso_cell::<T, false>(token, all, &corners, [zero; 3], &rays, infinity);
            let mut ts = [0.0; 16];
            t.store(&mut ts, 0);
            found.push(hit.any().then_some(ts[0]));
        }
        found
    }
}

/// The field along a ray through the unit cell, in double precision, from the constant up.
fn cubic(corners: &[f32; 8], origin: DVec3, direction: DVec3) -> [f64; 4] {
    let mut sum = [0.0; 4];
    for (corner, &value) in corners.iter().enumerate() {
        let mut product = [f64::from(value), 0.0, 0.0, 0.0];
        for axis in 0..3 {
            let (p, d) = (origin[axis], direction[axis]);
            let (p, d) = if corner >> axis & 1 == 1 { (p, d) } else { (1.0 - p, -d) };
            for power in (0..4).rev() {
                product[power] = product[power] * p + if power > 0 { product[power - 1] * d } else { 0.0 };
            }
        }
        (0..4).for_each(|power| sum[power] += product[power]);
    }
    sum
}

/// Rays from nearby: the value at a hit is within 8 units in the last place of the greatest corner, an eighth of what the oracle of
/// the lab leaves to rays from anywhere, and no clear crossing is before it.
fn roots_are_those_of_the_cubic(token: AnyToken) {
    const COUNT: usize = 40_000;
    let mut random = Random(3);
    let mut corners = Vec::new();
    let mut rays = Vec::new();
    for i in 0..COUNT {
        let offset = [0.0, 0.0, 0.4, -0.7][i % 4];
        corners.push([0; 8].map(|_| 2.0 * random.unit() - 1.0 + offset));
        let from = Vec3::splat(0.5) + random.point(4.0);
        let toward = Vec3::splat(0.5) + random.point(1.0) - from;
        rays.push([from.to_array(), toward.to_array()]);
    }
    let found = token.run(Cells { corners: &corners, rays: &rays });
    let (mut hits, mut worst, mut missed) = (0, 0.0f64, 0);
    for ((corners, [origin, direction]), t) in corners.iter().zip(&rays).zip(found) {
        let (origin, direction) = (Vec3::from(*origin).as_dvec3(), Vec3::from(*direction).as_dvec3());
        let [d, c, b, a] = cubic(corners, origin, direction);
        let value = |t: f64| ((a * t + b) * t + c) * t + d;
        let unit = corners.iter().fold(0.0f64, |most, &v| most.max(f64::from(v).abs())) / f64::from(1 << 24);
        let (p, q) = (-origin / direction, (DVec3::ONE - origin) / direction);
        let (near, far) = (p.min(q).max_element().max(0.0), p.max(q).min_element());
        let end = t.map_or(far, f64::from);
        let clear = |from: f64, to: f64| {
            let steps = (0..=200).map(|i| value(from + (to - from) * f64::from(i) / 200.0));
            let (low, high) = steps.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (v.min(l), v.max(h)));
            low < -BOUND * unit && high > BOUND * unit
        };
        if t.is_some() {
            // A field as steep as this changes so much in half a unit of t, and in a millionth of the way through the cell, within
            // which the kernel finds the change of sign.
            let slope = ((3.0 * a * end + 2.0 * b) * end + c).abs();
            let within = end / f64::from(1 << 24) + (far - near) / f64::from(1 << 20);
            let off = (value(end).abs() - slope * within).max(0.0) / unit;
            (hits, worst) = (hits + 1, worst.max(off));
        }
        // The end of a hit is rounded.
        if near < far && clear(near, end * (1.0 - 2e-7) - (far - near) / f64::from(1 << 20)) {
            missed += 1;
        }
    }
    println!("{hits} hits, at most {worst} units from zero");
    assert!(hits > COUNT / 4 && worst <= BOUND, "{}: {worst}", token.level());
    assert_eq!(missed, 0, "{}: a crossing is missed", token.level());
}

/// Units in the last place of the greatest corner that a value may be off.
const BOUND: f64 = 8.0;

levels::at_every_level!(roots_are_those_of_the_cubic);
