//! Where most of a scene is: a stray vertex far away must not decide where the eye and the light are.

use glam::Vec3;

/// What is farther from the middle than so many times the size of most is not looked at.
const FAR: f32 = 256.0;
/// So many points at most say what most is.
pub(super) const SAMPLES: usize = 4096;

/// The bounds of all points but those that are far from most of them. `visit_all` calls its argument with all points, `visit_some` with
/// some that are drawn from all; `bounds` are those of all.
pub(super) fn bulk(
    visit_some: impl FnOnce(&mut dyn FnMut(Vec3)),
    visit_all: impl FnOnce(&mut dyn FnMut(Vec3)),
    bounds: (Vec3, Vec3),
) -> (Vec3, Vec3) {
    let samples = samples(visit_some);
    if samples.is_empty() {
        return bounds;
    }
    let at = |mut values: Vec<f32>, share: usize| {
        let place = (values.len() - 1) * share / 16;
        *values.select_nth_unstable_by(place, f32::total_cmp).1
    };
    let middle = Vec3::from([0, 1, 2].map(|axis| at(samples.iter().map(|p| p[axis]).collect(), 8)));
    let distance = |point: Vec3| (point - middle).abs().max_element();
    let reach = at(samples.iter().map(|&point| distance(point)).collect(), 14) * FAR;
    let all = distance(bounds.0).max(distance(bounds.1));
    if reach <= 0.0 || all <= reach || !reach.is_finite() {
        return bounds;
    }
    let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    visit_all(&mut |point| {
        if distance(point) <= reach {
            (low, high) = (low.min(point), high.max(point));
        }
    });
    if low.cmple(high).all() { (low, high) } else { bounds }
}

/// Some of the points, drawn from all of them, the same each time.
fn samples(visit_all: impl FnOnce(&mut dyn FnMut(Vec3))) -> Vec<Vec3> {
    let (mut samples, mut mask, mut number) = (Vec::new(), 0_u32, 0_u32);
    // Which ones looks random: points come in patterns.
    let lot = |number: u32| (number.wrapping_mul(0x9e37_79b1) ^ 0x5bd1_e995).wrapping_mul(0x85eb_ca77) >> 7;
    visit_all(&mut |point| {
        if lot(number) & mask == 0 && point.is_finite() {
            samples.push((lot(number), point));
            while samples.len() == 2 * SAMPLES && mask < u32::MAX >> 8 {
                mask = mask << 1 | 1;
                samples.retain(|(lot, _)| lot & mask == 0);
            }
        }
        number = number.wrapping_add(1);
    });
    samples.into_iter().map(|(_, point)| point).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(points: &[Vec3]) -> (Vec3, Vec3) {
        let bounds = points.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(a, b), &p| (a.min(p), b.max(p)));
        let visit = |visit: &mut dyn FnMut(Vec3)| points.iter().for_each(|&point| visit(point));
        bulk(visit, visit, bounds)
    }

    #[test]
    fn what_is_far_from_the_rest_does_not_count() {
        let near: Vec<Vec3> = (0..20_000).map(|i| Vec3::new((i % 100) as f32, (i / 100) as f32, 0.5)).collect();
        assert_eq!(of(&near), (near[0], near[19_999]), "all of it");
        for stray in [1e5, -1e7, 1e30] {
            let with: Vec<Vec3> = near.iter().copied().chain([Vec3::splat(stray)]).collect();
            assert_eq!(of(&with), (near[0], near[19_999]), "{stray}");
        }
        // Two halves far apart are both meant.
        let halves: Vec<Vec3> = near.iter().flat_map(|&p| [p, p + Vec3::splat(1e6)]).collect();
        assert_eq!(of(&halves).1, near[19_999] + Vec3::splat(1e6));
        assert_eq!(of(&[Vec3::ONE, Vec3::ONE]), (Vec3::ONE, Vec3::ONE));
        assert_eq!(of(&[]).0, Vec3::INFINITY);
    }
}
