//! The kernel lab: write a kernel once, get every width, level, proof and measurement from one line of registration.
//!
//! A kernel is a type that implements [`RayTest`] (which primitive does each ray hit?) or [`Kernel`] (anything else);
//! its special cases are the same type with other const parameters. [`kernels!`](crate::kernels) registers them.
#![doc = include_str!("TUNING.md")]
//!
//! # Map
//!
//! Each module uses only what stands below it.
//!
//! | module | idea |
//! |---|---|
//! | [`kernels`](mod@kernels) | the kernels of this crate |
//! | [`register`] | the macro |
//! | [`entry`] | the registry: checks and measurements of a kernel by name |
//! | `cases` | the cases of a kernel: drawn, and timed |
//! | `table` | kernels as values, at the packet widths that are compiled |
//! | [`leaves`] | kernels that test a leaf, as walks do |
//! | [`find`] | kernels that ask which primitive each ray hits |
//! | [`kernel`] | what a kernel tells the lab |
//! | [`outcome`] | what came out |
//! | [`draft`] | a case: rays, primitives, the active range |
//! | [`dice`] | where inputs come from: a seed or bytes |

mod cases;
pub mod dice;
pub mod draft;
pub mod entry;
pub mod find;
pub mod kernel;
pub mod kernels;
pub mod leaves;
pub mod outcome;
pub mod register;
mod table;

pub use dice::{Dice, Style};
pub use draft::{Draft, DraftRay};
pub use entry::{Counterexample, Entry, Plan, Row, filtered};
pub use find::{ANY, CLOSEST, Find, RayTest};
pub use kernel::{Kernel, Work};
pub use kernels::KERNELS;
#[cfg(feature = "lab-traversal")]
pub use kernels::TRAVERSALS;
pub use leaves::{LabBlock, Leaves};
pub use outcome::Outcome;
pub use table::WIDTHS;
