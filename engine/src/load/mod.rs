//! Loaders: files from strangers become a [`SceneDescription`](crate::scene::SceneDescription), or one clear line that names file, line
//! and remedy.
//!
//! | file | idea |
//! |---|---|
//! | `format` | the table of formats, and which one a file is in |
//! | `obj` | OBJ through `tobj`, assembled into one mesh |
//! | `obj_check`, `mtl_check` | what a line must look like before the parser sees it |
//! | `mtl` | materials of OBJ files |
//! | `polygon` | polygons into triangles |
//! | `lines` | the reader that checks line by line |
//! | `input` | plain and gzip files, with a limit on what they unpack to |
//! | `loaded` | what was found in a file |
//! | `error` | [`LoadError`] |

mod error;
mod format;
mod input;
mod lines;
mod loaded;
mod mtl;
mod mtl_check;
mod obj;
mod obj_check;
mod polygon;

pub use error::LoadError;
pub use format::{FORMATS, Format, load};
pub use loaded::{Loaded, Report};
