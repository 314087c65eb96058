//! Embree 3 as a peer.
//!
//! | file | what it holds |
//! |---|---|
//! | `bindings.rs` | what of its headers is needed, and all foreign calls |
//! | `tracing.rs` | its interfaces, each a timed loop over rays |

mod bindings;
mod tracing;

pub use bindings::{Device, Quality, Scene};
pub use tracing::{Entry, Interface};
