//! The kernels of this crate, registered. Special cases that were measured not to pay are not here: see
//! `benches/record`.

pub mod children;
pub mod iso_cell;
pub mod packet_operations;
pub mod slab;
pub mod sphere;
pub mod triangle;

use super::find::{ANY, Find};
use children::{Beams, Children};
use iso_cell::IsoCell;
use packet_operations::{Bounds, Frustum, Inverse, Normalize, Shears};
use slab::Slab;
use sphere::Sphere;
use triangle::Triangle;

crate::kernels! {
    /// All kernels of this crate and their special cases.
    pub static KERNELS;
    triangle {
        general: Find<Triangle<{ triangle::GENERAL }>>,
        constant_axis: Find<Triangle<{ triangle::CONSTANT_AXIS }>>,
        common_origin: Find<Triangle<{ triangle::COMMON_ORIGIN }>>,
        common_origin_any: Find<Triangle<{ triangle::COMMON_ORIGIN }>, ANY>,
        common_origin_corners: Find<Triangle<{ triangle::CORNERS }>>,
    }
    sphere {
        general: Find<Sphere<false, false>>,
        common_origin: Find<Sphere<true, false>>,
        unit: Find<Sphere<false, true>>,
        common_origin_unit: Find<Sphere<true, true>>,
        common_origin_unit_any: Find<Sphere<true, true>, ANY>,
    }
    slab {
        general: Slab<{ slab::GENERAL }>,
        common_origin: Slab<{ slab::COMMON_ORIGIN }>,
        constant_signs: Slab<{ slab::CONSTANT_SIGNS }>,
        common_origin_constant_signs: Slab<{ slab::COMMON_ORIGIN_CONSTANT_SIGNS }>,
    }
    children {
        general: Children<{ children::GENERAL }>,
        sorted: Children<{ children::SORTED }>,
        sorted_fused: Children<{ children::SORTED_FUSED }>,
    }
    beam { general: Beams }
    iso_cell { general: Find<IsoCell> }
    inverse { general: Inverse }
    normalize { general: Normalize }
    shears { general: Shears }
    bounds { general: Bounds<false>, common_origin: Bounds<true> }
    frustum { general: Frustum }
}
