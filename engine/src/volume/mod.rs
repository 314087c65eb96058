//! Volumes: scalar values at the points of regular grids, in one or several steps of time.
//!
//! | file | idea |
//! |---|---|
//! | `color_map` | colours by value, without extinction |
//! | `presets` | transfer functions by name |
//! | `transfer` | what values look like: colours and extinction |
//! | `color_space` | the colour spaces that maps are made in |
//! | `grid` | the values of one step, and where in space they are |
//! | `statistics` | which values there are, and how often |
//! | `voxels` | values in the type that they came in |

mod color_map;
pub(crate) mod color_space;
mod grid;
mod presets;
mod statistics;
mod transfer;
mod voxels;

use std::sync::Arc;

pub use color_map::ColorMap;
pub use grid::{Grid, GridError, GridPlace, MOST_SAMPLES};
pub use presets::Preset;
pub use statistics::{BINS, Statistics};
pub(crate) use transfer::joined;
pub use transfer::{MOST_LABELS, MOST_POINTS, Scale, TransferError, TransferFunction, TransferPoint};
pub(crate) use voxels::with_voxels;
pub use voxels::{Samples, Voxels};

/// A volume: one grid a step of time.
#[derive(Clone, Debug)]
pub struct Volume {
    /// What people call it.
    pub name: String,
    /// The steps of time, at least one.
    pub steps: Vec<Arc<Grid>>,
}
