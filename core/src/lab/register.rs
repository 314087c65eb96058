//! One registration a kernel.

/// Registers kernels: makes a slice of [`Entry`](crate::lab::Entry), and a module `probe` with one function per special
/// case and level at packet width 64, which `cargo asm` finds by name:
/// `probe::triangle::common_origin::avx512_64`.
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
    ($(#[$meta:meta])* $vis:vis static $name:ident; $($(#[$cfg:meta])* $kernel:ident { $($case:ident: $type:ty),+ $(,)? })+) => {
        $(#[$meta])*
        $vis static $name: &[$crate::lab::Entry] = &[
            $($($crate::lab::Entry::of::<$type>(stringify!($kernel), stringify!($case)),)+)+
        ];

        /// Each kernel at width 64 as a function of its own, to read its assembly.
        pub mod probe {
            $(
                #[doc = concat!("Cases of `", stringify!($kernel), "`.")]
                pub mod $kernel {
                    #[allow(unused_imports, reason = "what the types are named by may be anywhere in the parent")]
                    use super::super::*;
                    $(
                        #[doc = concat!("`", stringify!($type), "`.")]
                        pub mod $case {
                            #[allow(unused_imports, reason = "what the types are named by may be anywhere in the parent")]
                            use super::super::super::*;
                            $crate::probes!($type);
                        }
                    )+
                }
            )+
        }
    };
}

/// The probes of one kernel: see [`kernels!`](crate::kernels).
#[doc(hidden)]
#[macro_export]
macro_rules! probes {
    ($type:ty) => {
        $crate::probes!($type, Scalar, scalar_64);
        $crate::probes!($type, Sse2, sse2_64);
        #[cfg(target_arch = "x86_64")]
        $crate::probes!($type, Avx2, avx2_64, #[target_feature(enable = "avx2,fma,bmi1,bmi2,popcnt")]);
        #[cfg(target_arch = "x86_64")]
        $crate::probes!(
            $type,
            Avx512,
            avx512_64,
            #[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx2,fma,bmi1,bmi2,popcnt")]
        );
    };
    ($type:ty, $token:ident, $name:ident $(, #[$feature:meta])?) => {
        /// The packet once through the kernel.
        #[allow(clippy::missing_safety_doc, reason = "safe: its token proves the features")]
        #[inline(never)]
        $(#[$feature])?
        pub fn $name(
            token: $crate::simd::$token,
            work: &mut $crate::lab::Work<<$type as $crate::lab::Kernel>::Primitive, 64>,
        ) {
            <$type as $crate::lab::Kernel>::run(token, work);
        }
    };
}
