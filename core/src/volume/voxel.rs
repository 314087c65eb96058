//! Types of samples.

/// A type of samples. All arithmetic is done in `f32`; what it cannot hold is rounded, in the same order.
pub trait Voxel: Copy + PartialOrd + core::fmt::Debug + Send + Sync + 'static {
    /// Are all values finite?
    const FINITE: bool;

    /// The nearest float.
    fn to_f32(self) -> f32;
}

macro_rules! voxel {
    ($finite:literal $($type:ty)+) => {
        $(impl Voxel for $type {
            const FINITE: bool = $finite;

            #[inline(always)]
            fn to_f32(self) -> f32 {
                self as f32
            }
        })+
    };
}
voxel!(true u8 i8 u16 i16 u32 i32);
voxel!(false f32 f64);
