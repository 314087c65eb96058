//! The scene: as loaders make it, and ready to be rendered.
//!
//! [`SceneDescription`] is what loaders and generators make; [`show`] adds what its volumes are shown as; [`build`] makes a [`Scene`]
//! of it, with structures that find hits.
//!
//! | file | idea |
//! |---|---|
//! | `build` | a scene made ready to be rendered |
//! | `front` | from where it is seen best |
//! | `bulk` | where most of a scene is |
//! | `volumes` | surfaces and media are made of volumes |
//! | `description` | what is in a scene |
//! | `ground` | a ground under a scene |
//! | `particles` | geometry is made of particles |
//! | `particle_look` | what particles are shown as |
//! | `particle_notes` | what people are told of particles |
//! | `particle_steps` | the steps of particles made ready for rays |
//! | `shown` | what a volume is shown as |
//! | `rendering` | how a scene is to be rendered |

mod build;
mod bulk;
mod description;
mod front;
mod ground;
mod particle_look;
mod particle_notes;
mod particle_steps;
mod particles;
mod rendering;
mod shown;
mod volumes;

pub use build::{build, with_geometry};
pub use description::{Object, SceneDescription};
pub use ground::Ground;
pub use particle_look::{ColorBy, Map, OpacityBy, ParticleLook};
pub use particle_notes::{ParticleError, ParticleNote};
pub(crate) use particles::color_map;
pub use particles::{GRAIN, grain, show_particles};
pub use rendering::{Rendering, Time};
pub use shown::{Shown, Transfer};
pub use volumes::{Notes, ShowError, Steps, show};

pub use crate::geometry::{Geometries, Geometry, Mesh, MeshGroup, NeedsRebuild, SceneError, Spheres};
pub use crate::stack::Scene;
