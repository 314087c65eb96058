//! Particles from files: tables of numbers, of which three columns are positions.
//!
//! Nothing is stored before it is read, so that a small file that speaks of many particles costs little. Coordinates are those of the
//! file; what is not finite is left out and counted.
//!
//! | file | idea |
//! |---|---|
//! | `csv` | CSV, and tables with other separators |
//! | `xyz`, `extended` | XYZ; what the second line of an extended XYZ file says |
//! | `lammps` | text dumps of LAMMPS |
//! | `raw` | numbers without a header |
//! | `rows` | lines of text into columns |
//! | `frames` | the frames of a file become the steps of particles |
//! | `columns` | numbers by column |
//! | `names` | what columns mean, by their names |
//! | `periodic` | the periodic box, as comments give it |

mod columns;
pub(super) mod csv;
mod extended;
mod frames;
pub(super) mod lammps;
mod names;
mod periodic;
pub(super) mod raw;
mod rows;
pub(super) mod xyz;

pub(super) use columns::{Columns, Storage};
pub(super) use frames::{Frame, Frames};
pub(super) use names::axes;
pub(super) use periodic::of_comment;
