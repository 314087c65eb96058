//! Where a camera stands and looks: plain data, with the operations of a viewer.

use glam::Vec3;

/// Which axis of a model points up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Up {
    /// The y axis, as most modellers have it.
    #[default]
    Y,
    /// The z axis, as engineering and geography have it.
    Z,
}

/// A point of view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Where the eye is.
    pub eye: Vec3,
    /// What it looks at; orbits turn around it.
    pub at: Vec3,
    /// Which way is up; need not be perpendicular to anything.
    pub up: Vec3,
    /// Vertical field of view, degrees.
    pub fov: f32,
}
