//! What a lane is.
#![no_std]
pub mod lanes;
pub use lanes::*;
/// An instruction set.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Level {
    /// One lane.
    Scalar,
    /// Four.
    Sse2,
    /// Eight.
    Avx2,
    /// Sixteen.
    Avx512,
}
