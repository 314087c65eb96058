//! Rays through the cells of a brick, a ray a lane, from plane to plane (after Amanatides and Woo, "A Fast Voxel Traversal
//! Algorithm for Ray Tracing", Eurographics 1987).
//!
//! A ray meets the plane at k at `(k - origin) / direction`, by the same arithmetic as in [`super::iso_cell`], not by adding up:
//! so the cells that are visited are those in which the ray has an interval that is not empty there, no other, on every path.
//! Where several planes are met at once, all are stepped over.
//!
//! - NaN: a ray with a NaN is in no cell.
//! - Zero direction: the reciprocal is finite (see [`Rays::inverse_directions`](crate::Rays::inverse_directions)).

use mobula_simd::{F32Lanes, I32Lanes, MaskLanes, Token};

/// Cells of a brick along each axis, at most.
const MOST: [usize; 3] = [8, 4, 4];
/// What numbers of cells are made with.
const SHIFTS: [u32; 3] = [0, 3, 5];

/// A ray in each lane.
#[derive(Clone, Copy, Debug)]
pub struct RayLanes<T: Token> {
    /// Origin.
    pub origin: [T::F32; 3],
    /// Direction.
    pub direction: [T::F32; 3],
    /// See [`Rays::inverse_directions`](crate::Rays::inverse_directions).
    pub inverse: [T::F32; 3],
    /// Near end of the interval.
    pub t_min: T::F32,
}

impl<T: Token> RayLanes<T> {
    /// Which rays have no NaN.
    #[inline(always)]
    pub fn sound(&self) -> T::Mask {
        let (origin, direction) = (self.origin, self.direction);
        let sum = ((origin[0] + direction[0]) + (origin[1] + direction[1])) + (origin[2] + direction[2]);
        sum.eq(sum)
    }
}

/// Where rays are in a brick of up to 8 x 4 x 4 cells; cell (i, j, k) has the number i + 8 j + 32 k.
#[derive(Clone, Copy, Debug)]
pub struct CellWalk<T: Token> {
    /// Which rays are in it.
    pub inside: T::Mask,
    /// The numbers of the cells that they are in.
    pub cell: T::I32,
    /// Where they entered these.
    pub entered: T::F32,
    /// The plane that they meet next along each axis, and where that is.
    plane: [T::F32; 3],
    next: [T::F32; 3],
    /// From plane to plane, and from cell to cell.
    step: [T::F32; 3],
    stride: [T::I32; 3],
    /// Where they leave the brick.
    far: T::F32,
}

impl<T: Token> CellWalk<T> {
    /// The rays `among` where they enter the brick with the low corner `first` and so many cells along each axis, if they do before
    /// `t_max`.
    #[inline(always)]
    pub fn new(
        token: T,
        rays: &RayLanes<T>,
        among: T::Mask,
        t_max: T::F32,
        first: [usize; 3],
        cells: [usize; 3],
    ) -> Self {
        let (zero, one) = (token.splat(0.0), token.splat(1.0));
        let (mut near, mut far) = (rays.t_min, token.splat(f32::INFINITY));
        for axis in 0..3 {
            let a = meets(token, rays, axis, first[axis]);
            let b = meets(token, rays, axis, first[axis] + cells[axis]);
            (near, far) = (a.min(b).max(near), a.max(b).min(far));
        }
        let inside = among & near.lt(far) & near.le(t_max) & rays.sound();
        let mut walk = Self {
            inside,
            cell: token.splat_i32(0),
            entered: near,
            plane: [zero; 3],
            next: [zero; 3],
            step: [one; 3],
            stride: [token.splat_i32(0); 3],
            far,
        };
        if !inside.any() {
            return walk;
        }
        for axis in 0..3 {
            let mut behind = zero;
            let low = token.splat(first[axis] as f32);
            for k in 1..MOST[axis] {
                if k < cells[axis] {
                    let plane = ((low + token.splat(k as f32)) - rays.origin[axis]) * rays.inverse[axis];
                    behind = (behind + one).select(plane.le(near), behind);
                }
            }
            let forward = rays.inverse[axis].gt(zero);
            let last = token.splat((cells[axis] - 1) as f32);
            let place = behind.select(forward, last - behind);
            let shift = SHIFTS[axis];
            walk.cell = walk.cell + place.to_i32().shl(shift);
            walk.step[axis] = one.select(forward, -one);
            walk.stride[axis] = token.splat_i32(1 << shift).select(forward, token.splat_i32(-1 << shift));
            walk.plane[axis] = (place + one.select(forward, zero)) + low;
            walk.next[axis] = (walk.plane[axis] - rays.origin[axis]) * rays.inverse[axis];
        }
        walk
    }

    /// Moves rays on to the next cell, if that is entered before `gate`. Those that are not inside go anywhere.
    ///
    /// A ray waits where the gate is `-inf`: not by a mask, which would be on the way from one step to the next.
    #[inline(always)]
    pub fn advance(&mut self, rays: &RayLanes<T>, gate: T::F32) {
        let out = self.next[0].min(self.next[1]).min(self.next[2]).min(gate);
        for axis in 0..3 {
            let over = self.next[axis].le(out);
            self.plane[axis] = (self.plane[axis] + self.step[axis]).select(over, self.plane[axis]);
            self.cell = (self.cell + self.stride[axis]).select(over, self.cell);
            self.next[axis] = (self.plane[axis] - rays.origin[axis]) * rays.inverse[axis];
        }
        self.entered = out.max(self.entered);
        self.inside = self.inside & self.entered.lt(self.far);
    }

    /// The low corners of these cells.
    #[inline(always)]
    pub fn low(&self) -> [T::F32; 3] {
        let mut low = self.plane;
        for axis in 0..3 {
            low[axis] = (self.plane[axis] - self.step[axis]).min(self.plane[axis]);
        }
        low
    }
}

/// Where rays meet the plane at `k`.
#[inline(always)]
fn meets<T: Token>(token: T, rays: &RayLanes<T>, axis: usize, k: usize) -> T::F32 {
    (token.splat(k as f32) - rays.origin[axis]) * rays.inverse[axis]
}
