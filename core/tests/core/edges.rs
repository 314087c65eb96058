//! Edge functions dismiss no group of rays that has one which the exact test finds, and keep few groups that have none: triangles
//! from needles to walls, near and far, packets from narrow to as wide as the dominant axis lets them be, rays at corners and
//! edges.

use crate::common::Random;
use mobula_core::kernel::edges::Edges;
use mobula_core::kernel::frusta::Frusta;
use mobula_core::kernel::group_bounds::{GroupBounds, MIXED};
use mobula_core::kernel::margin::Frame;
use mobula_core::kernel::triangle::{ShearedRay, triangle};
use mobula_core::simd::{AnyToken, MaskLanes, Task, Token};
use mobula_core::vector::{splat3, sub};
use mobula_core::{Properties, Rays};

/// Numbers for a case.
struct Dice(Random);

impl Dice {
    fn from_seed(seed: u64) -> Self {
        Self(Random(seed ^ 0x9e37_79b9_7f4a_7c15))
    }

    fn unit(&mut self) -> f32 {
        self.0.unit()
    }

    fn signed(&mut self) -> f32 {
        2.0 * self.0.unit() - 1.0
    }

    fn below(&mut self, n: usize) -> usize {
        self.0.below(n)
    }

    fn one_in(&mut self, n: usize) -> bool {
        self.0.below(n) == 0
    }
}

const N: usize = 64;
type Corners = [[f32; 3]; 3];

/// Rays in a group.
const GROUP: usize = 16;

/// Groups that were tested, that have a ray which the exact test finds, that may be hit, and that were wrongly dismissed.
#[derive(Clone, Copy, Debug, Default)]
struct Counts {
    tested: u64,
    found: u64,
    kept: u64,
    lost: u64,
}

struct Compare<'a> {
    rays: &'a mut Rays<N>,
    corners: &'a [Corners; 4],
    counts: &'a mut Counts,
}

impl Task for Compare<'_> {
    type Output = ();

    #[inline(always)]
    fn run<T: Token>(self, token: T) {
        self.rays.shears(token);
        let rays = &*self.rays;
        let bounds = GroupBounds::new::<T, N, true>(token, rays, &Frame::default());
        let class = bounds.class(0);
        // A ray whose shear is not a number, or groups that go opposite ways.
        if class == MIXED || bounds.of_class(class) & 0xf != 0xf {
            return;
        }
        let frusta = Frusta::new::<T, N, true>(token, &bounds, rays, class);
        let Some(shears) = frusta.shears() else { return };
        let axes = [[1, 2, 0], [2, 0, 1], [0, 1, 2]][rays.axes()[0] as usize];
        let origin = rays.ray(0).0.to_array();
        let mut four = [[[0.0; 4]; 3]; 3];
        for (i, corners) in self.corners.iter().enumerate() {
            for (k, corner) in corners.iter().enumerate() {
                for (axis, x) in corner.iter().enumerate() {
                    four[k][axis][i] = *x;
                }
            }
        }
        let edges = Edges::new(&four, origin, axes, &shears.window);
        for (i, corners) in self.corners.iter().enumerate() {
            let may = u64::from(edges.groups::<T, N>(token, i, shears)) & 0xf;
            let mut found = 0u64;
            let [x, y, z] = axes;
            let origin = splat3(token, [origin[x], origin[y], origin[z]]);
            let relative = corners.map(|c| sub(splat3(token, [c[x], c[y], c[z]]), origin));
            let mut at = 0;
            while at < N {
                let [sx, sy, forward] = rays.shear_columns();
                let ray = ShearedRay {
                    shear: [token.load(&sx[..], at), token.load(&sy[..], at)],
                    inverse_forward: token.load(&forward[..], at),
                    t_min: token.splat(f32::NEG_INFINITY),
                    t_max: token.splat(f32::INFINITY),
                };
                let (hit, _) = triangle::<_, true>(token, token.mask(u32::MAX), relative, &ray);
                found |= u64::from(hit.bits()) << at;
                at += T::LANES;
            }
            let mut groups = 0u64;
            for group in 0..N / GROUP {
                groups |= u64::from(found >> (group * GROUP) & 0xffff != 0) << group;
            }
            let found = groups;
            let lost = found & !may | if edges.may_be_hit(i) { 0 } else { found };
            self.counts.tested += (N / GROUP) as u64;
            self.counts.found += u64::from(found.count_ones());
            self.counts.kept += u64::from(may.count_ones());
            self.counts.lost += u64::from(lost.count_ones());
        }
    }
}

/// A case: a packet into a cone of some width, four triangles of some size somewhere in it. Also whether they can be told apart:
/// groups that stay close together, sizes that rounding does not blur (not a million times smaller than they are far).
fn draw(dice: &mut Dice) -> (Rays<N>, [Corners; 4], bool) {
    let power = |dice: &mut Dice, least: f32, greatest: f32| 10f32.powf(least + dice.unit() * (greatest - least));
    let shift = power(dice, -3.0, 3.0);
    let origin = [dice.signed() * shift, dice.signed() * shift, dice.signed() * shift];
    let (distance, size, width) = (power(dice, -3.0, 3.0), power(dice, -6.0, 1.0), power(dice, -5.0, 0.0));
    let axis = dice.below(3);
    let middle = [dice.signed() * 0.9, dice.signed() * 0.9];
    let direction = |dice: &mut Dice, width: f32| {
        let mut d = [0.0; 3];
        d[axis] = if dice.one_in(16) { -1.0 } else { 1.0 };
        for k in 0..2 {
            d[(axis + 1 + k) % 3] = middle[k] + width * dice.signed();
        }
        d
    };
    let at = |d: [f32; 3], t: f32| [0, 1, 2].map(|k| origin[k] + d[k] * t);
    let mut triangles = [[[0.0; 3]; 3]; 4];
    for corners in &mut triangles {
        let center = at(direction(dice, width), distance);
        let thin = dice.one_in(4);
        for corner in &mut *corners {
            *corner = center.map(|x| x + distance * size * dice.signed());
        }
        if thin {
            // A needle: the third corner nearly on the line of the others.
            let u = dice.signed();
            let [a, b, c] = *corners;
            corners[2] = [0, 1, 2].map(|k| a[k] + u * (b[k] - a[k]) + 1e-4 * (c[k] - a[k]));
        }
    }
    let mut rays = Rays::<N>::default();
    rays.reset(0..N, Properties::empty());
    // Half of the packets have groups that stay close together, as those of a camera do.
    let narrow = dice.one_in(2);
    let mut ahead = None;
    for i in 0..N {
        if narrow && i % GROUP != 0 {
            let d: [f32; 3] = ahead.unwrap_or_default();
            rays.set_ray(i, origin.into(), d.map(|x| x + 0.01 * width * dice.signed()).into());
            continue;
        }
        let [a, b, c] = triangles[dice.below(4)];
        let (u, v) = (dice.unit(), dice.unit());
        let target = match dice.below(4) {
            0 => Some(a),
            1 => Some([0, 1, 2].map(|k| b[k] + u * (c[k] - b[k]))),
            2 => Some([0, 1, 2].map(|k| a[k] + u * (b[k] - a[k]) + (1.0 - u) * v * (c[k] - a[k]))),
            _ => None,
        };
        let d = target.map_or_else(|| direction(dice, width), |to| [0, 1, 2].map(|k| to[k] - origin[k]));
        rays.set_ray(i, origin.into(), d.into());
        let length = d.iter().fold(0.0f32, |length, x| length.max(x.abs()));
        ahead = Some(d.map(|x| x / length));
    }
    rays.promise(Properties::COMMON_ORIGIN);
    (rays, triangles, narrow && size > 1e-3 && size * distance > 1e-3 * shift)
}

fn compare(token: AnyToken) {
    let (mut blurred, mut clear) = (Counts::default(), Counts::default());
    for seed in 0..20_000 {
        let (mut rays, corners, is_clear) = draw(&mut Dice::from_seed(seed));
        let counts = if is_clear { &mut clear } else { &mut blurred };
        token.run(Compare { rays: &mut rays, corners: &corners, counts });
        assert_eq!(counts.lost, 0, "{token:?}, seed {seed}: rays were dismissed that hit one of {corners:?}");
    }
    assert!(blurred.found > 10_000 && clear.found > 5_000, "{blurred:?} {clear:?}");
    // Rays at edges and corners may be off by rounding either way; most groups here are aimed at them; others are told apart.
    assert!(clear.kept - clear.found < (clear.tested - clear.found) / 4, "{clear:?}");
}

#[test]
fn edges_dismiss_nothing_that_is_hit() {
    for token in AnyToken::available() {
        compare(token);
    }
}
