//! Types of samples.

/// A type of samples. All arithmetic is done in `f32`; what it cannot hold is rounded, in the same order.
pub trait Voxel: Copy + PartialOrd + Send + Sync + 'static {
    /// The nearest float.
    fn to_f32(self) -> f32;
}

macro_rules! voxel {
    ($($type:ty)+) => {
        $(impl Voxel for $type {
            #[inline(always)]
            fn to_f32(self) -> f32 {
                self as f32
            }
        })+
    };
}
voxel!(u8 i8 u16 i16 u32 i32 f32 f64);
