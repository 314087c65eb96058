//! The kernels of this crate, registered: every test that a walk makes, what precedes it, and whole traversals.
//!
//! `iso_cell` is here before its walk: leaves of volumes will call it.

pub mod iso_cell;
pub mod node;
pub mod rays;
pub mod sphere;
pub mod traversal;
pub mod triangle;

use super::find::{ANY, CLOSEST, Find};
use super::leaves::{COMMON_ORIGIN, Leaves, PACKET, PARALLEL, SINGLE, STREAM};
use crate::leaf::{SphereBlock, TriangleBlock};
use iso_cell::IsoCell;
use node::{Diverged, Packet, Single, Streams};
use rays::{Frusta, Inverse, Normalize, Shears};
use traversal::Traversal;

crate::kernels! {
    /// All kernels of this crate and their special cases.
    pub static KERNELS;
    triangle {
        stream: Leaves<TriangleBlock, STREAM>,
        single: Leaves<TriangleBlock, SINGLE>,
        packet: Leaves<TriangleBlock, PACKET>,
        packet_parallel: Leaves<TriangleBlock, PARALLEL>,
        packet_common_origin: Leaves<TriangleBlock, COMMON_ORIGIN>,
        packet_common_origin_any: Leaves<TriangleBlock, COMMON_ORIGIN, ANY>,
    }
    sphere {
        stream: Leaves<SphereBlock, STREAM>,
        stream_unit: Leaves<SphereBlock, STREAM, CLOSEST, true>,
        single: Leaves<SphereBlock, SINGLE>,
        packet: Leaves<SphereBlock, PACKET>,
        packet_common_origin: Leaves<SphereBlock, COMMON_ORIGIN>,
        packet_common_origin_unit: Leaves<SphereBlock, COMMON_ORIGIN, CLOSEST, true>,
        packet_common_origin_unit_any: Leaves<SphereBlock, COMMON_ORIGIN, ANY, true>,
    }
    iso_cell { general: Find<IsoCell> }
    node_packet { general: Packet<false>, common_origin: Packet<true> }
    node_diverged { general: Diverged<false>, common_origin: Diverged<true> }
    node_stream { general: Streams }
    node_single { general: Single }
    frusta { general: Frusta<false>, common_origin: Frusta<true> }
    inverse { general: Inverse }
    normalize { general: Normalize }
    shears { general: Shears }
    traversal {
        all: Traversal<{ traversal::INCOHERENT }, CLOSEST, true>,
        diffuse: Traversal<{ traversal::INCOHERENT }, CLOSEST, false>,
        ambient_occlusion: Traversal<{ traversal::INCOHERENT }, ANY, false>,
        primary: Traversal<{ traversal::COMMON_ORIGIN }, CLOSEST, false>,
        shadow: Traversal<{ traversal::COMMON_ORIGIN }, ANY, false>,
        sun: Traversal<{ traversal::PARALLEL }, ANY, false>,
    }
}
