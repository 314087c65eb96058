//! Pictures on surfaces.
//!
//! | file | idea |
//! |---|---|
//! | `maps` | the textures that a material may have |
//! | `map` | a texture, and how it lies on a surface |
//! | `pyramid` | pictures in ever smaller copies, and what is seen of them through a footprint |
//! | `picture` | pictures as files have them |

mod map;
mod maps;
mod picture;
mod pyramid;

pub use map::Map;
pub use maps::{ChannelMap, Maps, NormalMap, OpacityMap};
pub use picture::{Picture, Texels};
pub use pyramid::{Encoding, Texture, Wrap};
