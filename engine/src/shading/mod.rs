//! What materials share: points to shade, what reaches them from lights, and rays that go on from them. What renderers
//! share: rays that go on through what is opaque in part.

mod points;
mod secondary;
mod shadow;
mod through;

pub use points::Points;
pub use secondary::trace;
pub use shadow::illuminate;
pub use through::see_through;
