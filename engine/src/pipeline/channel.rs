//! Viewpoints.

use crate::image::Size;

/// A viewpoint: what is rendered into one picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Channel {
    /// Its name, for messages.
    pub name: String,
    /// The size of its picture.
    pub size: Size,
    /// Whether frames are still rendered for it. A channel that was removed keeps its index.
    pub open: bool,
}
