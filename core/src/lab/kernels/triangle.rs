//! Ray/triangle: see [`crate::kernel::triangle`].

use mobula_simd::{I32Lanes, Token};

use crate::kernel::triangle::{ShearedRay, triangle};
use crate::kernel::{load3, splat3, sub};
use crate::lab::Dice;
use crate::lab::find::{RayTest, in_reach, ray_in_reach};
use crate::oracle::{self, Truth};
use crate::rays::last_axis;
use crate::{Properties, Rays};

/// Nothing is known of the rays: axes are permuted lane by lane.
pub const GENERAL: u8 = 0;
/// All rays have one dominant axis: axes are permuted once per packet.
pub const CONSTANT_AXIS: u8 = 1;
/// One dominant axis and one origin: corners are moved and permuted once per triangle.
pub const COMMON_ORIGIN: u8 = 2;

/// The test, by what is known of the rays.
#[derive(Debug)]
pub struct Triangle<const CASE: u8>;

/// The axes in order when the last is dominant.
const AXES: [[usize; 3]; 3] = [[1, 2, 0], [2, 0, 1], [0, 1, 2]];

impl<const CASE: u8> RayTest for Triangle<CASE> {
    type Primitive = [[f32; 3]; 3];
    type General = Triangle<GENERAL>;
    /// The axes, the dominant one last, and the origin, both where they are common.
    type Common = ([usize; 3], [f32; 3]);
    type Prepared<T: Token> = [[T::F32; 3]; 3];
    const PROMISES: Properties = match CASE {
        COMMON_ORIGIN => Properties::COMMON_ORIGIN.union(Properties::CONSTANT_AXIS),
        CONSTANT_AXIS => Properties::CONSTANT_AXIS,
        _ => Properties::empty(),
    };

    fn draw(dice: &mut Dice<'_>) -> [[f32; 3]; 3] {
        let middle = dice.point();
        let mut corner = || {
            let offset = dice.point();
            [0, 1, 2].map(|k| middle[k] + 0.25 * offset[k])
        };
        [corner(), corner(), corner()]
    }

    fn aim(dice: &mut Dice<'_>, &[a, b, c]: &[[f32; 3]; 3]) -> [f32; 3] {
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
    fn common<const N: usize>(rays: &Rays<N>) -> ([usize; 3], [f32; 3]) {
        let first = rays.range().start % N;
        let axes = if CASE == GENERAL { [0, 1, 2] } else { AXES[rays.axes()[first] as usize % 3] };
        let mut origin = [0.0; 3];
        for (x, axis) in origin.iter_mut().zip(axes) {
            *x = rays.origins()[axis][first];
        }
        (axes, origin)
    }

    #[inline(always)]
    fn prepare<T: Token>(
        token: T,
        corners: &[[f32; 3]; 3],
        (axes, origin): ([usize; 3], [f32; 3]),
    ) -> [[T::F32; 3]; 3] {
        let mut out = [splat3(token, [0.0; 3]); 3];
        for (out, corner) in out.iter_mut().zip(corners) {
            let mut moved = [0.0; 3];
            for k in 0..3 {
                // Not only a lookup: the compiler sees here that it is within the array.
                moved[k] = corner[axes[k] % 3];
                if CASE == COMMON_ORIGIN {
                    moved[k] -= origin[k];
                }
            }
            *out = splat3(token, moved);
        }
        out
    }

    #[inline(always)]
    fn test<T: Token, const N: usize>(
        token: T,
        corners: &[[T::F32; 3]; 3],
        (axes, _): ([usize; 3], [f32; 3]),
        rays: &Rays<N>,
        at: usize,
    ) -> (T::Mask, T::F32) {
        let all = token.mask(u32::MAX);
        let shear = rays.shear_columns();
        let (t_min, t_max) = (token.load(&rays.t_min()[..], at), token.load(&rays.t_max[..], at));
        let inverse_forward = token.load(&shear[2][..], at);
        let shear = [token.load(&shear[0][..], at), token.load(&shear[1][..], at)];
        let ray = ShearedRay { shear, inverse_forward, t_min, t_max };
        if CASE == GENERAL {
            let axes = token.load_u32(&rays.axes()[..], at);
            let (on_y, on_z) = (axes.eq(token.splat_i32(1)), axes.eq(token.splat_i32(2)));
            let origin = load3(token, rays.origins(), at);
            let [a, b, c] = *corners;
            let corners = [
                last_axis::<T>(sub(a, origin), on_y, on_z),
                last_axis::<T>(sub(b, origin), on_y, on_z),
                last_axis::<T>(sub(c, origin), on_y, on_z),
            ];
            return triangle(token, all, corners, &ray);
        }
        if CASE == COMMON_ORIGIN {
            return triangle(token, all, *corners, &ray);
        }
        let mut origin = [token.splat(0.0); 3];
        for (x, axis) in origin.iter_mut().zip(axes) {
            *x = token.load(&rays.origins()[axis % 3][..], at);
        }
        let [a, b, c] = *corners;
        triangle(token, all, [sub(a, origin), sub(b, origin), sub(c, origin)], &ray)
    }

    fn truth(corners: &[[f32; 3]; 3], ray: &oracle::Ray) -> Option<(Truth, f64)> {
        if !ray_in_reach(ray) || !corners.iter().flatten().all(|&x| in_reach(x)) {
            return None;
        }
        let truth = oracle::triangle(ray, *corners);
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
