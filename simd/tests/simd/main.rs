//! The lanes of every level against their twins and against plain Rust. One binary: the crates under it are linked once.

mod cases;
// Tests of the other crates read this file too.
#[path = "../common/levels.rs"]
mod levels;
mod memory;
mod operations;
mod wide;
