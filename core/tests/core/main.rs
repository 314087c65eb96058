//! The tests of this crate, in one binary: what they have in common is compiled once.

mod analytic;
mod bad_input;
mod cloud;
mod common;
mod edges;
mod far;
#[path = "../../../simd/tests/common/levels.rs"]
mod levels;
mod march;
mod oracle;
mod outlines;
mod packets;
mod query;
mod refit;
mod regressions;
mod ties;
mod traversal;
mod volume;
