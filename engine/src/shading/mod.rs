//! How hits are coloured, and what materials and renderers share.
//!
//! | file | idea |
//! |---|---|
//! | `shade` | a packet's colours: first what lights its hits, then what each material makes of it |
//! | `openness` | how open the sky is above points: ambient occlusion |
//! | `shadow` | what of a light arrives: the one place that makes any-hit packets |
//! | `textured` | what the textures of a material say at hits |
//! | `secondary` | rays that go on from hits |
//! | `through` | rays that go on through what is opaque in part |

mod openness;
mod secondary;
mod shade;
mod shadow;
mod textured;
mod through;

pub(crate) use openness::openness;
pub use secondary::{trace, trace_weighted};
pub use shade::shade;
use shadow::illuminate;
use textured::{opacities, tilt_normals};
pub use through::see_through;
