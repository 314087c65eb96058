//! Scene files: TOML that says what other files hold is shown as, and from where. `SCENES.md`, beside this file, says what may stand in
//! them.
//!
//! | file | idea |
//! |---|---|
//! | `write` | what is shown as a scene file |
//! | `assemble` | the scene of a file |
//! | `surroundings` | background, camera and what else concerns the whole scene |
//! | `lights` | where light comes from |
//! | `objects` | objects become geometry and volumes |
//! | `particles` | objects of particles |
//! | `parts` | the files that objects name |
//! | `named` | materials, transfer functions and colour maps that have names |
//! | `keys` | which keys there are |
//! | `object_keys` | those of objects |
//! | `values` | what may stand behind keys |
//! | `textures` | textures of materials |
//! | `text` | where in the text something is wrong, and what may have been meant |

mod assemble;
mod keys;
mod lights;
mod named;
mod object_keys;
mod objects;
mod particles;
mod parts;
mod surroundings;
mod text;
mod textures;
mod values;
mod write;

pub(super) use assemble::{load, looks_like};
pub use parts::BUILT_IN;
pub use write::{Changes, SavedParticles, SavedScene};
