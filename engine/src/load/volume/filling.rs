//! Grids that are filled as their bytes or numbers come: memory follows what was read.

use std::ops::Range;
use std::sync::Arc;

use bytemuck::Pod;
use memmap2::Mmap;

use super::VoxelType;
use super::layout::Layout;
use crate::volume::{Samples, Voxels};

/// Why voxels cannot be stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub(super) enum Refused {
    /// There is no memory.
    #[error("there is no memory for so many voxels")]
    Memory,
    /// A number that the type of the voxels has not.
    #[error("this is no value of type {0}")]
    Value(VoxelType),
}

/// Voxels of some type that come in the order of a file.
pub(super) trait Filling {
    /// Takes the memory for all voxels at once: for those who know that they are there.
    fn reserve(&mut self) -> Result<(), Refused>;

    /// Takes voxels that are in a file as they are on this machine, all of them. Says whether it does: only of a grid of one step.
    fn map(&mut self, map: &Arc<Mmap>, bytes: Range<usize>) -> bool;

    /// Adds the voxels that these bytes are, a whole number of them. What is more than there are voxels is left out.
    fn add_bytes(&mut self, bytes: &[u8], big_endian: bool) -> Result<(), Refused>;

    /// Adds the voxel that stands for a number.
    fn add_number(&mut self, number: f64) -> Result<(), Refused>;

    /// The voxels of each step.
    fn finish(self: Box<Self>) -> Vec<Voxels>;
}

/// What is to be filled with voxels of a type.
pub(super) fn filling(kind: VoxelType, layout: &Layout) -> Box<dyn Filling> {
    match kind {
        VoxelType::U8 => Steps::<u8>::boxed(layout),
        VoxelType::I8 => Steps::<i8>::boxed(layout),
        VoxelType::U16 => Steps::<u16>::boxed(layout),
        VoxelType::I16 => Steps::<i16>::boxed(layout),
        VoxelType::U32 => Steps::<u32>::boxed(layout),
        VoxelType::I32 => Steps::<i32>::boxed(layout),
        VoxelType::F32 => Steps::<f32>::boxed(layout),
        VoxelType::F64 => Steps::<f64>::boxed(layout),
    }
}

/// A type that voxels have.
trait Voxel: Pod {
    const TYPE: VoxelType;

    /// Appends the voxels that these bytes are.
    fn decode(bytes: &[u8], big_endian: bool, to: &mut Vec<Self>);

    /// The voxel that is this number.
    fn exactly(number: f64) -> Option<Self>;

    fn erase(values: Samples<Self>) -> Voxels;
}

macro_rules! voxel {
    ($($type:ident $variant:ident $exactly:expr,)+) => {
        $(impl Voxel for $type {
            const TYPE: VoxelType = VoxelType::$variant;

            fn decode(bytes: &[u8], big_endian: bool, to: &mut Vec<Self>) {
                let values = bytes.as_chunks().0;
                if big_endian {
                    to.extend(values.iter().map(|&bytes| Self::from_be_bytes(bytes)));
                } else {
                    to.extend(values.iter().map(|&bytes| Self::from_le_bytes(bytes)));
                }
            }

            fn exactly(number: f64) -> Option<Self> {
                $exactly(number).then_some(number as Self)
            }

            fn erase(values: Samples<Self>) -> Voxels {
                values.into()
            }
        })+
    };
}

/// Is it a whole number of a range?
fn whole(number: f64, low: f64, high: f64) -> bool {
    number.trunc() == number && (low..=high).contains(&number)
}

voxel! {
    u8 U8 |x| whole(x, 0.0, 255.0),
    i8 I8 |x| whole(x, -128.0, 127.0),
    u16 U16 |x| whole(x, 0.0, 65_535.0),
    i16 I16 |x| whole(x, -32_768.0, 32_767.0),
    u32 U32 |x| whole(x, 0.0, u32::MAX.into()),
    i32 I32 |x| whole(x, i32::MIN.into(), i32::MAX.into()),
    f32 F32 |_| true,
    f64 F64 |_| true,
}

/// The steps of time, each as far as it is read.
struct Steps<V> {
    steps: Vec<Vec<V>>,
    per_step: usize,
    together: usize,
    /// Whose turn it is.
    step: usize,
    /// How many voxels it gets until the next step has its turn.
    turn: usize,
    /// All of them, if they are in a file.
    mapped: Option<Samples<V>>,
}

impl<V: Voxel> Steps<V> {
    fn boxed(layout: &Layout) -> Box<dyn Filling> {
        let steps = std::iter::repeat_with(Vec::new).take(layout.steps).collect();
        let (per_step, together) = (layout.per_step(), layout.together);
        Box::new(Self { steps, per_step, together, step: 0, turn: together, mapped: None })
    }

    /// The step whose turn it is, with room for as many of `count` voxels as it gets now, and how many these are.
    fn next(&mut self, count: usize) -> Result<(&mut Vec<V>, usize), Refused> {
        if self.turn == 0 {
            self.step = (self.step + 1) % self.steps.len();
            self.turn = self.together;
        }
        let values = &mut self.steps[self.step];
        let count = count.min(self.turn).min(self.per_step - values.len());
        self.turn -= count;
        if values.capacity() - values.len() < count {
            // Twice as much, so that few values are moved, but never more than there will be.
            let wanted = (values.len() + count).max(2 * values.len()).min(self.per_step);
            values.try_reserve_exact(wanted - values.len()).map_err(|_| Refused::Memory)?;
        }
        Ok((values, count))
    }
}

impl<V: Voxel> Filling for Steps<V> {
    fn reserve(&mut self) -> Result<(), Refused> {
        let per_step = self.per_step;
        let mut reserve = |step: &mut Vec<V>| step.try_reserve_exact(per_step - step.len());
        self.steps.iter_mut().try_for_each(&mut reserve).map_err(|_| Refused::Memory)
    }

    fn map(&mut self, map: &Arc<Mmap>, bytes: Range<usize>) -> bool {
        let whole = self.steps.len() == 1 && bytes.len() == self.per_step * size_of::<V>();
        self.mapped = if whole { Samples::mapped(Arc::clone(map), bytes) } else { None };
        self.mapped.is_some()
    }

    fn add_bytes(&mut self, mut bytes: &[u8], big_endian: bool) -> Result<(), Refused> {
        let each = size_of::<V>();
        while bytes.len() >= each {
            let (values, count) = self.next(bytes.len() / each)?;
            if count == 0 {
                break;
            }
            let (now, later) = bytes.split_at(count * each);
            V::decode(now, big_endian, values);
            bytes = later;
        }
        Ok(())
    }

    fn add_number(&mut self, number: f64) -> Result<(), Refused> {
        let value = V::exactly(number).ok_or(Refused::Value(V::TYPE))?;
        let (values, count) = self.next(1)?;
        if count == 1 {
            values.push(value);
        }
        Ok(())
    }

    fn finish(self: Box<Self>) -> Vec<Voxels> {
        match self.mapped {
            Some(mapped) => vec![V::erase(mapped)],
            None => self.steps.into_iter().map(|step| V::erase(step.into())).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_have_their_turns() {
        for (time_after, expected) in [
            (0, [[0, 2, 4, 6, 8, 10], [1, 3, 5, 7, 9, 11]]),
            (1, [[0, 1, 4, 5, 8, 9], [2, 3, 6, 7, 10, 11]]),
            (3, [[0, 1, 2, 3, 4, 5], [6, 7, 8, 9, 10, 11]]),
        ] {
            let layout = Layout::new([2, 3, 1], 2, time_after).unwrap();
            let mut filling = filling(VoxelType::U16, &layout);
            let bytes: Vec<u8> = (0..12_u16).flat_map(u16::to_be_bytes).collect();
            // In pieces that fit nothing, and one voxel too many.
            for piece in bytes.chunks(10).chain([&[9, 9][..]]) {
                filling.add_bytes(piece, true).unwrap();
            }
            let steps = filling.finish();
            assert_eq!(steps.len(), 2);
            for (step, expected) in steps.iter().zip(expected) {
                let values: Vec<_> = (0..step.len()).map(|i| step.get(i)).collect();
                assert_eq!(values, expected.map(f64::from));
            }
        }
    }

    #[test]
    fn numbers_must_be_of_the_type() {
        let layout = Layout::new([3, 1, 1], 1, 3).unwrap();
        for (kind, good, bad) in [
            (VoxelType::U8, [0.0, 255.0], &[-1.0, 256.0, 0.5, f64::NAN][..]),
            (VoxelType::I16, [-32_768.0, 32_767.0], &[32_768.0, f64::INFINITY]),
            (VoxelType::U32, [0.0, 4_294_967_295.0], &[4_294_967_296.0, -1.0]),
            (VoxelType::F32, [0.5, f64::NEG_INFINITY], &[]),
        ] {
            let mut filling = filling(kind, &layout);
            good.iter().for_each(|&x| filling.add_number(x).unwrap());
            bad.iter().for_each(|&x| assert_eq!(filling.add_number(x), Err(Refused::Value(kind)), "{x}"));
            let [step] = &filling.finish()[..] else { panic!() };
            assert_eq!([step.get(0), step.get(1)], good);
            assert_eq!((step.len(), step.type_name()), (2, kind.name()));
        }
    }
}
