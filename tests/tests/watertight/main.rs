//! No ray slips out of what is closed, or into it, unseen: not at an edge, not at a vertex, at any level and width, with common origin,
//! without, and alone.
//!
//! `MOBULA_WATERTIGHT_RAYS=10000000 cargo test --release -p mobula-tests --test watertight -- --nocapture` shoots as many at
//! each level, at triangles and at iso-surfaces; by default it is a small share of that.
//!
//! | file | idea |
//! |---|---|
//! | `iso` | iso-surfaces of grids |
//! | `triangles` | closed meshes |
//! | `shoot` | rays in packets of each width, and those that hit nothing |

mod iso;
#[path = "../../../simd/tests/common/levels.rs"]
mod levels;
mod shoot;
mod triangles;
