//! One value of every ray of a packet, contiguous and 64-byte aligned: a row of the structure of arrays (paper 5.1.1).

use std::marker::PhantomData;
use std::ops::{Deref, DerefMut, Range};

use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// What an allocation is made of.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, align(64))]
struct Line([u32; 16]);

/// So many values, rounded up to whole cache lines; all are zero at first. Vector code may read and write beyond the packet's
/// width, up to the end.
#[derive(Clone, Debug)]
pub struct Column<T> {
    lines: Vec<Line>,
    values: PhantomData<T>,
}

/// Three columns: x, y and z of a vector of every ray, or the channels of a colour.
pub type Columns3 = [Column<f32>; 3];

impl<T: Pod> Column<T> {
    /// A column of zeros for packets of this width.
    pub fn new(width: usize) -> Self {
        let lines = (width * size_of::<T>()).div_ceil(size_of::<Line>()).max(1);
        Self { lines: vec![Line::zeroed(); lines], values: PhantomData }
    }
}

impl<T: Pod> Deref for Column<T> {
    type Target = [T];
    #[inline(always)]
    fn deref(&self) -> &[T] {
        bytemuck::cast_slice(&self.lines)
    }
}

impl<T: Pod> DerefMut for Column<T> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [T] {
        bytemuck::cast_slice_mut(&mut self.lines)
    }
}

impl<T: Pod> AsRef<[T]> for Column<T> {
    #[inline(always)]
    fn as_ref(&self) -> &[T] {
        self
    }
}

impl<T: Pod> AsMut<[T]> for Column<T> {
    #[inline(always)]
    fn as_mut(&mut self) -> &mut [T] {
        self
    }
}

/// Three columns of zeros for packets of this width.
pub fn columns3(width: usize) -> Columns3 {
    [Column::new(width), Column::new(width), Column::new(width)]
}

/// The rows `range` of three columns.
#[inline(always)]
pub fn part<C: AsRef<[f32]>>(columns: &[C; 3], range: Range<usize>) -> [&[f32]; 3] {
    let [x, y, z] = columns;
    [&x.as_ref()[range.clone()], &y.as_ref()[range.clone()], &z.as_ref()[range]]
}

/// The rows `range` of three slices.
#[inline(always)]
pub(super) fn rows([x, y, z]: [&[f32]; 3], range: Range<usize>) -> [&[f32]; 3] {
    [&x[range.clone()], &y[range.clone()], &z[range]]
}

/// The rows `range` of three columns, to write.
#[inline(always)]
pub fn part_mut<C: AsMut<[f32]>>(columns: &mut [C; 3], range: Range<usize>) -> [&mut [f32]; 3] {
    let [x, y, z] = columns;
    [&mut x.as_mut()[range.clone()], &mut y.as_mut()[range.clone()], &mut z.as_mut()[range]]
}

/// Row `i` of three columns.
#[inline(always)]
pub fn vec3<C: AsRef<[f32]>>(columns: &[C; 3], i: usize) -> Vec3 {
    let [x, y, z] = columns;
    Vec3::new(x.as_ref()[i], y.as_ref()[i], z.as_ref()[i])
}

/// Writes row `i` of three columns.
#[inline(always)]
pub fn set_vec3<C: AsMut<[f32]>>(columns: &mut [C; 3], i: usize, v: Vec3) {
    for (column, value) in columns.iter_mut().zip(v.to_array()) {
        column.as_mut()[i] = value;
    }
}

/// Adds to row `i` of three columns.
#[inline(always)]
pub fn add_vec3<C: AsMut<[f32]>>(columns: &mut [C; 3], i: usize, v: Vec3) {
    for (column, value) in columns.iter_mut().zip(v.to_array()) {
        column.as_mut()[i] += value;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_aligned_and_as_long_as_their_packets() {
        for width in [1, 8, 16, 17, 256] {
            let mut column = Column::<f32>::new(width);
            assert!(column.len() >= width && column.len().is_multiple_of(16));
            assert_eq!(column.as_ptr() as usize % 64, 0);
            column[width - 1] = 1.0;
            assert_eq!(column.iter().sum::<f32>(), 1.0);
            assert!(Column::<u16>::new(width).len() >= width);
        }
    }

    #[test]
    fn rows_are_written_and_read() {
        let mut columns = columns3(4);
        set_vec3(&mut columns, 2, Vec3::new(1.0, 2.0, 3.0));
        add_vec3(&mut columns, 2, Vec3::ONE);
        assert_eq!(vec3(&part(&columns, 1..4), 1), Vec3::new(2.0, 3.0, 4.0));
        set_vec3(&mut part_mut(&mut columns, 3..4), 0, Vec3::X);
        assert_eq!(vec3(&columns, 3), Vec3::X);
    }
}
