//! Volumes: scalar values at the points of regular grids, in one or several steps of time.
//!
//! | file | idea |
//! |---|---|
//! | `grid` | the values of one step, and where in space they are |
//! | `voxels` | values in the type that they came in |

mod grid;
mod voxels;

use std::sync::Arc;

pub use grid::{Grid, GridError, GridPlace, MOST_SAMPLES};
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
