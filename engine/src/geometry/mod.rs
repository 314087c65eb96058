//! What rays can hit: one file a kind, all behind one trait.
//!
//! | file | idea |
//! |---|---|
//! | `table` | the kinds that there are, with an example of each |
//! | `geometries` | all geometry of a scene under one top-level structure |
//! | `group` | a structure and the geometries in it |
//! | `runs` | rays that hit, in runs of one geometry and material |
//! | `mesh_sequence` | a mesh that changes with time |
//! | `smooth` | normals for the corners of meshes that have none |
//! | `fans` | which corners of triangles are at one point |
//! | `mesh`, `triangle` | triangles with shared corners; the surface of one |
//! | `spheres` | spheres |
//! | `particles` | particles over time, cropped and coloured by their attributes |
//! | `opacity` | how opaque particles are, by the values of an attribute |
//! | `cloud` | the particles of one step, made ready for rays |
//! | `cloud_series` | a cloud for each step of time, in memory or made when it is wanted |
//! | `ball` | what is known of the surface of a sphere |
//! | `iso_surface` | surfaces of equal value in a volume |
//! | `field`, `gradient` | a volume made ready for rays; how its values change |
//! | `tree` | geometries of one kind in one bounding volume hierarchy |
//! | `weld` | which points are equal |
//! | `kind` | the traits: what a kind of geometry is, and what finds its hits |
//! | `census` | bounds, counts by name, and what is left out |
//!
//! A new kind is a file with its data and the trait [`Geometry`], and a line in [`KINDS`]. With [`InTree`] the hierarchy comes for free.

mod ball;
mod census;
mod cloud;
mod cloud_series;
mod fans;
mod field;
mod geometries;
mod gradient;
mod group;
mod iso_surface;
mod kind;
mod mesh;
mod mesh_sequence;
mod opacity;
mod particles;
mod runs;
mod smooth;
mod spheres;
mod table;
mod tree;
mod triangle;
mod weld;

pub use census::{Census, Item, Role};
pub use cloud::{Cloud, TooManyParticles};
pub use cloud_series::{CloudSeries, Make};
pub use field::{Field, Series};
pub use geometries::{Geometries, NeedsRebuild, SceneError};
pub use gradient::Gradient;
pub use group::{Depths, Meeting, Translucent};
pub use iso_surface::IsoSurfaces;
pub use kind::{DEFAULT_MATERIAL, Geometry, Structure, draw, shift_material};
pub use mesh::{Mesh, MeshGroup, NO_INDEX};
pub use mesh_sequence::MeshSequence;
pub use opacity::{Opacity, OpacityCurve, OpacityError};
pub use particles::{Coloring, Cropping, Particles};
pub use smooth::CREASE_ANGLE;
pub use spheres::Spheres;
pub use table::{KINDS, Kind};
pub use tree::{InTree, Tree};
pub(crate) use weld::Weld;
