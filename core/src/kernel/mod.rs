//! Intersection kernels: one body each, generic over lanes. Whether lanes are rays and the primitive is the same in all
//! of them (packets), or lanes are primitives and the ray is the same (single rays), or four lanes each are a ray and four
//! primitives (a few rays), is the caller's: what is the same for all lanes is hoisted into a splat, and the bits stay the
//! same.
//!
//! No closures touch lanes here or in traversal: a closure is a function of its own, compiled without the level's
//! instructions unless the optimiser happens to inline it.

pub mod aabb;
pub mod absorb;
pub mod boxes;
pub mod cell_walk;
pub mod classify;
pub mod diverged;
pub mod edges;
pub mod few;
pub mod frusta;
pub mod group_bounds;
pub mod group_shears;
pub mod groups;
pub mod iso_cell;
pub mod margin;
pub mod outline;
pub mod single;
pub mod sphere;
pub mod stream;
pub mod triangle;
pub mod trilinear;
pub mod words;
