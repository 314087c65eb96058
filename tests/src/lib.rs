//! Helpers of the tests that cross crates; the tests are in `tests/tests/`.

pub mod mesh;
