//! Pictures on surfaces.
//!
//! | file | idea |
//! |---|---|
//! | `picture` | pictures as files have them |

mod picture;

pub use picture::{Picture, Texels};
