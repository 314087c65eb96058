//! One registration a kernel.

/// Registers kernels: makes a slice of [`Entry`](crate::lab::Entry).
///
/// ```
/// use mobula_core::lab;
/// use mobula_core::lab::leaves::{COMMON_ORIGIN, Leaves, STREAM};
/// use mobula_core::leaf::TriangleBlock;
///
/// mobula_core::kernels! {
///     /// What my crate tunes.
///     pub static MINE;
///     triangle { stream: Leaves<TriangleBlock, STREAM>, common_origin: Leaves<TriangleBlock, COMMON_ORIGIN> }
/// }
/// # fn main() {
/// let token = mobula_core::simd::AnyToken::detect();
/// MINE[1].check(token, 64, &mut lab::Dice::from_seed(1)).unwrap();
/// # }
/// ```
#[macro_export]
macro_rules! kernels {
    ($(#[$meta:meta])* $vis:vis static $name:ident; $($kernel:ident { $($(#[$cfg:meta])* $case:ident: $type:ty),+ $(,)? })+) => {
        $(#[$meta])*
        $vis static $name: &[$crate::lab::Entry] = &[
            $($($(#[$cfg])* $crate::lab::Entry::of::<$type>(stringify!($kernel), stringify!($case)),)+)+
        ];
    };
}
