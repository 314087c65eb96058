//! The kernels of this crate, registered: every test that a walk makes, and what precedes it. Whole traversals, which are
//! the most to compile, are registered by who measures them: [`traversals!`](crate::traversals).

pub mod iso_brick;
pub mod iso_cell;
pub mod medium;
pub mod node;
pub mod rays;
pub mod sphere;
pub mod traversal;
pub mod triangle;

use super::find::{ANY, CLOSEST, Find};
use super::leaves::{COMMON_ORIGIN, FEW, Leaves, PACKET, PARALLEL, SINGLE, STREAM};
use crate::leaf::{SphereBlock, TriangleBlock};
use iso_brick::IsoBrick;
use iso_cell::IsoCell;
use medium::{Absorb, Classify, Sample};
use node::{NodeDiverged, NodePacket, NodeSingle, NodeStream};
use rays::{FrustaSetup, Inverse, Normalize, Shears};

crate::kernels! {
    /// All kernels of this crate and their special cases.
    pub static KERNELS;
    triangle {
        stream: Leaves<TriangleBlock, STREAM>,
        single: Leaves<TriangleBlock, SINGLE>,
        few: Leaves<TriangleBlock, FEW>,
        packet: Leaves<TriangleBlock, PACKET>,
        packet_parallel: Leaves<TriangleBlock, PARALLEL>,
        packet_common_origin: Leaves<TriangleBlock, COMMON_ORIGIN>,
        packet_common_origin_any: Leaves<TriangleBlock, COMMON_ORIGIN, ANY>,
    }
    sphere {
        stream: Leaves<SphereBlock, STREAM>,
        stream_unit: Leaves<SphereBlock, STREAM, CLOSEST, true>,
        single: Leaves<SphereBlock, SINGLE>,
        few: Leaves<SphereBlock, FEW>,
        packet: Leaves<SphereBlock, PACKET>,
        packet_common_origin: Leaves<SphereBlock, COMMON_ORIGIN>,
        packet_common_origin_unit: Leaves<SphereBlock, COMMON_ORIGIN, CLOSEST, true>,
        packet_common_origin_unit_any: Leaves<SphereBlock, COMMON_ORIGIN, ANY, true>,
    }
    iso_cell { general: Find<IsoCell> }
    trilinear { general: Sample<false> }
    nearest_sample { general: Sample<true> }
    classify { general: Classify }
    absorb { general: Absorb }
    iso_brick {
        stream: IsoBrick<STREAM>,
        single: IsoBrick<SINGLE>,
        packet: IsoBrick<PACKET>,
        packet_any: IsoBrick<PACKET, ANY>,
    }
    node_packet { general: NodePacket<false>, common_origin: NodePacket<true> }
    node_diverged { general: NodeDiverged<false>, common_origin: NodeDiverged<true> }
    node_stream { closest: NodeStream<false>, any: NodeStream<true> }
    node_single { general: NodeSingle }
    frusta { general: FrustaSetup<false>, common_origin: FrustaSetup<true> }
    inverse { general: Inverse }
    normalize { general: Normalize }
    shears { general: Shears }
}

#[cfg(feature = "lab-traversal")]
crate::traversals! {
    /// Whole traversals, for tests that have no engine.
    pub static TRAVERSALS;
}
