//! Pixel samplers: which rays a pixel gets, and in which packets (paper 5.4).

mod adaptive;
mod fill;
mod film;
mod filter;
mod kind;
mod middle;
pub mod morton;
mod single;
mod sobol;

pub use adaptive::Adaptive;
pub use film::Film;
pub use filter::Filter;
pub use kind::SamplerKind;
pub use middle::look;
pub use single::SingleSample;
pub use sobol::Sobol;

use crate::math::hash;
pub use crate::stack::PixelSampler;

/// What scrambles the sequence of a pixel.
#[inline(always)]
fn pixel_seed([x, y]: [u32; 2]) -> u32 {
    hash(x ^ hash(y ^ 0x9e37_79b9))
}
