//! Ray packets, kernels, traversal.
#![no_std]

extern crate alloc;

pub mod any_hit;
pub mod bvh;
pub mod column;
pub mod kernel;
#[cfg(feature = "lab")]
pub mod lab;
pub mod oracle;
pub mod packet;
pub mod properties;
pub mod rays;
pub mod sub_packet;
pub mod traverse;

pub use any_hit::AnyHitPacket;
pub use bvh::Bvh;
pub use column::{Column, Columns3};
pub use glam;
pub use mobula_simd as simd;
pub use packet::{Hits, NO_HIT, RayPacket};
pub use properties::Properties;
pub use rays::Rays;
pub use sub_packet::{SubPacket, Surface};
