//! Volumes from files: NRRD, NIfTI, MetaImage, and files of nothing but voxels. Coordinates are those of the file; no format's
//! directions of the body are turned into another's.
//!
//! A header is checked before anything is read that it speaks of, and memory is taken as voxels are read: a small file with a
//! header that lies costs little.
//!
//! | file | idea |
//! |---|---|
//! | `nrrd`, `nrrd_axes` | NRRD: its fields; which axes are space and time |
//! | `nifti`, `nifti_header` | NIfTI-1 and -2; where the fields of their headers are |
//! | `meta_image` | MetaImage |
//! | `raw` | voxels without a header |
//! | `fields` | headers of text |
//! | `header` | what every header says in the end; the scene of a volume |
//! | `layout` | how many voxels there are, in which order |
//! | `source` | bytes: skipped, unpacked, of a file beside the header |
//! | `read` | voxels from bytes or text, as many as there should be |
//! | `filling` | grids that grow as voxels come |
//! | `voxel_type` | the types of voxels |

mod fields;
mod filling;
mod header;
mod layout;
pub(super) mod meta_image;
pub(super) mod nifti;
mod nifti_header;
pub(super) mod nrrd;
mod nrrd_axes;
pub(super) mod raw;
mod read;
mod source;
mod voxel_type;

pub use voxel_type::{NoVoxelType, VoxelType};
