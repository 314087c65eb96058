//! Volumes: scalar values at the points of regular grids, in one or several steps of time.
//!
//! | file | idea |
//! |---|---|
//! | `grid` | the values of one step, and where in space they are |
//! | `statistics` | which values there are, and how often |
//! | `voxels` | values in the type that they came in |

mod grid;
mod statistics;
mod voxels;

use std::sync::Arc;

pub use grid::{Grid, GridError, GridPlace, MOST_SAMPLES};
pub use statistics::{BINS, Statistics};
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
