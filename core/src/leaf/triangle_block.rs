//! Four triangles.

use bytemuck::Zeroable;
use mobula_simd::{F32Lanes, I32Lanes, MaskLanes, Token};

use super::Bounds;
use super::block::{BLOCK, Block};
use super::bounds::FOUR;
use crate::kernel::edges::Edges;
use crate::kernel::few::FewRays;
use crate::kernel::group_shears::GroupShears;
use crate::kernel::triangle::{ShearedRay, triangle};
use crate::rays::{AXES, last_axis};
use crate::{NO_HIT, Rays};

/// Four triangles by corner, axis, and place.
#[derive(Clone, Copy, Debug, Zeroable)]
#[repr(C, align(32))]
pub struct TriangleBlock {
    corners: [[[f32; BLOCK]; 3]; 3],
    ids: [u32; BLOCK],
}

impl TriangleBlock {
    /// The corners of the triangle at a place.
    ///
    /// # Panics
    /// If there is no such place.
    pub fn corners(&self, place: usize) -> [[f32; 3]; 3] {
        self.corners.map(|corner| corner.map(|row| row[place]))
    }
}

impl Block for TriangleBlock {
    /// The corners.
    type Primitive = [[f32; 3]; 3];
    const EMPTY: Self = Self { corners: [[[f32::NAN; BLOCK]; 3]; 3], ids: [NO_HIT; BLOCK] };
    const NOWHERE: [[f32; 3]; 3] = [[f32::NAN; 3]; 3];

    type Prepared = [[[f32; BLOCK]; 3]; 3];

    #[inline(always)]
    fn bounds(corners: &[[f32; 3]; 3]) -> Option<Bounds> {
        let [a, b, c] = corners;
        let row = |p: &[f32; 3]| FOUR.load(&[p[0], p[1], p[2], 0.0], 0);
        let (a, b, c) = (row(a), row(b), row(c));
        // What is not finite gives no number.
        let zero = FOUR.splat(0.0);
        let sound =
            (a * zero + b * zero + c * zero).eq(zero).all() && !a.eq(b).all() && !b.eq(c).all() && !c.eq(a).all();
        sound.then(|| {
            let mut bounds = Bounds::EMPTY;
            a.min(b).min(c).store(&mut bounds.low, 0);
            a.max(b).max(c).store(&mut bounds.high, 0);
            bounds
        })
    }

    #[inline(always)]
    fn set(&mut self, place: usize, id: u32, corners: &[[f32; 3]; 3]) {
        for (rows, corner) in self.corners.iter_mut().zip(corners) {
            for (row, &x) in rows.iter_mut().zip(corner) {
                row[place] = x;
            }
        }
        self.ids[place] = id;
    }

    #[inline(always)]
    fn whole(&self) -> Bounds {
        let mut bounds = Bounds::EMPTY;
        for axis in 0..3 {
            let [a, b, c] = [0, 1, 2].map(|corner| FOUR.load(&self.corners[corner][axis], 0));
            let (mut lows, mut highs) = ([0.0; BLOCK], [0.0; BLOCK]);
            a.min(b).min(c).store(&mut lows, 0);
            a.max(b).max(c).store(&mut highs, 0);
            bounds.low[axis] = lows.into_iter().fold(f32::INFINITY, |a, b| if b < a { b } else { a });
            bounds.high[axis] = highs.into_iter().fold(f32::NEG_INFINITY, |a, b| if b > a { b } else { a });
        }
        bounds
    }

    #[inline(always)]
    fn ids(&self, _number: usize) -> [u32; BLOCK] {
        self.ids
    }

    #[inline(always)]
    fn prepare<const N: usize, const COMMON_ORIGIN: bool>(&self, rays: &Rays<N>) -> [[[f32; BLOCK]; 3]; 3] {
        let mut corners = self.corners;
        if COMMON_ORIGIN {
            let first = rays.range().start;
            for corner in &mut corners {
                for (row, origin) in corner.iter_mut().zip(rays.origins()) {
                    for x in row {
                        *x -= origin[first];
                    }
                }
            }
        }
        corners
    }

    #[inline(always)]
    fn touched<T: Token, const N: usize>(
        token: T,
        prepared: &[[[f32; BLOCK]; 3]; 3],
        axis: usize,
        shears: &GroupShears,
    ) -> [u32; BLOCK] {
        let axes = AXES[axis % 3];
        let edges = match &shears.parallel {
            None => Edges::new(prepared, [0.0; 3], axes, &shears.window),
            Some(parallel) => Edges::parallel(prepared, parallel, axes, &shears.window),
        };
        let mut touched = [0; BLOCK];
        for (i, touched) in touched.iter_mut().enumerate() {
            if edges.may_be_hit(i) {
                *touched = edges.groups::<T, N>(token, i, shears);
            }
        }
        touched
    }

    #[inline(always)]
    fn test<T: Token, const N: usize, const COMMON_ORIGIN: bool, const OWN_AXES: bool>(
        token: T,
        prepared: &[[[f32; BLOCK]; 3]; 3],
        i: usize,
        axis: usize,
        rays: &Rays<N>,
        at: usize,
        among: T::Mask,
    ) -> (T::Mask, T::F32) {
        let shear = rays.shear_columns();
        let (t_min, t_max) = (token.load(&rays.t_min()[..], at), token.load(&rays.t_max[..], at));
        let inverse_forward = token.load(&shear[2][..], at);
        let shear = [token.load(&shear[0][..], at), token.load(&shear[1][..], at)];
        let ray = ShearedRay { shear, inverse_forward, t_min, t_max };
        let axes = if OWN_AXES { [0, 1, 2] } else { AXES[axis % 3] };
        let mut corners = [[token.splat(0.0); 3]; 3];
        for (out, corner) in corners.iter_mut().zip(prepared) {
            for (x, axis) in out.iter_mut().zip(axes) {
                *x = token.splat(corner[axis][i]);
                if !COMMON_ORIGIN {
                    *x = *x - token.load(&rays.origins()[axis][..], at);
                }
            }
        }
        if OWN_AXES {
            let axes = token.load_u32(&rays.axes()[..], at);
            let (on_y, on_z) = (axes.eq(token.splat_i32(1)), axes.eq(token.splat_i32(2)));
            for corner in &mut corners {
                *corner = last_axis::<T>(*corner, on_y, on_z);
            }
        }
        triangle::<T, false>(token, among, corners, &ray)
    }

    #[inline(always)]
    fn test_few<T: Token>(&self, token: T, rays: &FewRays<T>, i: usize) -> (T::Mask, T::F32) {
        let axes = if rays.own_axes.is_some() { [0, 1, 2] } else { AXES[rays.axis % 3] };
        let mut corners = [rays.origin; 3];
        for (out, corner) in corners.iter_mut().zip(&self.corners) {
            for (x, axis) in out.iter_mut().zip(axes) {
                *x = token.repeat(&corner[axis], i) - rays.origin[axis];
            }
        }
        if let Some([on_y, on_z]) = rays.own_axes {
            for corner in &mut corners {
                *corner = last_axis::<T>(*corner, on_y, on_z);
            }
        }
        let [x, y, inverse_forward] = rays.shear;
        let ray = ShearedRay { shear: [x, y], inverse_forward, t_min: rays.t_min, t_max: rays.t_max };
        triangle::<T, true>(token, token.mask(u32::MAX), corners, &ray)
    }
}
