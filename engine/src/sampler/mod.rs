//! Pixel samplers: which rays a pixel gets, and in which packets (paper 5.4).

mod fill;
mod jittered;
mod kind;
pub mod morton;
mod single;

pub use jittered::Jittered;
pub use kind::SamplerKind;
pub use single::SingleSample;

pub use crate::stack::PixelSampler;
