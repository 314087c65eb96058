//! What reaches hits from lights. It is found for all hits of a packet at once, whatever their materials are, so that shadow rays go in
//! packets as wide as the rays that they follow (paper 5.4: secondary rays are new packets).
//!
//! | file | idea |
//! |---|---|
//! | `points` | points to light: positions and normals of hits, and where rays that leave them start |
//! | `receivers` | points as lights see them |
//! | `arriving` | what arrives at points from one light, and from all |

mod arriving;
mod points;
mod receivers;

pub use arriving::{Arriving, Illumination, Lighting, Lit};
pub use points::Points;
pub use receivers::Receivers;
