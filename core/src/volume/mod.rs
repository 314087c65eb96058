//! Volumes: surfaces of equal value in a grid of samples, found without triangles; and media that samples describe.
//!
//! A grid is parted into bricks of 8 x 4 x 4 cells. Above them is an implicit hierarchy: a node is the least and the greatest value
//! of what is in it, its box follows from its indices. It does not depend on the iso value, so that a change of that costs nothing
//! (Wald, Friedrich, Marmitt, Slusallek and Seidel, "Faster Isosurface Ray Tracing using Implicit KD-Trees", TVCG 2005; with eight
//! children a node as Knoll, Wald and Hansen, "Coherent Multiresolution Isosurface Ray Tracing", The Visual Computer 2009).
//!
//! | file | idea |
//! |---|---|
//! | `march` | light through a medium |
//! | `steps` | the way of rays through a brick |
//! | `lighting` | lights that shine on a medium |
//! | `passage` | the ways of rays through a grid |
//! | `iso` | the tree of an iso-surface, as walks see it |
//! | `in_brick` | how rays meet the surface in a brick |
//! | `cells` | which cells of a brick a surface passes through, and their corners |
//! | `field` | a grid with its hierarchy, whatever type its samples have |
//! | `ranges` | least and greatest values, built from the bricks up |
//! | `layout` | which bricks there are, and which node is made of which |
//! | `brick` | the samples of a brick as floats |
//! | `samples` | the same for rays that go through it, with gradients |
//! | `voxel` | types of samples |

mod brick;
mod cells;
mod field;
mod in_brick;
mod iso;
mod layout;
mod lighting;
mod march;
mod passage;
mod ranges;
mod samples;
mod steps;
mod voxel;

pub use brick::{Brick, CELLS};
pub use field::{Field, GridField};
pub use iso::IsoTree;
pub use layout::{Layout, TooLarge};
pub use lighting::{LightRows, Lighting};
pub use march::{Between, March, MarchTask, Marched};
pub use passage::{Passages, Segments, WIDTH};
pub use ranges::{NodeRanges, Ranges};
pub use samples::BrickSamples;
pub use voxel::Voxel;
