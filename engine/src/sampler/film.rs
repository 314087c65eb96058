//! The sums of a picture's samples, kept from frame to frame.

use std::sync::atomic::{AtomicU32, Ordering};

use glam::Vec3;

use super::Filter;
use crate::image::{Size, SizeError};

/// The samples of a pixel so far.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sum {
    weighted: Vec3,
    plain: Vec3,
    weight: f32,
    count: f32,
}

impl Sum {
    pub(super) fn add(&mut self, color: Vec3, weight: f32) {
        self.weighted += color * weight;
        self.plain += color;
        self.weight += weight;
        self.count += 1.0;
    }

    /// The sum of all samples, each of which counts the same.
    pub(super) fn plain(&self) -> Vec3 {
        self.plain
    }

    /// Of a few samples nearly as many may be where a filter is negative as elsewhere: then all count the same.
    pub(super) fn mean(&self) -> Vec3 {
        if self.weight > 0.5 * self.count { self.weighted / self.weight } else { self.plain / self.count }
    }
}

/// For each pixel of a picture the sum of its samples, linear, to which later frames add theirs. Each pixel belongs to one thread a frame,
/// and its samples are added in the order of their numbers: after `n` of them the mean is, bit for bit, that of `n` samples in one frame.
///
/// Sums are relaxed atomics for the reason that pixels of a [`FrameBuffer`](crate::image::FrameBuffer) are; the barrier orders frames.
#[derive(Debug)]
pub struct Film {
    size: Size,
    filter: Filter,
    /// Numbers a pixel: where all samples count the same, the sum of the colours; else also that of the weighted ones, and of the weights.
    stride: usize,
    sums: Box<[AtomicU32]>,
}

impl Film {
    /// For pictures of a size whose samples are spread by a filter. Errors where there is no memory for it.
    pub fn new(size: Size, filter: Filter) -> Result<Self, SizeError> {
        let stride = if filter.is_ever_negative() { 7 } else { 3 };
        let count = size.pixels() * stride;
        let mut sums = Vec::new();
        let reserved = sums.try_reserve_exact(count);
        reserved.map_err(|_| SizeError::NoMemory { width: size.width(), height: size.height() })?;
        sums.extend((0..count).map(|_| AtomicU32::new(0)));
        Ok(Self { size, filter, stride, sums: sums.into_boxed_slice() })
    }

    /// The size of the picture.
    pub const fn size(&self) -> Size {
        self.size
    }

    /// The filter.
    pub const fn filter(&self) -> Filter {
        self.filter
    }

    /// The sum of the first `count` samples of a pixel, which are all that it has. Before the first there is nothing to read: a film need
    /// not be cleared.
    pub(super) fn sum(&self, pixel: [u32; 2], count: u32) -> Sum {
        if count == 0 {
            return Sum::default();
        }
        let sums = self.of(pixel);
        let number = |i: usize| f32::from_bits(sums[i].load(Ordering::Relaxed));
        let three = |i: usize| Vec3::new(number(i), number(i + 1), number(i + 2));
        let count = count as f32;
        match self.stride {
            3 => Sum { weighted: three(0), plain: three(0), weight: count, count },
            _ => Sum { weighted: three(3), plain: three(0), weight: number(6), count },
        }
    }

    /// Keeps the sum of a pixel.
    pub(super) fn keep(&self, pixel: [u32; 2], sum: &Sum) {
        let Sum { weighted, plain, weight, .. } = sum;
        let all = [plain.x, plain.y, plain.z, weighted.x, weighted.y, weighted.z, *weight];
        for (to, from) in self.of(pixel).iter().zip(all) {
            to.store(from.to_bits(), Ordering::Relaxed);
        }
    }

    fn of(&self, [x, y]: [u32; 2]) -> &[AtomicU32] {
        &self.sums[(y as usize * self.size.width() + x as usize) * self.stride..][..self.stride]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_of_a_pixel_give_a_mean() {
        let mut sum = Sum::default();
        sum.add(Vec3::X, 1.0);
        assert_eq!(sum.mean(), Vec3::X);
        sum.add(Vec3::Y, -1.0);
        assert_eq!(sum.mean(), Vec3::new(0.5, 0.5, 0.0), "of weights without a sum");
        (0..3).for_each(|_| sum.add(Vec3::X, 1.0));
        assert_eq!(sum.mean(), Vec3::new(4.0, -1.0, 0.0) / 3.0);
    }

    #[test]
    fn sums_are_kept_pixel_by_pixel() {
        for filter in [Filter::Box, Filter::Gaussian, Filter::Mitchell] {
            let film = Film::new(Size::new(3, 2).unwrap(), filter).unwrap();
            let weights = if filter == Filter::Mitchell { [1.0, -1.0, 1.0] } else { [1.0; 3] };
            let mut expected = Sum::default();
            for (count, weight) in (0..).zip(weights) {
                let mut sum = film.sum([2, 1], count);
                for sum in [&mut sum, &mut expected] {
                    sum.add(Vec3::new(1.0, 0.1, count as f32), weight);
                }
                film.keep([2, 1], &sum);
                film.keep([1, 1], &Sum::default());
                assert_eq!(film.sum([2, 1], count + 1).mean(), expected.mean(), "{filter}");
            }
        }
    }
}
