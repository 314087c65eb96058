//! Packets whose width is a number: what everything above intersection works on.
//!
//! Kernels are compiled for a few packet widths ([`PacketWidth`]). Above them nothing depends on the width: cameras, samplers,
//! renderers, materials and lights see columns, one value a ray, as slices of the rays in question. Rays are kept by the packets of
//! `mobula-core`, behind [`Rays`]; what pictures need beside them is in [`Packet`].
//!
//! | file | idea |
//! |---|---|
//! | `sub_packet` | a range of a packet's rays without a copy; values derived once, when first asked for |
//! | `footprint` | how much of a surface a ray stands for |
//! | `forward` | normals turned to the side that rays come from |
//! | `closest` | rays with their hits, and room for shading |
//! | `any_hit` | rays of which only is asked whether they get through |
//! | `rays` | origins, directions and intervals of rays, whatever the width |
//! | `intersect` | what finds hits at every width |
//! | `depth` | how much of the light gets through surfaces |
//! | `width` | the table of widths |
//! | `surface` | hits as geometry sees them, and what it tells of them |
//! | `column` | one value of every ray, 64-byte aligned |

mod any_hit;
mod closest;
mod column;
mod depth;
mod footprint;
mod forward;
mod intersect;
mod rays;
mod sub_packet;
mod surface;
#[cfg(test)]
mod tests;
mod width;

pub use any_hit::AnyHitPacket;
pub use closest::{Found, Packet, Run};
pub use column::{Column, Columns3, add_vec3, columns3, part, part_mut, set_vec3, vec3};
pub use depth::{optical_depth, transmittance};
pub use intersect::{EveryWidth, Intersect};
pub use rays::Rays;
pub use sub_packet::SubPacket;
pub use surface::{Hits, Surface};
pub use width::{PacketWidth, UnknownWidth};
