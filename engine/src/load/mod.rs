//! Loaders: files from strangers become a [`SceneDescription`](crate::scene::SceneDescription), or one clear line that names file, line
//! and remedy.
//!
//! | file | idea |
//! |---|---|
//! | `format` | the table of formats, and which one a file is in |
//! | `scene_file` | scene files: what other files hold, put together |
//! | [`series`] | patterns of names; files that are steps of time of one volume |
//! | `memory` | how much memory steps of time may take |
//! | `options` | how a file is loaded, beside what it says itself |
//! | `obj`, `obj_pieces`, `obj_read` | OBJ: one mesh of what its statements say; threads that read pieces; the statements |
//! | `mtl`, `mtl_check`, `mtl_maps` | materials of OBJ files through `tobj`; what a line must look like before it sees it; their textures |
//! | `textures` | pictures that a model wants, each once |
//! | `gltf` | glTF and GLB: meshes, materials, a camera, lights |
//! | `ply` | PLY: a mesh, or particles |
//! | `stl` | STL: triangles as text or binary |
//! | `particles` | CSV, XYZ, dumps of LAMMPS and raw numbers: particles |
//! | `volume` | NRRD, NIfTI, MetaImage and raw voxels: one volume |
//! | `transfer` | transfer functions |
//! | `environment` | pictures that show everything around a scene |
//! | [`picture`] | pictures for textures and environments |
//! | `polygon` | polygons into triangles |
//! | `place` | moves what is far from the origin, scales what is tiny or huge |
//! | `lines` | text line by line |
//! | `plain` | plain numbers, fast |
//! | `pieces` | text in pieces that threads read at the same time |
//! | `beside` | files that a model names |
//! | `input` | plain and gzip files, with a limit on what they unpack to |
//! | `binary` | numbers out of bytes |
//! | `text` | numbers as programs write them; names made safe to show |
//! | `loaded` | what was found in a file |
//! | `error` | [`LoadError`] |

mod beside;
mod binary;
mod environment;
mod error;
mod format;
mod gltf;
mod input;
mod lines;
mod loaded;
mod memory;
mod mtl;
mod mtl_check;
mod mtl_maps;
mod obj;
mod obj_pieces;
mod obj_read;
mod options;
mod particles;
pub mod picture;
mod pieces;
mod place;
mod plain;
mod ply;
mod polygon;
mod scene_file;
pub mod series;
mod stl;
mod text;
mod textures;
mod transfer;
mod volume;

pub use environment::{PICTURES, environment, is_picture};
pub use error::LoadError;
pub use format::{FORMATS, Format, SCENE_FILE, load, load_with};
pub use loaded::{Loaded, Report};
pub use memory::Memory;
pub use options::{Load, NoLayout, Options, Raw, RawParticles};
pub use place::Place;
pub use scene_file::{BUILT_IN, Changes, SavedParticles, SavedScene};
pub use text::printable;
pub use transfer::load_transfer;
pub use volume::{NoVoxelType, VoxelType};
