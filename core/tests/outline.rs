//! The outline of a sphere dismisses no ray that the exact test finds, and hardly keeps one that it does not: spheres from
//! specks to ones around the origin, near and far, rays at the outline and all around.

use mobula_core::kernel::sphere::{dismisses, outline, sphere};
use mobula_core::kernel::{load3, splat3};
use mobula_core::lab::Dice;
use mobula_core::simd::{AnyToken, MaskLanes, Task, Token};

const N: usize = 16;

/// Rays that the exact test finds, that are kept, and that were wrongly dismissed.
#[derive(Debug, Default)]
struct Counts {
    found: u32,
    kept: u32,
    lost: u32,
}

/// A sphere `-center` away from the origin of the rays.
struct Compare<'a, const UNIT: bool> {
    center: [f32; 3],
    radius: f32,
    directions: &'a [[f32; N]; 3],
    counts: &'a mut Counts,
}

impl<const UNIT: bool> Task for Compare<'_, UNIT> {
    type Output = ();

    #[inline(always)]
    fn run<T: Token>(self, token: T) {
        let (center, radius) = (splat3(token, self.center), token.splat(self.radius));
        let radius2 = radius * radius;
        let outline = outline(token, center, radius2);
        let all = token.mask(u32::MAX);
        let mut at = 0;
        while at < N {
            let direction = load3(token, self.directions, at);
            let kept = !dismisses::<T, UNIT>(outline, center, direction);
            let (least, most) = (token.splat(f32::NEG_INFINITY), token.splat(f32::INFINITY));
            let (found, _) = sphere::<T, UNIT>(token, all, center, radius2, direction, least, most);
            self.counts.found += found.bits().count_ones();
            self.counts.kept += kept.bits().count_ones();
            self.counts.lost += found.and_not(kept).bits().count_ones();
            at += T::LANES;
        }
    }
}

fn power(dice: &mut Dice<'_>, least: f32, greatest: f32) -> f32 {
    10f32.powf(least + dice.unit() * (greatest - least))
}

fn length(v: [f32; 3]) -> f32 {
    v.iter().map(|x| x * x).sum::<f32>().sqrt()
}

/// Where a sphere is seen from the rays' origin, its radius, and directions around its outline.
fn draw(dice: &mut Dice<'_>, unit: bool, distances: [f32; 2], sizes: [f32; 2]) -> ([f32; 3], f32, [[f32; N]; 3]) {
    let distance = power(dice, distances[0], distances[1]);
    let to_center = [dice.signed() * distance, dice.signed() * distance, dice.signed() * distance];
    let radius = distance * power(dice, sizes[0], sizes[1]);
    let mut directions = [[0.0; N]; 3];
    for i in 0..N {
        let across = [dice.signed(), dice.signed(), dice.signed()];
        let near = radius * (1.0 + dice.signed() * power(dice, -7.0, 0.0)) / length(across);
        let mut d = [0, 1, 2].map(|k| to_center[k] + near * across[k]);
        let scale = if unit { 1.0 / length(d) } else { power(dice, -12.0, 12.0) / distance };
        d = d.map(|x| x * scale);
        for k in 0..3 {
            directions[k][i] = d[k];
        }
    }
    (to_center.map(|x| -x), radius, directions)
}

fn compare(seed: u64, cases: usize, distances: [f32; 2], sizes: [f32; 2]) {
    let mut dice = Dice::from_seed(seed);
    for token in AnyToken::available() {
        let mut counts = [Counts::default(), Counts::default()];
        for _ in 0..cases {
            for (unit, counts) in counts.iter_mut().enumerate() {
                let (center, radius, directions) = draw(&mut dice, unit == 1, distances, sizes);
                let directions = &directions;
                match unit {
                    0 => token.run(Compare::<false> { center, radius, directions, counts }),
                    _ => token.run(Compare::<true> { center, radius, directions, counts }),
                }
            }
        }
        for Counts { found, kept, lost } in counts {
            assert_eq!(lost, 0, "{token:?}: of {found} hits");
            assert!(found > cases as u32, "{token:?}: the test aims at nothing: {found} hits");
            assert!(kept < found + found / 5 || sizes[0] < -4.0, "{token:?}: {kept} kept for {found} hits");
        }
    }
}

/// 5000 cases a level, or as many as `MOBULA_OUTLINE_CASES` says.
fn cases() -> usize {
    std::env::var("MOBULA_OUTLINE_CASES").ok().and_then(|n| n.parse().ok()).unwrap_or(5000)
}

#[test]
fn no_hit_is_dismissed() {
    compare(1, cases(), [-3.0, 3.0], [-2.0, 0.2]);
}

#[test]
fn no_hit_of_a_speck_or_an_extreme_size_is_dismissed() {
    compare(2, cases(), [-18.0, 18.0], [-7.0, 0.5]);
}
