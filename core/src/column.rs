//! One value of every ray of a packet, contiguous and 64-byte aligned: a row of the structure of arrays (paper 5.1.1).

use core::ops::{Deref, DerefMut};

/// `[T; N]`, aligned for any vector load.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub struct Column<T, const N: usize>(pub [T; N]);

impl<T: Copy, const N: usize> Column<T, N> {
    /// Every ray has the same value.
    #[inline(always)]
    pub const fn splat(value: T) -> Self {
        Self([value; N])
    }
}

impl<T: Copy + Default, const N: usize> Default for Column<T, N> {
    fn default() -> Self {
        Self::splat(T::default())
    }
}

impl<T, const N: usize> Deref for Column<T, N> {
    type Target = [T; N];
    #[inline(always)]
    fn deref(&self) -> &[T; N] {
        &self.0
    }
}

impl<T, const N: usize> DerefMut for Column<T, N> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [T; N] {
        &mut self.0
    }
}

impl<T, const N: usize> AsMut<[T]> for Column<T, N> {
    #[inline(always)]
    fn as_mut(&mut self) -> &mut [T] {
        &mut self.0
    }
}

impl<T, const N: usize> AsRef<[T]> for Column<T, N> {
    #[inline(always)]
    fn as_ref(&self) -> &[T] {
        &self.0
    }
}

/// Three columns: x, y and z of a vector of every ray.
pub type Columns3<const N: usize> = [Column<f32, N>; 3];
