//! Ray/triangle: see [`crate::kernel::triangle`] and, with a common origin, [`crate::kernel::edges`].

use mobula_simd::{I32Lanes, Token};

use crate::kernel::edges::{Edges, Window};
use crate::kernel::triangle::{ShearedRay, triangle};
use crate::kernel::{splat3, sub};
use crate::lab::Dice;
use crate::lab::find::{RayTest, in_reach, ray_in_reach};
use crate::oracle::{self, Truth};
use crate::rays::last_axis;
use crate::{Properties, Rays};

/// Nothing is known of the rays: axes are permuted lane by lane.
pub const GENERAL: u8 = 0;
/// All rays have one dominant axis: axes are permuted once per packet.
pub const CONSTANT_AXIS: u8 = 1;
/// One dominant axis and one origin: corners are moved once per triangle, and most rays dismissed by its edge functions.
pub const COMMON_ORIGIN: u8 = 2;
/// So are whole triangles first, by the corners of the packet.
pub const CORNERS: u8 = 3;

/// The test, by what is known of the rays.
#[derive(Debug)]
pub struct Triangle<const CASE: u8>;

/// Triangles that lie together, as in a leaf.
const PER: usize = 4;
/// By corner, axis and place.
type Four = [[[f32; PER]; 3]; 3];

/// The axes in order when the last is dominant.
const AXES: [[usize; 3]; 3] = [[1, 2, 0], [2, 0, 1], [0, 1, 2]];

/// What is common to the rays where the case says so.
#[derive(Clone, Copy, Debug)]
pub struct Common {
    /// In order, the dominant one last.
    axes: [usize; 3],
    origin: [f32; 3],
    window: Window,
}

/// The triangles, and what they look like from the common origin.
#[derive(Clone, Copy, Debug)]
pub struct Prepared {
    four: Four,
    edges: Edges<PER>,
}

fn corners(four: &Four, i: usize) -> [[f32; 3]; 3] {
    four.map(|corner| corner.map(|row| row[i]))
}

impl<const CASE: u8> RayTest for Triangle<CASE> {
    type Primitive = Four;
    const PER: usize = PER;
    type General = Triangle<GENERAL>;
    type Common = Common;
    type Prepared<T: Token> = Prepared;
    const PROMISES: Properties = match CASE {
        COMMON_ORIGIN | CORNERS => Properties::COMMON_ORIGIN.union(Properties::CONSTANT_AXIS),
        CONSTANT_AXIS => Properties::CONSTANT_AXIS,
        _ => Properties::empty(),
    };

    fn draw(dice: &mut Dice<'_>) -> Four {
        let mut four = [[[0.0; PER]; 3]; 3];
        for i in 0..PER {
            let middle = dice.point();
            for corner in &mut four {
                for (row, (x, offset)) in corner.iter_mut().zip(middle.into_iter().zip(dice.point())) {
                    row[i] = x + 0.25 * offset;
                }
            }
        }
        four
    }

    fn aim(dice: &mut Dice<'_>, four: &Four) -> [f32; 3] {
        let [a, b, c] = corners(four, dice.below(PER));
        let (u, v) = (dice.unit(), dice.unit());
        match dice.below(4) {
            0 => a,
            1 => [0, 1, 2].map(|k| b[k] + u * (c[k] - b[k])),
            _ => [0, 1, 2].map(|k| a[k] + u * (b[k] - a[k]) + (1.0 - u) * v * (c[k] - a[k])),
        }
    }

    #[inline(always)]
    fn derive<T: Token, const N: usize>(token: T, rays: &mut Rays<N>) {
        rays.shears(token);
    }

    #[inline(always)]
    fn common<T: Token, const N: usize>(token: T, rays: &Rays<N>) -> Common {
        let first = rays.range().start % N;
        let axes = if CASE == GENERAL { [0, 1, 2] } else { AXES[rays.axes()[first] as usize % 3] };
        let window = match CASE {
            COMMON_ORIGIN | CORNERS => Window::of(token, rays),
            _ => Window::new([0.0; 2], [0.0; 2]),
        };
        let origins = rays.origins();
        Common { axes, origin: [origins[0][first], origins[1][first], origins[2][first]], window }
    }

    #[inline(always)]
    fn prepare<T: Token>(_token: T, four: &Four, common: Common) -> Prepared {
        let edges = match CASE {
            COMMON_ORIGIN | CORNERS => Edges::new(four, common.origin, common.axes, &common.window),
            _ => Edges::NONE,
        };
        Prepared { four: *four, edges }
    }

    const DISMISSES: bool = CASE >= COMMON_ORIGIN;

    #[inline(always)]
    fn may_be_hit<T: Token>(prepared: &Prepared, i: usize) -> bool {
        CASE != CORNERS || prepared.edges.may_be_hit(i)
    }

    #[inline(always)]
    fn may_hit<T: Token, const N: usize>(
        token: T,
        prepared: &Prepared,
        i: usize,
        common: Common,
        rays: &Rays<N>,
        from: usize,
    ) -> u64 {
        prepared.edges.may_hit(token, i, &common.window, rays, from)
    }

    #[inline(always)]
    fn test<T: Token, const N: usize>(
        token: T,
        prepared: &Prepared,
        i: usize,
        common: Common,
        rays: &Rays<N>,
        at: usize,
    ) -> (T::Mask, T::F32) {
        let all = token.mask(u32::MAX);
        let [x, y, z] = common.axes.map(|axis| axis % 3);
        let shear = rays.shear_columns();
        let (t_min, t_max) = (token.load(&rays.t_min()[..], at), token.load(&rays.t_max[..], at));
        let inverse_forward = token.load(&shear[2][..], at);
        let shear = [token.load(&shear[0][..], at), token.load(&shear[1][..], at)];
        let ray = ShearedRay { shear, inverse_forward, t_min, t_max };
        let mut corners = [[token.splat(0.0); 3]; 3];
        for (out, corner) in corners.iter_mut().zip(&prepared.four) {
            let mut moved = [corner[x][i % PER], corner[y][i % PER], corner[z][i % PER]];
            if CASE >= COMMON_ORIGIN {
                moved = [moved[0] - common.origin[x], moved[1] - common.origin[y], moved[2] - common.origin[z]];
            }
            *out = splat3(token, moved);
        }
        if CASE >= COMMON_ORIGIN {
            return triangle::<_, true>(token, all, corners, &ray);
        }
        let [a, b, c] = corners;
        let origins = rays.origins();
        let origin =
            [token.load(&origins[x][..], at), token.load(&origins[y][..], at), token.load(&origins[z][..], at)];
        let (a, b, c) = (sub(a, origin), sub(b, origin), sub(c, origin));
        if CASE == CONSTANT_AXIS {
            return triangle::<_, true>(token, all, [a, b, c], &ray);
        }
        let axes = token.load_u32(&rays.axes()[..], at);
        let (on_y, on_z) = (axes.eq(token.splat_i32(1)), axes.eq(token.splat_i32(2)));
        let corners = [last_axis::<T>(a, on_y, on_z), last_axis::<T>(b, on_y, on_z), last_axis::<T>(c, on_y, on_z)];
        triangle::<_, true>(token, all, corners, &ray)
    }

    fn truth(four: &Four, i: usize, ray: &oracle::Ray) -> Option<(Truth, f64)> {
        let corners = corners(four, i);
        if !ray_in_reach(ray) || !corners.iter().flatten().all(|&x| in_reach(x)) {
            return None;
        }
        let truth = oracle::triangle(ray, corners);
        // Where the plane is met at a grazing angle, a small move of the plane is a large one of the hit.
        let [a, b, c] = corners.map(|corner| corner.map(f64::from));
        let (ab, ac) = (difference(b, a), difference(c, a));
        let normal = cross(ab, ac);
        let size = corners.iter().flatten().zip(ray.origin.iter().cycle()).map(|(&x, o)| f64::from(x).abs() + o.abs());
        let size = size.fold(0.0f64, f64::max);
        let slope = dot(normal, ray.direction).abs();
        // A sliver's normal is uncertain by the sliver's shape.
        let shape = dot(ab, ab).max(dot(ac, ac)) / libm::sqrt(dot(normal, normal));
        Some((truth, 4.0 * size * shape * libm::sqrt(dot(normal, normal)) / slope))
    }
}

pub(super) fn difference(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(super) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
