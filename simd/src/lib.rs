//! What a lane is: vectors of `f32`, `i32` and truth values at every instruction set, written against one trait.
//!
//! A **level** is an instruction set; a **token** is a value that proves that this machine has it. Lane values come
//! only from tokens, so all of this crate's public functions are safe, and a kernel is written once:
//!
//! ```
//! use mobula_simd::{AnyToken, F32Lanes, Task, Token};
//!
//! /// The dot product of two packets of 64 numbers.
//! struct Dot<'a>(&'a [f32; 64], &'a [f32; 64]);
//!
//! impl Task for Dot<'_> {
//!     type Output = f32;
//!     #[inline(always)]
//!     fn run<T: Token>(self, token: T) -> f32 {
//!         let mut sum = token.splat(0.0);
//!         for at in (0..64).step_by(T::LANES) {
//!             sum = token.load(self.0, at).mul_add(token.load(self.1, at), sum);
//!         }
//!         sum.reduce_add()
//!     }
//! }
//!
//! // Once per program: what has this machine got? Once per packet: enter that level and work there.
//! let token = AnyToken::detect();
//! assert_eq!(token.run(Dot(&[0.5; 64], &[2.0; 64])), 64.0);
//! ```
//!
//! A token cannot be forged, nor can a lane value, which is as good as one:
//!
//! ```compile_fail,E0423
//! let forged = mobula_simd::Avx512(());
//! ```
//! ```compile_fail,E0599
//! let forged = mobula_simd::Avx2::default();
//! ```
//! ```compile_fail,E0277
//! let forged: mobula_simd::Fused = bytemuck::Zeroable::zeroed();
//! ```
//! ```compile_fail,E0277
//! let forged: <mobula_simd::Avx2 as mobula_simd::Token>::F32 = bytemuck::Zeroable::zeroed();
//! ```
//! ```compile_fail,E0277
//! let forged: <mobula_simd::Avx512 as mobula_simd::Token>::Mask = bytemuck::cast(0u16);
//! ```
//! ```compile_fail,E0599
//! let forged = mobula_simd::avx2::Avx2F32::default();
//! ```
//!
//! # Map
//!
//! Each module uses only what stands below it in this table.
//!
//! | module | idea |
//! |---|---|
//! | [`dispatch`] | [`AnyToken`]: detection, choice at run time, `MOBULA_ISA`; [`Twin`]: what it is checked against |
//! | `avx512` | `Avx512`: 16 lanes, fused; x86_64 only |
//! | `fused` | `Fused`: 1 lane, fused, the twin of both; x86_64 only |
//! | `avx2` | `Avx2`: 8 lanes, fused; x86_64 only |
//! | [`sse2`] | [`Sse2`]: 4 lanes, unfused, everywhere (NEON on aarch64, simd128 on wasm) |
//! | [`scalar`] | [`Scalar`]: 1 lane, unfused, everywhere |
//! | [`one_lane`] | the lanes of [`Scalar`] and `Fused`, the twins that the others must equal bit for bit |
//! | [`lanes`] | the traits: what every level can do, and the numeric contract |
//! | [`level`] | the names of the instruction sets |
//! | [`pages`] | memory in large pages |
//! | [`clock`] | what kernels are measured with |
//!
//! Without the default feature `std` the crate is `no_std`, and loses only `AnyToken::from_env`.
#![no_std]
#[cfg(any(feature = "std", test))]
extern crate std;

#[cfg(target_arch = "x86_64")]
pub mod avx2;
#[cfg(target_arch = "x86_64")]
pub mod avx512;
pub mod clock;
pub mod dispatch;
#[cfg(target_arch = "x86_64")]
pub mod fused;
pub mod lanes;
pub mod level;
pub mod one_lane;
pub mod pages;
mod prefetch;
pub mod scalar;
pub mod sse2;
mod window;

#[cfg(target_arch = "x86_64")]
pub use avx2::Avx2;
#[cfg(target_arch = "x86_64")]
pub use avx512::Avx512;
#[cfg(feature = "std")]
pub use dispatch::EnvError;
pub use dispatch::{AnyToken, Dispatch, Twin, Unavailable};
#[cfg(target_arch = "x86_64")]
pub use fused::Fused;
pub use lanes::{F32Lanes, I32Lanes, MaskLanes, Task, Token};
pub use level::{Level, UnknownLevel};
pub use prefetch::prefetch;
pub use scalar::Scalar;
pub use sse2::Sse2;
/// The vectors that the lanes convert to and from.
pub use wide;
