//! Axis-aligned bounds while building: four floats a corner, so that min and max are one instruction.

use mobula_simd::{Sse2, Token};

use crate::kernel::margin::Frame;

/// A vector of one point, whatever the level.
pub(crate) type Four = <Sse2 as Token>::F32;

/// What makes one.
pub(crate) const FOUR: Sse2 = Sse2::new();

/// Least and greatest corner. The fourth component is padding.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(16))]
pub struct Bounds {
    /// Least corner.
    pub low: [f32; 4],
    /// Greatest corner.
    pub high: [f32; 4],
}

impl Bounds {
    /// Contains nothing.
    pub const EMPTY: Self = Self { low: [f32::INFINITY; 4], high: [f32::NEG_INFINITY; 4] };

    /// Bounds of points; NaN coordinates are passed over.
    #[inline(always)]
    pub fn of_points(points: &[[f32; 3]]) -> Self {
        let mut bounds = Self::EMPTY;
        for &[x, y, z] in points {
            bounds.grow([x, y, z, 0.0]);
        }
        bounds
    }

    /// Takes a point in.
    #[inline(always)]
    pub fn grow(&mut self, point: [f32; 4]) {
        for axis in 0..4 {
            self.low[axis] = if point[axis] < self.low[axis] { point[axis] } else { self.low[axis] };
            self.high[axis] = if point[axis] > self.high[axis] { point[axis] } else { self.high[axis] };
        }
    }

    /// Takes other bounds in.
    #[inline(always)]
    pub fn merge(&mut self, other: &Self) {
        for axis in 0..4 {
            self.low[axis] = if other.low[axis] < self.low[axis] { other.low[axis] } else { self.low[axis] };
            self.high[axis] = if other.high[axis] > self.high[axis] { other.high[axis] } else { self.high[axis] };
        }
    }

    /// Half the surface area; 0 when empty.
    #[inline(always)]
    pub fn half_area(&self) -> f32 {
        let d: [f32; 3] = core::array::from_fn(|axis| (self.high[axis] - self.low[axis]).max(0.0));
        d[0] * d[1] + d[1] * d[2] + d[2] * d[0]
    }

    /// Twice the middle: what the builder sorts by.
    #[inline(always)]
    pub fn middle2(&self) -> [f32; 4] {
        core::array::from_fn(|axis| self.low[axis] + self.high[axis])
    }

    /// One step outwards to the next numbers on each side: for corners that were rounded once.
    #[inline(always)]
    pub fn outward(&self) -> Self {
        Self { low: self.low.map(f32::next_down), high: self.high.map(f32::next_up) }
    }

    /// In a frame, widened; what is empty stays so.
    pub fn within(&self, frame: &Frame) -> Self {
        let ([x, y, z, _], [far_x, far_y, far_z, _]) = (self.low, self.high);
        if x > far_x {
            return Self::EMPTY;
        }
        let [[x, y, z], [far_x, far_y, far_z]] = frame.widen([x, y, z], [far_x, far_y, far_z]);
        Self { low: [x, y, z, 0.0], high: [far_x, far_y, far_z, 0.0] }
    }

    /// Are all six coordinates finite, and is it not empty?
    pub fn is_finite(&self) -> bool {
        (0..3)
            .all(|axis| self.low[axis].is_finite() && self.high[axis].is_finite() && self.low[axis] <= self.high[axis])
    }

    /// The greatest absolute coordinate; 0 when empty.
    pub fn scale(&self) -> f32 {
        let sizes = self.low[..3].iter().chain(&self.high[..3]);
        sizes.map(|x| x.abs()).filter(|x| x.is_finite()).fold(0.0, f32::max)
    }
}
