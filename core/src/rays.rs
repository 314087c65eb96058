//! The rays of a packet: origins, directions, intervals, and what is derived from them alone (paper 5.1).

use core::ops::Range;

use glam::Vec3;
use mobula_simd::{F32Lanes, I32Lanes, MaskLanes, Token};

use crate::vector::load3;
use crate::{Column, Columns3, Properties};

/// 2^-40 and 2^-126: see [`Rays::inverse_directions`].
const LEAST_SHARE: f32 = 1.0 / (1u64 << 40) as f32;
const LEAST_DIRECTION: f32 = 1.0 / (1u128 << 126) as f32;
/// Shorter directions count as zero: a lesser axis that is taken for 2^-126 would lead further astray than 2^-24 of the way,
/// which is more than traversal widens boxes by.
const SHORTEST: f32 = 1.0 / (1u128 << 102) as f32;

/// The axes in order when the last is dominant.
pub(crate) const AXES: [[usize; 3]; 3] = [[1, 2, 0], [2, 0, 1], [0, 1, 2]];

/// Up to `N` rays as a structure of arrays. A ray is the half-open interval `(t_min, t_max]` of `origin + t * direction`;
/// traversal lowers `t_max` to what it finds. Rays outside [`range`](Self::range) are neither read nor written.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub struct Rays<const N: usize> {
    origin: Columns3<N>,
    direction: Columns3<N>,
    t_min: Column<f32, N>,
    /// Far end of the interval; closest-hit traversal leaves the hit's distance here, any-hit traversal `-inf`.
    pub t_max: Column<f32, N>,
    time: Column<f32, N>,
    inverse: Columns3<N>,
    shear: Columns3<N>,
    axis: Column<u32, N>,
    begin: usize,
    end: usize,
    properties: Properties,
}

impl<const N: usize> Default for Rays<N> {
    fn default() -> Self {
        const { assert!(N >= 1 && N <= 1024, "packet width must be 1..=1024") };
        let zero = Column::splat(0.0);
        Self {
            origin: [zero; 3],
            direction: [zero; 3],
            t_min: zero,
            t_max: zero,
            time: zero,
            inverse: [zero; 3],
            shear: [zero; 3],
            axis: Column::splat(0),
            begin: 0,
            end: 0,
            properties: Properties::empty(),
        }
    }
}

impl<const N: usize> Rays<N> {
    /// Makes `range` (within `0..N`) the active rays, with interval `(0, inf]` and time 0, and clears all properties but
    /// `keep`. Origins and directions keep their old values: set them.
    ///
    /// # Panics
    /// If the range is not within `0..N`.
    pub fn reset(&mut self, range: Range<usize>, keep: Properties) {
        assert!(range.start <= range.end && range.end <= N, "rays {range:?} of a packet of {N}");
        (self.begin, self.end) = (range.start, range.end);
        self.properties = keep;
        self.t_min[range.clone()].fill(0.0);
        self.t_max[range.clone()].fill(f32::INFINITY);
        self.time[range].fill(0.0);
    }

    /// The active rays.
    #[inline(always)]
    pub fn range(&self) -> Range<usize> {
        self.begin..self.end
    }

    /// Narrows or widens the active rays without touching them. Of rays that were not active nothing is known, so widening
    /// clears every property that they could make false.
    ///
    /// # Panics
    /// If the range is not within `0..N`.
    pub fn set_range(&mut self, range: Range<usize>) {
        assert!(range.start <= range.end && range.end <= N, "rays {range:?} of a packet of {N}");
        if range.start < self.begin || range.end > self.end {
            self.properties -= Properties::OF_ORIGIN | Properties::OF_DIRECTION;
        }
        (self.begin, self.end) = (range.start, range.end);
    }

    /// What is known of all rays.
    #[inline(always)]
    pub fn properties(&self) -> Properties {
        self.properties
    }

    /// States that `properties` are true of all active rays. The caller promises it; debug builds check.
    pub fn promise(&mut self, properties: Properties) {
        self.properties |= properties;
        self.check();
    }

    /// Takes `properties` back, so that general paths are taken. Always allowed.
    pub fn forget(&mut self, properties: Properties) {
        self.properties -= properties;
    }

    /// Origin and direction of ray `i`: the horizontal view (paper 5.1.1).
    #[inline(always)]
    pub fn ray(&self, i: usize) -> (Vec3, Vec3) {
        (vec3(&self.origin, i), vec3(&self.direction, i))
    }

    /// Sets ray `i` and clears every property that this could make false.
    pub fn set_ray(&mut self, i: usize, origin: Vec3, direction: Vec3) {
        self.properties -= Properties::OF_ORIGIN | Properties::OF_DIRECTION;
        set_vec3(&mut self.origin, i, origin);
        set_vec3(&mut self.direction, i, direction);
    }

    /// Sets the interval `(t_min, t_max]` of ray `i`.
    pub fn set_interval(&mut self, i: usize, t_min: f32, t_max: f32) {
        self.t_min[i] = t_min;
        self.t_max[i] = t_max;
    }

    /// Origins, one column an axis.
    #[inline(always)]
    pub fn origins(&self) -> &Columns3<N> {
        &self.origin
    }

    /// Origins to write; clears what that could make false.
    pub fn origins_mut(&mut self) -> &mut Columns3<N> {
        self.properties -= Properties::OF_ORIGIN;
        &mut self.origin
    }

    /// Gives every active ray the same origin, and says so.
    pub fn set_common_origin(&mut self, origin: Vec3) {
        self.properties -= Properties::OF_ORIGIN;
        let range = self.range();
        for (column, value) in self.origin.iter_mut().zip(origin.to_array()) {
            column[range.clone()].fill(value);
        }
        self.properties |= Properties::COMMON_ORIGIN;
    }

    /// Directions, one column an axis.
    #[inline(always)]
    pub fn directions(&self) -> &Columns3<N> {
        &self.direction
    }

    /// Directions to write; clears what that could make false.
    pub fn directions_mut(&mut self) -> &mut Columns3<N> {
        self.properties -= Properties::OF_DIRECTION;
        &mut self.direction
    }

    /// Near ends of the intervals.
    #[inline(always)]
    pub fn t_min(&self) -> &Column<f32, N> {
        &self.t_min
    }

    /// Near ends of the intervals, to write.
    pub fn t_min_mut(&mut self) -> &mut Column<f32, N> {
        &mut self.t_min
    }

    /// Time of each ray (for time-varying scenes; 0 unless set).
    pub fn times(&self) -> &Column<f32, N> {
        &self.time
    }

    /// Time of each ray, to write.
    pub fn times_mut(&mut self) -> &mut Column<f32, N> {
        &mut self.time
    }

    /// Scales every active direction to length 1 (correctly rounded operations: the same at every level) and says so,
    /// unless the square of a length underflows or overflows (lengths outside of about 1e-16 to 1e19, zero, NaN).
    #[inline(always)]
    pub fn normalize<T: Token>(&mut self, token: T) {
        self.properties -= Properties::OF_DIRECTION;
        let (least, greatest) = (token.splat(1e-32), token.splat(f32::INFINITY));
        let mut sound = true;
        let mut at = 0;
        while at < N {
            let active = self.active(token, at);
            let d = load3(token, &self.direction, at);
            let square = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
            sound &= !active.and_not(square.gt(least) & square.lt(greatest)).any();
            let scale = token.splat(1.0) / square.sqrt();
            for (column, d) in self.direction.iter_mut().zip(d) {
                (d * scale).store_masked(&mut column[..], at, active);
            }
            at += T::LANES;
        }
        self.properties.set(Properties::NORMALIZED_DIRECTIONS, sound);
    }

    /// `1 / direction`, computed when first asked for, together with the sign properties. Sizes below 2^-40 of the ray's
    /// greatest (a ray that crosses the scene strays by less than rounding) or below 2^-126 count as that, so that every
    /// reciprocal is finite (a slab test without NaN); the sign is kept, that of a zero too.
    #[inline(always)]
    pub fn inverse_directions<T: Token>(&mut self, token: T) -> &Columns3<N> {
        if !self.properties.contains(Properties::HAVE_INVERSE_DIRECTIONS) {
            let one = token.splat(1.0);
            let mut negative = [false; 3];
            let mut positive = [false; 3];
            let mut at = 0;
            while at < N {
                let active = self.active(token, at);
                let directions = load3(token, &self.direction, at);
                let greatest = directions[0].abs().max(directions[1].abs()).max(directions[2].abs());
                let least = (greatest * token.splat(LEAST_SHARE)).max(token.splat(LEAST_DIRECTION));
                for (axis, d) in directions.into_iter().enumerate() {
                    let size = one / d.abs().max(least);
                    let minus = I32Lanes::lt(d.to_bits(), token.splat_i32(0));
                    let inverse = (-size).select(minus, size);
                    inverse.store_masked(&mut self.inverse[axis][..], at, active);
                    negative[axis] |= (active & minus).any();
                    positive[axis] |= active.and_not(minus).any();
                }
                at += T::LANES;
            }
            self.properties |= Properties::HAVE_INVERSE_DIRECTIONS;
            if (0..3).all(|axis| !(negative[axis] && positive[axis])) {
                self.properties |= Properties::CONSTANT_SIGNS;
            }
        }
        &self.inverse
    }

    /// Shear factors `d[x] / d[z]`, `d[y] / d[z]` and `1 / d[z]` along each ray's dominant axis z, and that axis (Woop, Benthin and
    /// Wald, "Watertight Ray/Triangle Intersection", JCGT 2013), computed when first asked for. On equal sizes the
    /// lower axis is dominant. A direction shorter than 2^-102 counts as zero: its shears are NaN, and it hits nothing; so is
    /// one that is infinite.
    #[inline(always)]
    pub fn shears<T: Token>(&mut self, token: T) -> (&Columns3<N>, &Column<u32, N>) {
        if !self.properties.contains(Properties::HAVE_SHEARS) {
            let mut at = 0;
            while at < N {
                let active = self.active(token, at);
                let d = load3(token, &self.direction, at);
                let size = [d[0].abs(), d[1].abs(), d[2].abs()];
                let on_z = size[2].gt(size[0]) & size[2].gt(size[1]);
                let on_y = size[1].gt(size[0]) & !on_z;
                let [x, y, z] = last_axis::<T>(d, on_y, on_z);
                // So short that its lesser axes may count as longer than they are: as if zero, so that no test finds what no box
                // lets through.
                // An infinite one would be everywhere at once.
                let sound = z.abs().ge(token.splat(SHORTEST)) & z.abs().lt(token.splat(f32::INFINITY));
                let scale = (token.splat(1.0) / z).select(sound, token.splat(f32::NAN));
                (x * scale).store_masked(&mut self.shear[0][..], at, active);
                (y * scale).store_masked(&mut self.shear[1][..], at, active);
                scale.store_masked(&mut self.shear[2][..], at, active);
                let axis = token.splat_i32(2);
                let axis = I32Lanes::select(axis, on_z, token.splat_i32(0));
                let axis = I32Lanes::select(token.splat_i32(1), on_y, axis);
                I32Lanes::store_masked(axis, &mut self.axis[..], at, active);
                at += T::LANES;
            }
            self.properties |= Properties::HAVE_SHEARS;
        }
        (&self.shear, &self.axis)
    }

    /// The shear factors as they are: derived by [`shears`](Self::shears).
    #[inline(always)]
    pub fn shear_columns(&self) -> &Columns3<N> {
        &self.shear
    }

    /// The reciprocal directions as they are: derived by [`inverse_directions`](Self::inverse_directions).
    #[inline(always)]
    pub fn inverse_columns(&self) -> &Columns3<N> {
        &self.inverse
    }

    /// The dominant axes as they are: derived by [`shears`](Self::shears).
    #[inline(always)]
    pub fn axes(&self) -> &Column<u32, N> {
        &self.axis
    }

    /// Signs of all directions (bit k: axis k is negative), where they are known to be the same.
    #[inline(always)]
    pub(crate) fn octant(&self) -> Option<u8> {
        let first = self.begin;
        let mut octant = 0;
        for axis in 0..3 {
            // The bit, not `< 0`: the reciprocal of minus infinity is minus zero.
            octant |= u8::from(self.inverse[axis][first].is_sign_negative()) << axis;
        }
        self.properties.contains(Properties::CONSTANT_SIGNS).then_some(octant)
    }

    /// The lanes of the vector at `at` that belong to active rays.
    #[inline(always)]
    pub fn active<T: Token>(&self, token: T, at: usize) -> T::Mask {
        // Most packets are full.
        if self.begin <= at && at + T::LANES <= self.end {
            return token.mask(u32::MAX);
        }
        let (end, begin) = (self.end.saturating_sub(at), self.begin.saturating_sub(at));
        token.first(end).and_not(token.first(begin))
    }

    /// In debug builds, panics if a property of the rays is set but false.
    pub fn check(&self) {
        if cfg!(debug_assertions) && !self.range().is_empty() {
            let first = self.begin;
            let p = self.properties;
            for i in self.range() {
                let (o, d) = self.ray(i);
                let (o0, d0) = self.ray(first);
                let same_sign =
                    |a: f32, b: f32| a.is_nan() || b.is_nan() || a.is_sign_negative() == b.is_sign_negative();
                if p.contains(Properties::COMMON_ORIGIN) {
                    assert!(
                        o.to_array().map(f32::to_bits) == o0.to_array().map(f32::to_bits),
                        "ray {i}: COMMON_ORIGIN is set but false"
                    );
                }
                if p.contains(Properties::NORMALIZED_DIRECTIONS) && d.is_finite() {
                    assert!((d.length_squared() - 1.0).abs() < 2e-5, "ray {i}: NORMALIZED_DIRECTIONS is set but false");
                }
                if p.contains(Properties::CONSTANT_SIGNS) {
                    assert!((0..3).all(|k| same_sign(d[k], d0[k])), "ray {i}: CONSTANT_SIGNS is set but false");
                }
                if p.contains(Properties::HAVE_INVERSE_DIRECTIONS) && d.is_finite() {
                    let least = (d.abs().max_element() * LEAST_SHARE).max(LEAST_DIRECTION);
                    let is_there = |k: usize| self.inverse[k][i].abs() == 1.0 / d[k].abs().max(least);
                    assert!((0..3).all(is_there), "ray {i}: HAVE_INVERSE_DIRECTIONS is set but false");
                }
                if p.contains(Properties::HAVE_SHEARS) {
                    assert!(
                        self.axis[i] as usize == dominant_axis(d),
                        "ray {i}: HAVE_SHEARS is set but false: the dominant axis"
                    );
                }
            }
        }
    }
}

/// The axis of the greatest size; the first of equal ones, as [`Rays::shears`] has it.
fn dominant_axis(d: Vec3) -> usize {
    let size = d.abs();
    if size.z > size.x && size.z > size.y { 2 } else { usize::from(size.y > size.x) }
}

/// Row `i` of three columns.
#[inline(always)]
pub fn vec3<const N: usize>(columns: &Columns3<N>, i: usize) -> Vec3 {
    Vec3::new(columns[0][i], columns[1][i], columns[2][i])
}

/// Writes row `i` of three columns.
#[inline(always)]
pub fn set_vec3<const N: usize>(columns: &mut Columns3<N>, i: usize, v: Vec3) {
    for (column, value) in columns.iter_mut().zip(v.to_array()) {
        column[i] = value;
    }
}

/// Rotates each lane's axes so that its dominant one comes last.
#[inline(always)]
pub(crate) fn last_axis<T: Token>([x, y, z]: [T::F32; 3], on_y: T::Mask, on_z: T::Mask) -> [T::F32; 3] {
    [x.select(on_z, z.select(on_y, y)), y.select(on_z, x.select(on_y, z)), z.select(on_z, y.select(on_y, x))]
}
