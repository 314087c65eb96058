//! What materials share: points to shade, what reaches them from lights, and rays that go on from them.

mod points;
mod secondary;
mod shadow;

pub use points::Points;
pub use secondary::trace;
pub use shadow::illuminate;
