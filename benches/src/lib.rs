//! What the benches share.
//!
//! | file | what it holds |
//! |---|---|
//! | [`scenes`] | the scenes of the peer bench and their cameras |
//! | [`rays`] | the rays that every peer gets, and the results that every peer gives |
//! | [`secondary`] | shadow, occlusion and bounce rays made from primary hits |
//! | [`packets`] | Mobula's timed loop |
//! | `embree` | Embree's (with the feature `embree`) |
//! | [`others`] | those of further peers (with the feature `peers`) |
//! | [`verdict`] | whether two peers found the same |
//! | [`voxels`] | meshes as voxels |
//! | [`kernels`] | the kernels of the lab and whole traversals |
//! | [`report`] | tables and JSON |
//! | [`clock`] | thread time, cycles, the machine |

pub mod clock;
#[cfg(feature = "embree")]
pub mod embree;
pub mod others;
pub mod packets;
pub mod rays;
pub mod report;
pub mod scenes;
pub mod secondary;
pub mod verdict;
pub mod voxels;

mobula_core::traversals! { static TRAVERSALS; }

/// All kernels of the lab, then whole traversals.
pub fn kernels() -> Vec<mobula_core::lab::Entry> {
    [mobula_core::lab::KERNELS, TRAVERSALS].concat()
}
